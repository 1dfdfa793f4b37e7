-- SPDX-License-Identifier: MIT
--
-- What every board holds between its pins: PLL, reset, gc_serial_system, a PWM per axis and, where the board has one, the
-- serial ADC that reads their currents; or, for a board on a desk without a robot, an axis with its encoder and brake in
-- place of the pins, whose current is the one commanded.
--
-- Registers and the line run on the oscillator, the core on the PLL: each side watches the other's clock.
-- Latency: see gc_serial_system.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_network_pkg.all;

entity gc_board is
  generic (
    -- Hz of clk_osc; the core's clock is that of the machine, which the PLL makes.
    oscillator_hz_g  : positive;
    -- Bits per second on the serial line.
    baud_g           : positive;
    -- Silence that ends a frame, us, see gc_serial_system.
    gap_us_g         : natural;
    -- Current at full duty of the PWM, uA.
    full_scale_ua_g  : positive;
    -- Whether the desk's axes take the place of the pins.
    selftest_g       : boolean;
    -- Clocks per step of those.
    desk_step_g      : positive;
    -- Those of gc_system.
    lanes_g          : positive;
    loadable_g       : boolean;
    brake_feedback_g : boolean;
    motion_g         : boolean;
    record_bits_g    : positive;
    -- Whether there is a serial ADC as of gc_adc_spi, with the currents of the axes on channels 0 up; its code of no
    -- current, and uA per code with 8 bits behind the point.
    adc_g            : boolean;
    adc_zero_g       : natural;
    adc_scale_g      : integer
  );
  port (
    clk_osc       : in    std_ulogic;
    -- Asynchronous: '1' resets.
    pin_reset     : in    std_ulogic;
    pin_rx        : in    std_ulogic;
    pin_tx        : out   std_ulogic;
    pin_a         : in    std_ulogic_vector(axes_c - 1 downto 0);
    pin_b         : in    std_ulogic_vector(axes_c - 1 downto 0);
    pin_z         : in    std_ulogic_vector(axes_c - 1 downto 0);
    pin_error     : in    std_ulogic_vector(axes_c - 1 downto 0);
    pin_estop_n   : in    std_ulogic;
    pin_brake_fed : in    std_ulogic_vector(axes_c - 1 downto 0);
    -- Two pins per axis: current up, current down.
    pin_pwm_up    : out   std_ulogic_vector(axes_c - 1 downto 0);
    pin_pwm_down  : out   std_ulogic_vector(axes_c - 1 downto 0);
    pin_enable    : out   std_ulogic;
    pin_release   : out   std_ulogic_vector(axes_c - 1 downto 0);
    pin_engage    : out   std_ulogic_vector(axes_c - 1 downto 0);
    -- The ADC; without one, leave pin_adc_miso low and the others open.
    pin_adc_cs_n  : out   std_ulogic;
    pin_adc_sclk  : out   std_ulogic;
    pin_adc_mosi  : out   std_ulogic;
    pin_adc_miso  : in    std_ulogic;
    -- Powered, running, irq.
    led           : out   std_ulogic_vector(7 downto 0)
  );
end entity gc_board;

architecture rtl of gc_board is

  signal clk           : std_ulogic;
  signal locked        : std_ulogic;
  signal reset_request : std_ulogic;
  signal rst           : std_ulogic;
  signal core_rst      : std_ulogic;
  signal enc_a         : std_ulogic_vector(axes_c - 1 downto 0);
  signal enc_b         : std_ulogic_vector(axes_c - 1 downto 0);
  signal enc_z         : std_ulogic_vector(axes_c - 1 downto 0);
  signal enc_error     : std_ulogic_vector(axes_c - 1 downto 0);
  signal estop_n       : std_ulogic;
  signal brake_fed     : std_ulogic_vector(axes_c - 1 downto 0);
  signal commanded     : std_ulogic;
  signal current       : signed(axes_c * current_bits_c - 1 downto 0);
  signal sense_valid   : std_ulogic_vector(axes_c - 1 downto 0);
  signal sense_current : signed(axes_c * current_bits_c - 1 downto 0);
  signal enable        : std_ulogic;
  signal brake_release : std_ulogic_vector(axes_c - 1 downto 0);
  signal brake_engage  : std_ulogic_vector(axes_c - 1 downto 0);
  signal irq           : std_ulogic;

