-- SPDX-License-Identifier: MIT
--
-- A tick every cfg_clocks clocks, and a count of those that came while in_ready was low.
--
-- The first tick comes cfg_clocks clocks after cfg_enable rises. out_valid lasts one clock and does not wait for
-- in_ready. A new cfg_clocks counts at once, from the last tick. cfg_clocks = 0 ticks like 1: at every clock.
-- Overflow: sts_missed wraps modulo 2**32.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity gc_tick is
  port (
    clk        : in    std_ulogic;
    -- Synchronous, active high.
    rst        : in    std_ulogic;
    cfg_enable : in    std_ulogic;
    -- Clocks from tick to tick.
    cfg_clocks : in    unsigned(31 downto 0);
    -- What the tick starts is free.
    in_ready   : in    std_ulogic;
    out_valid  : out   std_ulogic := '0';
    -- Ticks that found in_ready low, since reset.
    sts_missed : out   unsigned(31 downto 0) := (others => '0')
  );
end entity gc_tick;

architecture rtl of gc_tick is

  -- Clocks since the last tick, this one included.
  signal elapsed : unsigned(31 downto 0) := to_unsigned(1, 32);

begin

  p_tick : process (clk) is
  begin

    if rising_edge(clk) then
      out_valid <= '0';
      elapsed <= elapsed + 1;
      if cfg_enable = '0' then
        elapsed <= to_unsigned(1, 32);
      elsif elapsed >= cfg_clocks then
        elapsed <= to_unsigned(1, 32);
        out_valid <= '1';
      end if;
      if out_valid = '1' and in_ready = '0' then
        sts_missed <= sts_missed + 1;
      end if;
      if rst = '1' then
        elapsed <= to_unsigned(1, 32);
        out_valid <= '0';
        sts_missed <= (others => '0');
      end if;
    end if;

  end process p_tick;

end architecture rtl;
