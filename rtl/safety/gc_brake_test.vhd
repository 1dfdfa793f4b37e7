-- SPDX-License-Identifier: MIT
--
-- Shows, before all brakes are released, that each brake obeys and that each of its two paths can engage it alone.
--
-- While the motors carry the load (in_start), one axis after the other, the paths are switched in four phases, of which
-- each switches one of them; a read-back pin per axis tells whether its brake is fed:
--
--   phase   first path   second path   brake fed
--     0     releases     engages       no     the second path alone holds the brake
--     1     releases     releases      yes    the brake, and its read-back, obey
--     2     engages      releases      no     the first path alone holds the brake
--     3     engages      engages       no
--
-- At the end of each phase the pin of that axis must read so, and those of all other axes '0'; otherwise out_failed is
-- '1' for one clock. The axis is held by its motor if its brake opens, by its brake if it does not.
-- out_done is '1' from the end of the last phase until in_start falls, which also ends a test under way.
-- Latency: 1 clock. A phase lasts cfg_clocks + 2 clocks; the read-back of a phase must be there before, so a limit of 0
-- fails.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_network_pkg.all;

entity gc_brake_test is
  port (
    clk         : in    std_ulogic;
    -- Synchronous, active high.
    rst         : in    std_ulogic;
    in_start    : in    std_ulogic;
    -- '1': the brake of the axis is fed, it is released.
    in_feedback : in    std_ulogic_vector(inputs_c - 1 downto 0);
    -- Time of a phase, clocks.
    cfg_clocks  : in    unsigned(31 downto 0);
    -- The path releases the brake of the axis.
    out_first   : out   std_ulogic_vector(inputs_c - 1 downto 0);
    out_second  : out   std_ulogic_vector(inputs_c - 1 downto 0);
    out_done    : out   std_ulogic;
    out_failed  : out   std_ulogic := '0'
  );
end entity gc_brake_test;

architecture rtl of gc_brake_test is

  -- The axis whose turn it is; none before and after the test.
  signal axis   : std_ulogic_vector(inputs_c - 1 downto 0) := (others => '0');
  signal first  : std_ulogic := '0';
  signal second : std_ulogic := '0';
  signal done   : std_ulogic := '0';
  signal idle   : std_ulogic;
  signal pause  : std_ulogic;
  signal over   : std_ulogic;
  signal ends   : std_ulogic;
  signal fed    : std_ulogic_vector(inputs_c - 1 downto 0);

begin

  idle <= '1' when unsigned(axis) = 0 else '0';
  pause <= idle or ends;
  -- Not that of a test that ended before its time.
  ends <= over and not idle;

  i_time : entity work.gc_timeout
    port map (
      clk        => clk,
      rst        => rst,
      restart    => pause,
      cfg_clocks => cfg_clocks,
      expired    => over,
      upset      => open
    );

  fed <= axis when first = '1' and second = '1' else (others => '0');

  p_phase : process (clk) is
  begin

    if rising_edge(clk) then
      out_failed <= '0';

      -- the first phase
      if idle = '1' and done = '0' then
        axis(0) <= '1';
        first <= '1';
      end if;

      -- the next one: of the two paths the one that follows the other
      if ends = '1' then
        second <= first;
        first <= not second;
        if first = '0' and second = '0' then
          axis <= axis(inputs_c - 2 downto 0) & '0';
          done <= axis(inputs_c - 1);
          first <= not axis(inputs_c - 1);
        end if;
        if in_feedback /= fed then
          out_failed <= '1';
        end if;
      end if;

      if in_start = '0' or rst = '1' then
        axis <= (others => '0');
        first <= '0';
        second <= '0';
        done <= '0';
        out_failed <= '0';
      end if;
    end if;

  end process p_phase;

  out_first <= axis when first = '1' else (others => '0');
  out_second <= axis when second = '1' else (others => '0');
  out_done <= done;

end architecture rtl;
