-- SPDX-License-Identifier: MIT
--
-- Place of a board's PLL: the core's clock from that of the oscillator.
--
-- In a bitstream the module of this name that board.toml names, with the part's primitive, takes its place. As it stands
-- here, for simulation, it divides the clock by eight: the core counts its times in clocks, and fewer are simulated.
-- Latency: locked 8 clocks after power-up.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity gc_pll is
  port (
    clk_in  : in    std_ulogic;
    clk_out : out   std_ulogic;
    -- clk_out runs at its frequency; asynchronous.
    locked  : out   std_ulogic := '0'
  );
end entity gc_pll;

architecture rtl of gc_pll is

  signal count : unsigned(2 downto 0) := (others => '0');

begin

  p_divide : process (clk_in) is
  begin

    if rising_edge(clk_in) then
      count <= count + 1;
      if count = 7 then
        locked <= '1';
      end if;
    end if;

  end process p_divide;

  clk_out <= count(2);

end architecture rtl;
