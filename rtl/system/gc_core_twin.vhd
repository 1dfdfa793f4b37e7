-- SPDX-License-Identifier: MIT
--
-- A second gc_core_side that lives one clock behind the first, gets the same inputs and must put out the same.
--
-- out_differ = '1' when command, brakes or enable of the two differ: one wrong bit in a register, a memory or the ROM of
-- either that would reach the robot. The lag keeps synthesis from merging the two; see gc_lockstep.
-- Pins must be synchronous to clk here, so that both see the same edge in the same clock of theirs.
-- Latency: 2 clocks from the first one's outputs to out_differ.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_facts_pkg.all;
  use work.gc_network_pkg.all;
  use work.gc_system_pkg.all;

entity gc_core_twin is
  generic (
    -- See gc_core_side.
    lanes_g           : positive;
    filter_samples_g  : natural;
    speed_timeout_g   : positive;
    reversal_clocks_g : positive;
    dither_clocks_g   : positive;
    loadable_g        : boolean;
    two_paths_g       : boolean;
    brake_feedback_g  : boolean;
    brake_test_g      : boolean;
    guard_g           : boolean;
    motion_g          : boolean;
    record_bits_g     : positive
  );
  port (
    clk           : in    std_ulogic;
    -- Synchronous, active high.
    rst           : in    std_ulogic;
    -- What the first one gets, see gc_core_side.
    pin_a         : in    std_ulogic_vector(axes_c - 1 downto 0);
    pin_b         : in    std_ulogic_vector(axes_c - 1 downto 0);
    pin_z         : in    std_ulogic_vector(axes_c - 1 downto 0);
    pin_error     : in    std_ulogic_vector(axes_c - 1 downto 0);
    estop_n       : in    std_ulogic;
    brake_fed     : in    std_ulogic_vector(axes_c - 1 downto 0);
    in_clock_bad  : in    std_ulogic;
    in_core_bad   : in    std_ulogic;
    in_valid      : in    std_ulogic;
    in_settings   : in    settings_t;
    -- What the first one puts out.
    main_valid    : in    std_ulogic;
    main_current  : in    signed(axes_c * current_bits_c - 1 downto 0);
    main_enable   : in    std_ulogic;
    main_release  : in    std_ulogic_vector(axes_c - 1 downto 0);
    main_engage   : in    std_ulogic_vector(axes_c - 1 downto 0);
    -- What the second one would do.
    drive_enable  : out   std_ulogic;
    brake_release : out   std_ulogic_vector(axes_c - 1 downto 0);
    brake_engage  : out   std_ulogic_vector(axes_c - 1 downto 0);
    out_differ    : out   std_ulogic
  );
end entity gc_core_twin;

architecture rtl of gc_core_twin is

  signal rst_1           : std_ulogic := '1';
  signal a_1             : axes_t := (others => '0');
  signal b_1             : axes_t := (others => '0');
  signal z_1             : axes_t := (others => '0');
  signal error_1         : axes_t := (others => '0');
  signal estop_n_1       : std_ulogic := '0';
  signal fed_1           : axes_t := (others => '0');
  signal clock_bad_1     : std_ulogic := '0';
  signal core_bad_1      : std_ulogic := '0';
  signal valid_1         : std_ulogic := '0';
  signal settings_word_1 : settings_word_t := (others => '0');
  signal settings_1      : settings_t;
  signal valid           : std_ulogic;
  signal current         : signed(axes_c * current_bits_c - 1 downto 0);
  signal enable          : std_ulogic;
  signal released        : axes_t;
  signal engaged         : axes_t;
  signal main_out        : std_ulogic_vector(current'length + 2 * axes_c + 1 downto 0);
  signal twin_out        : std_ulogic_vector(main_out'range);

begin

  p_later : process (clk) is
  begin

    if rising_edge(clk) then
      rst_1 <= rst;
      a_1 <= pin_a;
      b_1 <= pin_b;
      z_1 <= pin_z;
      error_1 <= pin_error;
      estop_n_1 <= estop_n;
      fed_1 <= brake_fed;
      clock_bad_1 <= in_clock_bad;
      core_bad_1 <= in_core_bad;
      valid_1 <= in_valid;
      settings_word_1 <= to_word(in_settings);
    end if;

  end process p_later;

  settings_1 <= to_settings(settings_word_1);

  i_core_side : entity work.gc_core_side
    generic map (
      lanes_g           => lanes_g,
      filter_samples_g  => filter_samples_g,
      speed_timeout_g   => speed_timeout_g,
      reversal_clocks_g => reversal_clocks_g,
      dither_clocks_g   => dither_clocks_g,
      loadable_g        => loadable_g,
      two_paths_g       => two_paths_g,
      brake_feedback_g  => brake_feedback_g,
      brake_test_g      => brake_test_g,
      guard_g           => guard_g,
      motion_g          => motion_g,
      record_bits_g     => record_bits_g
    )
    port map (
      clk           => clk,
      rst           => rst_1,
      pin_a         => a_1,
      pin_b         => b_1,
      pin_z         => z_1,
      pin_error     => error_1,
      estop_n       => estop_n_1,
      brake_fed     => fed_1,
      -- Nobody reads its records.
      sense_valid   => (others => '0'),
      sense_current => (others => '0'),
      in_clock_bad  => clock_bad_1,
      in_core_bad   => core_bad_1,
      in_valid      => valid_1,
      in_settings   => settings_1,
      drive_valid   => valid,
      drive_current => current,
      drive_enable  => enable,
      brake_release => released,
      brake_engage  => engaged,
      out_valid     => open,
      out_state     => open
    );

  main_out <= main_valid & main_enable & main_release & main_engage & std_ulogic_vector(main_current);
  twin_out <= valid & enable & released & engaged & std_ulogic_vector(current);

  i_lockstep : entity work.gc_lockstep
    generic map (
      bits_g => main_out'length
    )
    port map (
      clk        => clk,
      rst        => rst_1,
      in_main    => main_out,
      in_twin    => twin_out,
      out_differ => out_differ
    );

  drive_enable <= enable;
  brake_release <= released;
  brake_engage <= engaged;

end architecture rtl;
