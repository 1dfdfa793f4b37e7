-- SPDX-License-Identifier: MIT
--
-- Place of a board's PLL: the core's clock from that of the oscillator.
--
-- In a bitstream the module of this name that board.toml names, with the part's primitive, takes its place. As it stands
-- here, for simulation, it lets the clock through.
-- Latency: none.

library ieee;
  use ieee.std_logic_1164.all;

entity gc_pll is
  port (
    clk_in  : in    std_ulogic;
    clk_out : out   std_ulogic;
    -- clk_out runs at its frequency; asynchronous.
    locked  : out   std_ulogic
  );
end entity gc_pll;

architecture rtl of gc_pll is

begin

  clk_out <= clk_in;
  locked  <= '1';

end architecture rtl;
