-- SPDX-License-Identifier: MIT
--
-- expired = '1' when the last cfg_clocks + 1 clocks were all without a restart; '0' after a restart or reset.
--
-- A limit of 0 expires in the first clock without a restart: no limit switches the time-out off.
-- Latency: 1 clock. Overflow: none, the count stops at the limit.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity gc_timeout is
  port (
    clk        : in    std_ulogic;
    -- Synchronous, active high.
    rst        : in    std_ulogic;
    restart    : in    std_ulogic;
    -- Limit, clocks; a change takes effect at once.
    cfg_clocks : in    unsigned(31 downto 0);
    expired    : out   std_ulogic := '0'
  );
end entity gc_timeout;

architecture rtl of gc_timeout is

  -- Clocks without a restart.
  signal quiet : unsigned(31 downto 0) := (others => '0');

begin

  p_count : process (clk) is
  begin

    if rising_edge(clk) then
      expired <= '0';
      if quiet < cfg_clocks then
        quiet <= quiet + 1;
      else
        expired <= '1';
      end if;

      if restart = '1' or rst = '1' then
        quiet <= (others => '0');
        expired <= '0';
      end if;
    end if;

  end process p_count;

end architecture rtl;
