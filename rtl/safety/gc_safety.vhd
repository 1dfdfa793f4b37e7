-- SPDX-License-Identifier: MIT
--
-- Safety of all axes: watches encoders, positions, speeds, results, host and emergency stop; engages the brakes and
-- stops the command on a fault; remembers what came first and where.
--
-- Brakes are released, and the command is active, only after a rising enable while no cause is present: referenced,
-- healthy, emergency stop released. States: see gc_brake_sequencer; causes and reactions: docs/guide/safety.md.
-- The brakes are released only after the motors have carried the load, and engaged when a command deviates from what
-- carries it; no limit of magnitude or slew hides that. HOLDING has a time-out.
-- estop, encoder, crc, rom, brake, core and upset are faults in every state. The others are while the command is
-- active, and in FAULT; while braked they are normal (before homing, without a host) and keep the brakes engaged.
-- A cause that came stays a fault until it is cleared; clear while it lasts does not help. FAULT is left, to BRAKED,
-- when the last one is cleared.
-- Latency: from a cause at the inputs to brake_release = run = '0': 2 clocks; from pin estop_n: sync_stages_g + 1; from
-- the last kick or result: the limit and 3 clocks; so from the first clock of saturation, deviation or HOLDING.
-- After reset an emergency stop is assumed until estop_n is known.
-- The input of an open pin must read '0': pull it down.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_facts_pkg.all;
  use work.gc_network_pkg.all;

entity gc_safety is
  generic (
    -- Flip-flops of estop_n and brake_fed against metastability, at least 2.
    sync_stages_g     : positive := 2;
    -- Clocks per 4 counts at the limit speed of the encoder interface: what is faster cannot be told from that.
    period_shortest_g : positive := 8;
    -- What watches the brakes (gc_brakes).
    two_paths_g       : boolean := false;
    brake_feedback_g  : boolean := false;
    brake_test_g      : boolean := false;
    -- Whether time-outs and remembered faults are watched for wrong bits.
    guard_g           : boolean := false
  );
  port (
    clk                   : in    std_ulogic;
    -- Synchronous, active high: BRAKED, no causes.
    rst                   : in    std_ulogic;
    -- Emergency stop, asynchronous, '0' stops.
    estop_n               : in    std_ulogic;
    -- A rising edge starts, a low level stops.
    enable                : in    std_ulogic;
    -- One clock: causes to forget.
    clear                 : in    causes_t;
    -- One clock: the host is alive.
    kick                  : in    std_ulogic;
    -- Encoder counts and clocks per 4 counts (gc_speed_meter), axis 1 lowest.
    in_count              : in    signed(axes_c * count_bits_c - 1 downto 0);
    in_period             : in    signed(axes_c * 32 - 1 downto 0);
    in_referenced         : in    std_ulogic_vector(axes_c - 1 downto 0);
    in_illegal            : in    std_ulogic_vector(axes_c - 1 downto 0);
    -- One clock per result of the core, and its flags.
    in_result             : in    std_ulogic;
    in_clamped            : in    std_ulogic_vector(axes_c - 1 downto 0);
    in_saturated          : in    std_ulogic_vector(axes_c - 1 downto 0);
    -- The command of the axis is the whole current asked for; it is too far from that (gc_drive).
    in_reached            : in    std_ulogic_vector(axes_c - 1 downto 0);
    in_deviates           : in    std_ulogic_vector(axes_c - 1 downto 0);
    -- Levels: an image was refused, the ROM in use is not the one expected.
    in_crc_bad            : in    std_ulogic;
    in_rom_bad            : in    std_ulogic;
    -- Levels: the host's clock stands or the core's stood, the core contradicts itself, a setting has a wrong bit.
    in_clock_bad          : in    std_ulogic;
    in_core_bad           : in    std_ulogic;
    in_upset              : in    std_ulogic;
    -- The axis is too far from its setpoint (gc_servo). Only with motion.
    in_astray             : in    std_ulogic_vector(axes_c - 1 downto 0) := (others => '0');
    -- Read-back per axis, asynchronous; '1': the brake is fed, it is released. Only with brake_feedback_g.
    brake_fed             : in    std_ulogic_vector(axes_c - 1 downto 0);
    -- Lowest and highest count that is no fault, axis 1 lowest.
    cfg_count_low         : in    signed(axes_c * count_bits_c - 1 downto 0);
    cfg_count_high        : in    signed(axes_c * count_bits_c - 1 downto 0);
    -- Fewest clocks per 4 counts that are no fault, at least period_shortest_g + 1; 0: none but standstill. Axis 1
    -- lowest. A period is compared with the one of two clocks before.
    cfg_period_min        : in    unsigned(axes_c * 31 - 1 downto 0);
    -- Longest time that is no fault: saturated or clamped, without a kick, without a result; clocks.
    cfg_saturation_clocks : in    unsigned(31 downto 0);
    cfg_watchdog_clocks   : in    unsigned(31 downto 0);
    cfg_result_clocks     : in    unsigned(31 downto 0);
    -- Longest time that a command may deviate while brakes are released, and that HOLDING may take; clocks.
    cfg_command_clocks    : in    unsigned(31 downto 0);
    cfg_hold_clocks       : in    unsigned(31 downto 0);
    -- Time for a brake to close and for the motors to take the load, clocks.
    cfg_brake_clocks      : in    unsigned(31 downto 0);
    -- Time of a phase of the test of the brakes, clocks. Only with brake_test_g.
    cfg_test_clocks       : in    unsigned(31 downto 0);
    -- '0': command to zero.
    run                   : out   std_ulogic;
    -- '1' releases the brake of the axis.
    brake_release         : out   std_ulogic_vector(axes_c - 1 downto 0);
    -- '1' engages the brake of the axis.
    brake_engage          : out   std_ulogic_vector(axes_c - 1 downto 0);
    -- The read-back pins, synchronous.
    sts_feedback          : out   std_ulogic_vector(axes_c - 1 downto 0);
    sts_state             : out   safety_state_t;
    -- Causes of this moment, whether faults or not.
    sts_present           : out   causes_t;
    -- Causes that were not cleared yet; those that came first, and where: encoder counts, axis 1 lowest.
    sts_fault             : out   causes_t;
    sts_first_cause       : out   causes_t;
    sts_first_count       : out   signed(axes_c * count_bits_c - 1 downto 0);
    -- Times that a cause came, modulo 256 (gc_fault_latch).
    sts_events            : out   unsigned(7 downto 0)
  );
