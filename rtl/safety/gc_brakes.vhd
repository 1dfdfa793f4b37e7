-- SPDX-License-Identifier: MIT
--
-- The brakes of all axes: states, and what watches that every brake does as it is told.
--
-- gc_brake_sequencer decides, and drives brake_release. As far as the generics ask for it:
--   two_paths_g   gc_brake_permit decides once more, in registers of its own, and drives brake_engage; the paths are
--                 compared at every clock. Otherwise brake_engage is brake_release, inverted.
--   feedback_g    a read-back pin per axis is compared with what the brake was told (gc_brake_feedback)
--   test_g        each brake is tested before all are released (gc_brake_test); takes the other two
-- What is not asked for costs nothing; brake_fed is then not used.
-- wrong: the paths differ, a brake did not follow within cfg_brake_clocks, or failed its test.
-- A brake is open when brake_release = '1' and brake_engage = '0': switch its supply by both, one behind the other.
-- Latency: those of gc_brake_sequencer; to wrong, from registers that differ, 1 clock.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_facts_pkg.all;
  use work.gc_network_pkg.all;

entity gc_brakes is
  generic (
    two_paths_g   : boolean := false;
    feedback_g    : boolean := false;
    test_g        : boolean := false;
    -- Whether the time-outs, and the order of the test, are watched for wrong bits.
    guard_g       : boolean := false;
    -- Flip-flops of brake_fed against metastability, at least 2.
    sync_stages_g : positive := 2
  );
  port (
    clk              : in    std_ulogic;
    -- Synchronous, active high: BRAKED.
    rst              : in    std_ulogic;
    -- See gc_brake_sequencer.
    enable           : in    std_ulogic;
    clear            : in    std_ulogic;
    in_fault         : in    std_ulogic;
    in_healthy       : in    std_ulogic;
    in_carried       : in    std_ulogic;
    -- Read-back per axis, asynchronous; '1': the brake is fed, it is released.
    brake_fed        : in    std_ulogic_vector(axes_c - 1 downto 0);
    -- Time for a brake to close or to open, and for the motors to take the load, clocks.
    cfg_brake_clocks : in    unsigned(31 downto 0);
    -- Time of a phase of the test, clocks.
    cfg_test_clocks  : in    unsigned(31 downto 0);
    state            : out   safety_state_t;
    run              : out   std_ulogic;
    -- '1' releases the brake of the axis, '0' engages it.
    brake_release    : out   std_ulogic_vector(axes_c - 1 downto 0);
    -- '0' releases the brake of the axis, '1' engages it.
    brake_engage     : out   std_ulogic_vector(axes_c - 1 downto 0);
    -- The read-back pins, synchronous.
    sts_feedback     : out   std_ulogic_vector(axes_c - 1 downto 0);
    wrong            : out   std_ulogic := '0';
    upset            : out   std_ulogic
  );
end entity gc_brakes;

architecture rtl of gc_brakes is

  subtype axes_t is std_ulogic_vector(axes_c - 1 downto 0);

  signal may_test     : std_ulogic;
  signal tested       : std_ulogic;
  signal test_first   : axes_t;
  signal test_second  : axes_t;
  signal told         : axes_t;
  signal paths_differ : std_ulogic;
  signal pins_differ  : std_ulogic;
  signal test_failed  : std_ulogic;
  -- Of the first path, the second one, the read-back and the test.
  signal upsets       : std_ulogic_vector(3 downto 0);

begin

  assert not test_g or (two_paths_g and feedback_g)
    report "gc_brakes: need two_paths_g and feedback_g with test_g"
    severity failure;

  -- The first path

  i_sequencer : entity work.gc_brake_sequencer
    generic map (
      guard_g => guard_g
    )
    port map (
      clk              => clk,
      rst              => rst,
      enable           => enable,
      clear            => clear,
      in_fault         => in_fault,
      in_healthy       => in_healthy,
      in_carried       => in_carried,
      in_tested        => tested,
      in_test          => test_first,
      cfg_brake_clocks => cfg_brake_clocks,
      state            => state,
      run              => run,
      may_test         => may_test,
      brake_release    => brake_release,
      upset            => upsets(0)
    );

  -- The second path

  g_two_paths : if two_paths_g generate
    signal faulty    : std_ulogic;
    signal idle      : std_ulogic;
    signal shut      : std_ulogic;
    signal in_turn_1 : axes_t := (others => '0');
    signal agree     : axes_t;
  begin

    i_permit : entity work.gc_brake_permit
      generic map (
        guard_g => guard_g
      )
      port map (
        clk              => clk,
        rst              => rst,
        enable           => enable,
        clear            => clear,
        in_fault         => in_fault,
        in_healthy       => in_healthy,
        in_carried       => in_carried,
        in_tested        => tested,
        in_test          => test_second,
        cfg_brake_clocks => cfg_brake_clocks,
        faulty           => faulty,
        idle             => idle,
        shut             => shut,
        brake_engage     => brake_engage,
        upset            => upsets(1)
      );

    p_turn : process (clk) is
    begin

      if rising_edge(clk) then
        in_turn_1 <= test_first or test_second;
      end if;

    end process p_turn;

    -- A brake in its test is told two things on purpose.
    agree <= (brake_release xor brake_engage) or in_turn_1;
    paths_differ <= '0' when signed(agree) = -1 and (faulty = '1') = (state = state_fault_c) and
                             (shut = '0') = (state = state_run_c) and idle = not run else
                    '1';
  else generate
    brake_engage <= not brake_release;
    paths_differ <= '0';
    upsets(1) <= '0';
  end generate g_two_paths;

  -- Read-back

  told <= brake_release and not brake_engage;

  g_feedback : if feedback_g generate

    i_feedback : entity work.gc_brake_feedback
      generic map (
        guard_g       => guard_g,
        sync_stages_g => sync_stages_g
      )
      port map (
        clk          => clk,
        rst          => rst,
        brake_fed    => brake_fed,
        in_released  => told,
        cfg_clocks   => cfg_brake_clocks,
        out_feedback => sts_feedback,
        out_differs  => pins_differ,
        upset        => upsets(2)
      );

  else generate
    sts_feedback <= (others => '0');
    pins_differ <= '0';
    upsets(2) <= '0';
  end generate g_feedback;

  -- Test

  g_test : if test_g generate

    i_test : entity work.gc_brake_test
      generic map (
        guard_g => guard_g
      )
      port map (
        clk         => clk,
        rst         => rst,
        in_start    => may_test,
        in_feedback => sts_feedback,
        cfg_clocks  => cfg_test_clocks,
        out_first   => test_first,
        out_second  => test_second,
        out_done    => tested,
        out_failed  => test_failed,
        upset       => upsets(3)
      );

  else generate
    test_first <= (others => '0');
    test_second <= (others => '0');
    tested <= '1';
    test_failed <= '0';
    upsets(3) <= '0';
  end generate g_test;

  p_wrong : process (clk) is
  begin

    if rising_edge(clk) then
      wrong <= paths_differ or pins_differ or test_failed;
      if rst = '1' then
        wrong <= '0';
      end if;
    end if;

  end process p_wrong;

  upset <= '1' when unsigned(upsets) /= 0 else '0';

end architecture rtl;
