-- SPDX-License-Identifier: MIT
--
-- Brakes and command enable of all axes, state by state; docs/guide/safety.md has the diagram.
--
--   BRAKED    brakes engaged, command zero       reset; waits for a rising enable while healthy
--   HOLDING   brakes engaged, command active     before RUN till the motors carry the load, after it till brakes close
--   RUN       brakes released, command active
--   FAULT     brakes engaged, command zero       until clear without a fault
--
-- The motors take the load before the brakes let it go: HOLDING leads to RUN once they have carried it, with enable
-- high, for more than cfg_brake_clocks, and the brakes are tested (gc_brake_test). A low enable leads back: brakes
-- engage at once, and the command goes to zero when they have had as many clocks to close.
-- A level of enable that was high at reset, or that rose while unhealthy, braked or not, starts nothing: only its next
-- rising edge does. Motion never resumes by itself.
-- A code that is none of the four leads to FAULT.
-- Latency: 1 clock from in_fault or enable to state, run and brake_release.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_facts_pkg.all;
  use work.gc_network_pkg.all;

entity gc_brake_sequencer is
  generic (
    -- Whether the time-out is watched for wrong bits.
    guard_g : boolean := false
  );
  port (
    clk              : in    std_ulogic;
    -- Synchronous, active high: BRAKED.
    rst              : in    std_ulogic;
    -- Its rising edge starts, its low level stops.
    enable           : in    std_ulogic;
    -- One clock, no fault is left: leave FAULT; in_fault in the same clock wins.
    clear            : in    std_ulogic;
    -- A cause for FAULT.
    in_fault         : in    std_ulogic;
    -- Nothing speaks against motion.
    in_healthy       : in    std_ulogic;
    -- The motor of every axis carries the load.
    in_carried       : in    std_ulogic;
    -- The brakes are tested.
    in_tested        : in    std_ulogic;
    -- The test lets go the brake of the axis.
    in_test          : in    std_ulogic_vector(axes_c - 1 downto 0);
    -- Time for a brake to close and for the motors to take the load, clocks.
    cfg_brake_clocks : in    unsigned(31 downto 0);
    state            : out   safety_state_t := state_braked_c;
    -- '0': command to zero.
    run              : out   std_ulogic := '0';
    -- HOLDING, and the motors have carried the load: the test may begin.
    may_test         : out   std_ulogic;
    -- '1' releases the brake of the axis.
    brake_release    : out   std_ulogic_vector(axes_c - 1 downto 0) := (others => '0');
    upset            : out   std_ulogic
  );
end entity gc_brake_sequencer;

architecture rtl of gc_brake_sequencer is

  -- High at power-up: a level of enable found then is no edge.
  signal enable_1 : std_ulogic := '1';
  signal restart  : std_ulogic;
  signal expired  : std_ulogic;

begin

  restart <= '1' when state /= state_holding_c or enable /= enable_1 or (enable = '1' and in_carried = '0') else '0';

  i_hold : entity work.gc_timeout
    generic map (
      guard_g => guard_g
    )
    port map (
      clk        => clk,
      rst        => rst,
      restart    => restart,
      cfg_clocks => cfg_brake_clocks,
      expired    => expired,
      upset      => upset
    );

  may_test <= expired and not restart and enable;

  p_state : process (clk) is

    variable next_v : safety_state_t;

  begin

    if rising_edge(clk) then
      enable_1 <= enable;
      next_v := state;

      if state = state_braked_c then
        if enable = '1' and enable_1 = '0' and in_healthy = '1' then
          next_v := state_holding_c;
        end if;
      elsif state = state_holding_c then
        if expired = '1' and restart = '0' then
          if enable = '0' then
            next_v := state_braked_c;
          elsif in_tested = '1' then
            next_v := state_run_c;
          end if;
        end if;
      elsif state = state_run_c then
        if enable = '0' then
          next_v := state_holding_c;
        end if;
      elsif state = state_fault_c then
        if clear = '1' then
          next_v := state_braked_c;
        end if;
      else
        next_v := state_fault_c;
      end if;

      if in_fault = '1' then
        next_v := state_fault_c;
      end if;
      if rst = '1' then
        next_v := state_braked_c;
      end if;

      state <= next_v;
      run <= '0';
      if next_v = state_holding_c or next_v = state_run_c then
        run <= '1';
      end if;
      brake_release <= (others => '0');
      if next_v = state_run_c then
        brake_release <= (others => '1');
      elsif next_v = state_holding_c then
        brake_release <= in_test;
      end if;
    end if;

  end process p_state;

end architecture rtl;