end entity gc_safety;

architecture rtl of gc_safety is

  -- speed_period of an axis that stands still, or of which no speed is known yet; see gc_speed_meter
  constant still_c : signed(31 downto 0) := (31 => '0', others => '1');

  type periods_t is array (0 to axes_c - 1) of signed(31 downto 0);

  signal estop_known   : std_ulogic;
  signal estop_level   : std_ulogic_vector(0 downto 0);
  signal saturated     : std_ulogic;
  signal not_saturated : std_ulogic;
  signal saturation_1  : std_ulogic;
  signal watchdog_1    : std_ulogic;
  signal result_1      : std_ulogic;
  signal not_deviating : std_ulogic;
  signal command_1     : std_ulogic;
  signal not_holding   : std_ulogic;
  signal hold_1        : std_ulogic;
  -- The shortest period that is long enough; the longest one that is not, up or down.
  signal period_limit  : periods_t := (others => still_c);
  signal period_most   : periods_t := (others => still_c - 1);
  signal flags_1       : causes_t := no_causes_c;
  signal count_1       : signed(axes_c * count_bits_c - 1 downto 0) := (others => '0');
  signal present       : causes_t;
  signal healthy       : std_ulogic;
  signal fault         : causes_t;
  signal any_fault     : std_ulogic;
  signal cleared       : std_ulogic;
  signal carried       : std_ulogic;
  signal released      : std_ulogic;
  signal brake_wrong   : std_ulogic;
  signal upsets        : std_ulogic_vector(6 downto 0);

