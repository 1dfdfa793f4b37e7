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
-- guard_g: upset = '1' one clock after a wrong bit in what says whose turn it is, in the phase or in its time.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_network_pkg.all;

entity gc_brake_test is
  generic (
    -- Whether the registers are watched for wrong bits.
    guard_g : boolean := false
  );
  port (
    clk         : in    std_ulogic;
    -- Synchronous, active high.
    rst         : in    std_ulogic;
    in_start    : in    std_ulogic;
    -- '1': the brake of the axis is fed, it is released.
    in_feedback : in    std_ulogic_vector(axes_c - 1 downto 0);
    -- Time of a phase, clocks.
    cfg_clocks  : in    unsigned(31 downto 0);
    -- The path releases the brake of the axis.
    out_first   : out   std_ulogic_vector(axes_c - 1 downto 0);
    out_second  : out   std_ulogic_vector(axes_c - 1 downto 0);
    out_done    : out   std_ulogic;
    out_failed  : out   std_ulogic := '0';
    upset       : out   std_ulogic
  );
end entity gc_brake_test;

architecture rtl of gc_brake_test is

  -- The axis whose turn it is; none before and after the test.
  signal axis        : std_ulogic_vector(axes_c - 1 downto 0) := (others => '0');
  signal next_axis   : std_ulogic_vector(axes_c - 1 downto 0);
  signal first       : std_ulogic := '0';
  signal next_first  : std_ulogic;
  signal second      : std_ulogic := '0';
  signal next_second : std_ulogic;
  signal done        : std_ulogic := '0';
  signal next_done   : std_ulogic;
  signal going       : std_ulogic;
  signal idle        : std_ulogic;
  signal pause       : std_ulogic;
  signal over        : std_ulogic;
  signal ends        : std_ulogic;
  signal fed         : std_ulogic_vector(axes_c - 1 downto 0);
  signal upset_time  : std_ulogic;
  signal upset_order : std_ulogic;

begin

  going <= in_start and not rst;
  idle <= '1' when unsigned(axis) = 0 else '0';
  pause <= idle or ends;
  -- Not that of a test that ended before its time.
  ends <= over and not idle;

  i_time : entity work.gc_timeout
    generic map (
      guard_g => guard_g
    )
    port map (
      clk        => clk,
      rst        => rst,
      restart    => pause,
      cfg_clocks => cfg_clocks,
      expired    => over,
      upset      => upset_time
    );

  fed <= axis when first = '1' and second = '1' else (others => '0');

  p_next : process (all) is
  begin

    next_axis <= axis;
    next_first <= first;
    next_second <= second;
    next_done <= done;

    -- the first phase
    if idle = '1' and done = '0' then
      next_axis(0) <= '1';
      next_first <= '1';
    end if;

    -- the next one: of the two paths the one that follows the other
    if ends = '1' then
      next_second <= first;
      next_first <= not second;
      if first = '0' and second = '0' then
        next_axis <= axis(axes_c - 2 downto 0) & '0';
        next_done <= axis(axes_c - 1);
      end if;
    end if;

    if going = '0' then
      next_axis <= (others => '0');
      next_first <= '0';
      next_second <= '0';
      next_done <= '0';
    end if;

  end process p_next;

  p_phase : process (clk) is
  begin

    if rising_edge(clk) then
      axis <= next_axis;
      first <= next_first;
      second <= next_second;
      done <= next_done;
      out_failed <= '0';
      if going = '1' and ends = '1' and in_feedback /= fed then
        out_failed <= '1';
      end if;
    end if;

  end process p_phase;

  g_guard : if guard_g generate
    signal order      : std_ulogic_vector(axes_c + 2 downto 0);
    signal next_order : std_ulogic_vector(axes_c + 2 downto 0);
  begin

    order <= axis & first & second & done;
    next_order <= next_axis & next_first & next_second & next_done;

    i_order : entity work.gc_parity_guard
      generic map (
        width_g => axes_c + 3
      )
      port map (
        clk        => clk,
        rst        => rst,
        in_load    => '1',
        in_next    => next_order,
        in_word    => order,
        out_parity => open,
        out_upset  => upset_order
      );

  else generate
    upset_order <= '0';
  end generate g_guard;

  upset <= upset_time or upset_order;

  out_first <= axis when first = '1' else (others => '0');
  out_second <= axis when second = '1' else (others => '0');
  out_done <= done;

end architecture rtl;
