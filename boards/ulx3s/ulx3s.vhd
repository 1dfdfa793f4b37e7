-- SPDX-License-Identifier: MIT
--
-- gc_board on the pins of the ULX3S. Encoders, drives, brakes and emergency stop are on J1 and J2: see ulx3s.lpf.
--
-- The serial line is that of the USB socket US1. Button PWR resets. Light 0: the PLL is locked; 1: an axis is released;
-- 2: interrupt, so a fault or the end of loading.
-- Latency: that of gc_board.

library ieee;
  use ieee.std_logic_1164.all;

library work;
  use work.gc_network_pkg.all;

entity ulx3s is
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
    record_bits_g    : positive := 12;
    -- Of the currents at the board's ADC: code of none, and uA per code with 8 bits behind the point: 5 A in 2048.
    adc_zero_g       : natural := 2048;
    adc_scale_g      : integer := 625_000
  );
  port (
    clk_25mhz  : in    std_ulogic;
    -- Names of the board: from the computer, to the computer.
    ftdi_txd   : in    std_ulogic;
    ftdi_rxd   : out   std_ulogic;
    -- Low while pressed.
    btn_pwr_n  : in    std_ulogic;
    -- Keeps the board on.
    wifi_gpio0 : out   std_ulogic;
    led        : out   std_ulogic_vector(7 downto 0);
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
    brake_hold : out   std_ulogic_vector(axes_c - 1 downto 0);
    adc_csn    : out   std_ulogic;
    adc_sclk   : out   std_ulogic;
    adc_mosi   : out   std_ulogic;
    adc_miso   : in    std_ulogic
  );
end entity ulx3s;

architecture rtl of ulx3s is

  signal pressed : std_ulogic;

begin

  pressed <= not btn_pwr_n;
  wifi_gpio0 <= '1';

  i_board : entity work.gc_board
    generic map (
      oscillator_hz_g  => 25_000_000,
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
      -- Its inputs are pins of the fourth axis.
      adc_g            => axes_c <= 3,
      adc_zero_g       => adc_zero_g,
      adc_scale_g      => adc_scale_g
    )
    port map (
      clk_osc       => clk_25mhz,
      pin_reset     => pressed,
      pin_rx        => ftdi_txd,
      pin_tx        => ftdi_rxd,
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
      pin_adc_cs_n  => adc_csn,
      pin_adc_sclk  => adc_sclk,
      pin_adc_mosi  => adc_mosi,
      pin_adc_miso  => adc_miso,
      led           => led
    );

end architecture rtl;