begin

  i_estop : entity work.gc_synchronizer
    generic map (
      width_g  => 1,
      stages_g => sync_stages_g
    )
    port map (
      clk           => clk,
      rst           => rst,
      async_data(0) => estop_n,
      out_valid     => estop_known,
      out_data      => estop_level
    );

  saturated <= '1' when unsigned(in_saturated) /= 0 or unsigned(in_clamped) /= 0 else '0';
  not_saturated <= not saturated;

  i_saturation : entity work.gc_timeout
    generic map (
      guard_g => guard_g
    )
    port map (
      clk        => clk,
      rst        => rst,
      restart    => not_saturated,
      cfg_clocks => cfg_saturation_clocks,
      expired    => saturation_1,
      upset      => upsets(0)
    );

  i_watchdog : entity work.gc_timeout
    generic map (
      guard_g => guard_g
    )
    port map (
      clk        => clk,
      rst        => rst,
      restart    => kick,
      cfg_clocks => cfg_watchdog_clocks,
      expired    => watchdog_1,
      upset      => upsets(1)
    );

  i_result : entity work.gc_timeout
    generic map (
      guard_g => guard_g
    )
    port map (
      clk        => clk,
      rst        => rst,
      restart    => in_result,
      cfg_clocks => cfg_result_clocks,
      expired    => result_1,
      upset      => upsets(2)
    );

  released <= '1' when sts_state = state_run_c else '0';
  not_deviating <= '1' when unsigned(in_deviates) = 0 or released = '0' else '0';

  i_command : entity work.gc_timeout
    generic map (
      guard_g => guard_g
    )
    port map (
      clk        => clk,
      rst        => rst,
      restart    => not_deviating,
      cfg_clocks => cfg_command_clocks,
      expired    => command_1,
      upset      => upsets(3)
    );

  not_holding <= '0' when sts_state = state_holding_c and enable = '1' else '1';

  i_hold : entity work.gc_timeout
    generic map (
      guard_g => guard_g
    )
    port map (
      clk        => clk,
      rst        => rst,
      restart    => not_holding,
      cfg_clocks => cfg_hold_clocks,
      expired    => hold_1,
      upset      => upsets(4)
    );

  -- stage 1: the other causes, and the positions that belong to them
  p_watch : process (clk) is

    variable count_v  : signed(count_bits_c - 1 downto 0);
    variable low_v    : signed(count_bits_c - 1 downto 0);
    variable high_v   : signed(count_bits_c - 1 downto 0);
    variable period_v : signed(31 downto 0);
    variable least_v  : unsigned(30 downto 0);

  begin

    if rising_edge(clk) then
      count_1 <= in_count;
      flags_1 <= no_causes_c;
      flags_1(cause_crc_c) <= in_crc_bad;
      flags_1(cause_rom_c) <= in_rom_bad;
      flags_1(cause_clock_c) <= in_clock_bad;
      flags_1(cause_core_c) <= in_core_bad;
      if in_upset = '1' or unsigned(upsets) /= 0 then
        flags_1(cause_upset_c) <= '1';
      end if;

      for i in 0 to axes_c - 1 loop

        count_v := in_count((i + 1) * count_bits_c - 1 downto i * count_bits_c);
        low_v := cfg_count_low((i + 1) * count_bits_c - 1 downto i * count_bits_c);
        high_v := cfg_count_high((i + 1) * count_bits_c - 1 downto i * count_bits_c);
        period_v := in_period((i + 1) * 32 - 1 downto i * 32);
        least_v := cfg_period_min((i + 1) * 31 - 1 downto i * 31);

        period_limit(i) <= signed('0' & least_v);
        if least_v = 0 then
          period_limit(i) <= still_c;
        elsif least_v <= period_shortest_g then
          period_limit(i) <= to_signed(period_shortest_g + 1, 32);
        end if;
        period_most(i) <= period_limit(i) - 1;

        if in_illegal(i) = '1' then
          flags_1(cause_encoder_c) <= '1';
        end if;
        if in_astray(i) = '1' then
          flags_1(cause_following_c) <= '1';
        end if;
        if in_referenced(i) = '0' then
          flags_1(cause_unreferenced_c) <= '1';
        end if;
        if count_v < low_v or count_v > high_v then
          flags_1(cause_position_c) <= '1';
        end if;
        if period_v <= period_most(i) and resize(period_v, 33) + period_most(i) >= 0 then
          flags_1(cause_speed_c) <= '1';
        end if;

      end loop;

      if rst = '1' then
        flags_1 <= no_causes_c;
      end if;
    end if;

  end process p_watch;

  p_present : process (all) is
  begin

    present <= flags_1;
    present(cause_estop_c) <= estop_known and not estop_level(0);
    present(cause_saturation_c) <= saturation_1;
    present(cause_watchdog_c) <= watchdog_1;
    present(cause_result_c) <= result_1;
    present(cause_command_c) <= command_1;
    -- Not if the brakes were released at the last moment: they would be engaged again.
    present(cause_hold_c) <= hold_1 and not released;
    present(cause_brake_c) <= brake_wrong;

  end process p_present;

  -- stage 2: what the causes mean in this state
  healthy <= '1' when present = no_causes_c and estop_known = '1' else '0';
  fault <= present and always_causes_c when sts_state = state_braked_c else present;
  any_fault <= '1' when fault /= no_causes_c else '0';
  cleared <= '1' when clear /= no_causes_c and (sts_fault and not clear) = no_causes_c else '0';

  i_latch : entity work.gc_fault_latch
    generic map (
      guard_g => guard_g
    )
    port map (
      clk         => clk,
      rst         => rst,
      in_clear    => clear,
      in_fault    => fault,
      in_count    => count_1,
      sts_fault   => sts_fault,
      first_cause => sts_first_cause,
      first_count => sts_first_count,
      events      => sts_events,
      upset       => upsets(5)
    );

  carried <= '1' when signed(in_reached) = -1 else '0';

  i_brakes : entity work.gc_brakes
    generic map (
      two_paths_g   => two_paths_g,
      feedback_g    => brake_feedback_g,
      test_g        => brake_test_g,
      guard_g       => guard_g,
      sync_stages_g => sync_stages_g
    )
    port map (
      clk              => clk,
      rst              => rst,
      enable           => enable,
      clear            => cleared,
      in_fault         => any_fault,
      in_healthy       => healthy,
      in_carried       => carried,
      brake_fed        => brake_fed,
      cfg_brake_clocks => cfg_brake_clocks,
      cfg_test_clocks  => cfg_test_clocks,
      state            => sts_state,
      run              => run,
      brake_release    => brake_release,
      brake_engage     => brake_engage,
      sts_feedback     => sts_feedback,
      wrong            => brake_wrong,
      upset            => upsets(6)
    );

  sts_present <= present;

end architecture rtl;
