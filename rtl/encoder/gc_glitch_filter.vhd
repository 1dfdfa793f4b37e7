-- SPDX-License-Identifier: MIT
--
-- Digital glitch filter of one bit: out_level takes a new level after samples_g successive equal samples of it.
--
-- A pulse of less than samples_g clocks never passes and is reported by out_dropped for one clock when it ends.
-- A pulse of samples_g clocks or more passes with its full length (+- a clock of sampling).
-- After reset, or while in_valid = '0', out_valid is low until samples_g successive samples agree: the first level
-- is learnt, so that a pin that rests high makes no edge at start-up.
-- Latency: samples_g clocks. samples_g = 1 is a register; samples_g = 0 is wires (no latency, nothing dropped).
-- out_sample is the newest sample that out_level is made of: while the two are equal, nothing waits in the filter.

library ieee;
  use ieee.std_logic_1164.all;

entity gc_glitch_filter is
  generic (
    -- successive equal samples that make a level, clocks; 0 = no filter
    samples_g : natural := 4
  );
  port (
    clk         : in    std_ulogic;
    rst         : in    std_ulogic;
    in_valid    : in    std_ulogic;
    in_level    : in    std_ulogic;
    out_valid   : out   std_ulogic;
    out_level   : out   std_ulogic;
    out_sample  : out   std_ulogic;
    -- a pulse was too short and was dropped, one clock
    out_dropped : out   std_ulogic
  );
end entity gc_glitch_filter;

architecture rtl of gc_glitch_filter is

begin

  g_wires : if samples_g = 0 generate

    out_valid <= in_valid;
    out_level <= in_level;
    out_sample <= in_level;
    out_dropped <= '0';

  else generate

    signal known   : std_ulogic := '0';
    signal level   : std_ulogic := '0';
    signal sample  : std_ulogic := '0';
    signal dropped : std_ulogic := '0';
    -- successive samples: equal to level while it is being learnt, different from level afterwards
    signal run     : natural range 0 to samples_g := 0;

  begin

    out_valid <= known;
    out_level <= level;
    out_sample <= sample;
    out_dropped <= dropped;

    p_filter : process (clk) is

      variable run_v : natural range 0 to samples_g;

    begin

      if rising_edge(clk) then
        dropped <= '0';
        sample <= in_level;

        if known = '0' and in_level = level then
          run_v := run + 1;
        elsif known = '0' then
          level <= in_level;
          run_v := 1;
        elsif in_level /= level then
          run_v := run + 1;
        else
          run_v := 0;
          if run > 0 then
            dropped <= '1';
          end if;
        end if;

        if run_v = samples_g then
          known <= '1';
          level <= in_level;
          run_v := 0;
        end if;
        run <= run_v;

        if rst = '1' or in_valid = '0' then
          known <= '0';
          run <= 0;
          dropped <= '0';
        end if;
      end if;

    end process p_filter;

  end generate g_wires;

end architecture rtl;
