-- SPDX-License-Identifier: MIT
--
-- gc_board on the pins of the Tang Nano 20K. Encoders, drives, brakes and emergency stop are on its two rows of pins:
-- see tang_nano_20k.cst.
--
-- The serial line is that of the USB socket. The button S1 resets. The light LED0 is on while an axis is released.
-- Latency: that of gc_board.

library ieee;
  use ieee.std_logic_1164.all;

library work;
  use work.gc_network_pkg.all;

entity tang_nano_20k is
  generic (
    baud_g           : positive := 1_000_000;
    -- Silence that ends a frame, us, see gc_serial_system.
    gap_us_g         : natural := 1750;
    full_scale_ua_g  : positive := 5_000_000;
    selftest_g       : boolean := false;
    -- Clocks per step of the desk's axes.
    desk_step_g      : positive := 64;
    lanes_g          : positive := 1;
    loadable_g       : boolean := true;
    brake_feedback_g : boolean := false;
    motion_g         : boolean := false;
    record_bits_g    : positive := 12
  );
  port (
    clk_27mhz  : in    std_ulogic;
    uart_rx    : in    std_ulogic;
    uart_tx    : out   std_ulogic;
    reset      : in    std_ulogic;
    led_n      : out   std_ulogic;
    enc_a      : in    std_ulogic_vector(axes_c - 1 downto 0);
    enc_b      : in    std_ulogic_vector(axes_c - 1 downto 0);
    enc_z      : in    std_ulogic_vector(axes_c - 1 downto 0);
    enc_error  : in    std_ulogic_vector(axes_c - 1 downto 0);
    brake_fed  : in    std_ulogic_vector(axes_c - 1 downto 0);
    estop_n    : in    std_ulogic;
    pwm_up     : out   std_ulogic_vector(axes_c - 1 downto 0);
    pwm_down   : out   std_ulogic_vector(axes_c - 1 downto 0);
    drive_on   : out   std_ulogic;
    brake_free : out   std_ulogic_vector(axes_c - 1 downto 0);
    brake_hold : out   std_ulogic_vector(axes_c - 1 downto 0)
  );
end entity tang_nano_20k;

architecture rtl of tang_nano_20k is

  signal led : std_ulogic_vector(7 downto 0);

begin

  led_n <= not led(1);

  i_board : entity work.gc_board
    generic map (
      oscillator_hz_g  => 27_000_000,
      baud_g           => baud_g,
      gap_us_g         => gap_us_g,
      full_scale_ua_g  => full_scale_ua_g,
      selftest_g       => selftest_g,
      desk_step_g      => desk_step_g,
      lanes_g          => lanes_g,
      loadable_g       => loadable_g,
      brake_feedback_g => brake_feedback_g,
      motion_g         => motion_g,
      record_bits_g    => record_bits_g,
      adc_g            => false,
      adc_zero_g       => 0,
      adc_scale_g      => 0
    )
    port map (
      clk_osc       => clk_27mhz,
      pin_reset     => reset,
      pin_rx        => uart_rx,
      pin_tx        => uart_tx,
      pin_a         => enc_a,
      pin_b         => enc_b,
      pin_z         => enc_z,
      pin_error     => enc_error,
      pin_estop_n   => estop_n,
      pin_brake_fed => brake_fed,
      pin_pwm_up    => pwm_up,
      pin_pwm_down  => pwm_down,
      pin_enable    => drive_on,
      pin_release   => brake_free,
      pin_engage    => brake_hold,
      pin_adc_cs_n  => open,
      pin_adc_sclk  => open,
      pin_adc_mosi  => open,
      pin_adc_miso  => '0',
      led           => led
    );

end architecture rtl;