begin

  reset_request <= pin_reset or not locked;

  i_pll : entity work.gc_pll
    port map (
      clk_in  => clk_osc,
      clk_out => clk,
      locked  => locked
    );

  i_power_on : entity work.gc_power_on
    port map (
      clk     => clk_osc,
      request => reset_request,
      rst     => rst
    );

  i_system : entity work.gc_serial_system
    generic map (
      bus_clock_hz_g   => oscillator_hz_g,
      baud_g           => baud_g,
      gap_us_g         => gap_us_g,
      lanes_g          => lanes_g,
      clock_hz_g       => clock_hz_c,
      loadable_g       => loadable_g,
      brake_feedback_g => brake_feedback_g,
      motion_g         => motion_g,
      record_bits_g    => record_bits_g
    )
    port map (
      bus_clk       => clk_osc,
      bus_rst       => rst,
      pin_rx        => pin_rx,
      pin_tx        => pin_tx,
      pin_tx_enable => open,
      irq           => irq,
      clk           => clk,
      pin_a         => enc_a,
      pin_b         => enc_b,
      pin_z         => enc_z,
      pin_error     => enc_error,
      estop_n       => estop_n,
      drive_valid   => commanded,
      drive_current => current,
      drive_enable  => enable,
      brake_release => brake_release,
      brake_engage  => brake_engage,
      brake_fed     => brake_fed,
      sense_valid   => sense_valid,
      sense_current => sense_current
    );

  g_pwm : for k in 0 to axes_c - 1 generate

    -- 20 kHz at 40 MHz.
    i_pwm : entity work.gc_pwm
      generic map (
        clocks_g     => 2000,
        full_scale_g => full_scale_ua_g,
        two_pins_g   => true
      )
      port map (
        clk      => clk,
        rst      => core_rst,
        enable   => enable,
        in_value => current((k + 1) * current_bits_c - 1 downto k * current_bits_c),
        pin_a    => pin_pwm_up(k),
        pin_b    => pin_pwm_down(k)
      );

  end generate g_pwm;

  i_core_reset : entity work.gc_synchronizer
    port map (
      clk           => clk,
      rst           => '0',
      async_data(0) => rst,
      out_valid     => open,
      out_data(0)   => core_rst
    );

  g_sense : if selftest_g generate

    sense_valid <= (others => commanded);
    sense_current <= current;

  elsif adc_g generate
    signal zero  : unsigned(axes_c * 16 - 1 downto 0);
    signal scale : signed(axes_c * 24 - 1 downto 0);
  begin

    g_axis : for k in 0 to axes_c - 1 generate

      zero(16 * k + 15 downto 16 * k) <= to_unsigned(adc_zero_g, 16);
      scale(24 * k + 23 downto 24 * k) <= to_signed(adc_scale_g, 24);

    end generate g_axis;

    -- One scan behind the other.
    i_adc : entity work.gc_adc_spi
      generic map (
        channels_g => axes_c
      )
      port map (
        clk           => clk,
        rst           => core_rst,
        in_valid      => '1',
        pin_cs_n      => pin_adc_cs_n,
        pin_sclk      => pin_adc_sclk,
        pin_mosi      => pin_adc_mosi,
        pin_miso      => pin_adc_miso,
        cfg_zero      => zero,
        cfg_scale     => scale,
        sense_valid   => sense_valid,
        sense_current => sense_current,
        sts_errors    => open
      );

  else generate

    sense_valid <= (others => '0');
    sense_current <= (others => '0');

  end generate g_sense;

  g_no_adc : if selftest_g or not adc_g generate

    pin_adc_cs_n <= '1';
    pin_adc_sclk <= '1';
    pin_adc_mosi <= '0';

  end generate g_no_adc;

  g_pins : if not selftest_g generate

    enc_a <= pin_a;
    enc_b <= pin_b;
    enc_z <= pin_z;
    enc_error <= pin_error;
    estop_n <= pin_estop_n;
    brake_fed <= pin_brake_fed;

  else generate

    enc_error <= (others => '0');
    estop_n <= '1';
    brake_fed <= brake_release and not brake_engage;

    g_axis : for k in 0 to axes_c - 1 generate

      i_axis : entity work.gc_desk_axis
        generic map (
          step_clocks_g => desk_step_g
        )
        port map (
          clk        => clk,
          rst        => core_rst,
          in_current => current((k + 1) * current_bits_c - 1 downto k * current_bits_c),
          released   => brake_fed(k),
          pin_a      => enc_a(k),
          pin_b      => enc_b(k),
          pin_z      => enc_z(k)
        );

    end generate g_axis;

  end generate g_pins;

  pin_enable <= enable;
  pin_release <= brake_release;
  pin_engage <= brake_engage;

  led(0) <= locked;
  led(1) <= or brake_release;
  led(2) <= irq;
  led(7 downto 3) <= (others => '0');

end architecture rtl;
