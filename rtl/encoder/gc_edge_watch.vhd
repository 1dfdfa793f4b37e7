-- SPDX-License-Identifier: MIT
--
-- Tells a broken wire of a or b from an axis that trembles: both make edges of one channel only.
--
-- Successive edges of one channel are reversals: the count goes to and fro by one. Two ways tell which it is:
-- - Onset. Two counts in one direction less than d = reversal_clocks_g clocks apart, then a reversal less than 2 d
--   clocks after them, take a deceleration of more than 2 / (3 d**2) counts per clock**2. Of a machine that cannot do
--   that, suspect_edges_g edges of one channel from that reversal on are a broken wire.
-- - Rate. Each edge of the same channel as the last one adds dither_clocks_g to a reserve that loses 1 each clock; at
--   dither_edges_g dither_clocks_g it is a broken wire.
-- An edge of the other channel ends both.
-- Never a fault, for ever: edges dither_clocks_g clocks apart or more, when no such reversal came before.
-- Found, of a wire that breaks on an axis that moves a count in less than d clocks: within 2 suspect_edges_g + 4 counts.
-- Found, without that, of an axis that moves a count each t clocks, 2 t < dither_clocks_g: within
-- 2 dither_edges_g dither_clocks_g / (dither_clocks_g - 2 t) + 4 counts. Slower than that: not here.
-- Latency: 1 clock from step_valid to out_broken, one clock; then all starts anew.

library ieee;
  use ieee.std_logic_1164.all;

entity gc_edge_watch is
  generic (
    -- clocks from count to count below which an axis cannot turn on the spot
    reversal_clocks_g : positive := 250;
    -- edges of one channel that make the suspicion after such a turn a fault
    suspect_edges_g   : positive := 16;
    -- clocks from edge to edge of one channel that may go on for ever
    dither_clocks_g   : positive := 40;
    -- edges of one channel at once that are no fault yet
    dither_edges_g    : positive := 64
  );
  port (
    clk          : in    std_ulogic;
    rst          : in    std_ulogic;
    -- one count happened, one clock, and its direction, '1' = up
    step_valid   : in    std_ulogic;
    step_up      : in    std_ulogic;
    -- both channels changed at once, one clock
    step_illegal : in    std_ulogic;
    out_broken   : out   std_ulogic := '0'
  );
end entity gc_edge_watch;

architecture rtl of gc_edge_watch is

  constant soon_c    : positive := 2 * reversal_clocks_g;
  constant reserve_c : positive := dither_edges_g * dither_clocks_g;
  -- what the reserve holds at least when the next edge of the same channel fills it
  constant nearly_c  : positive := reserve_c - dither_clocks_g + 1;

  -- there was a step, and its direction
  signal known   : std_ulogic := '0';
  signal up_1    : std_ulogic := '0';
  -- clocks since the last step
  signal clocks  : natural range 0 to soon_c := 0;
  -- the last two steps were of both channels and close together
  signal quick   : std_ulogic := '0';
  signal suspect : std_ulogic := '0';
  signal edges   : natural range 0 to suspect_edges_g := 0;
  -- once full it only falls, till there is a step again
  signal reserve : natural range 0 to reserve_c + dither_clocks_g := 0;

begin

  assert dither_edges_g > 1
    report "gc_edge_watch: need dither_edges_g >= 2, got " & integer'image(dither_edges_g)
    severity failure;

  p_watch : process (clk) is

    variable suspect_v : std_ulogic;
    variable edges_v   : natural range 0 to suspect_edges_g;
    variable reserve_v : natural range 0 to reserve_c + dither_clocks_g;
    variable broken_v  : std_ulogic;

  begin

    if rising_edge(clk) then
      suspect_v := suspect;
      edges_v := edges;
      reserve_v := 0;
      broken_v := '0';

      if clocks /= soon_c then
        clocks <= clocks + 1;
      end if;
      if reserve /= 0 then
        reserve_v := reserve - 1;
      end if;

      if step_valid = '1' then
        clocks <= 1;
        known <= '1';
        up_1 <= step_up;
        quick <= '0';
        if known = '0' or step_up = up_1 then
          if known = '1' and clocks < reversal_clocks_g then
            quick <= '1';
          end if;
          suspect_v := '0';
          edges_v := 0;
          reserve_v := 0;
        else
          if quick = '1' and clocks < soon_c then
            suspect_v := '1';
          end if;
          if suspect_v = '1' then
            edges_v := edges + 1;
          end if;
          -- not after the subtraction and its test, but beside them: this is the longest path here
          reserve_v := reserve + dither_clocks_g - 1;
          if reserve = 0 then
            reserve_v := dither_clocks_g;
          end if;
          if (suspect_v = '1' and edges = suspect_edges_g - 1) or reserve >= nearly_c then
            broken_v := '1';
          end if;
        end if;
      end if;

      -- the first step that is known again clears all else
      if broken_v = '1' or step_illegal = '1' then
        known <= '0';
      end if;

      suspect <= suspect_v;
      edges <= edges_v;
      reserve <= reserve_v;
      out_broken <= broken_v;

      if rst = '1' then
        known <= '0';
        out_broken <= '0';
      end if;
    end if;

  end process p_watch;

end architecture rtl;
