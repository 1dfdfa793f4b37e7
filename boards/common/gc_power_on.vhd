-- SPDX-License-Identifier: MIT
--
-- Reset of a board: from power-up, and from whenever the PLL or the button asks for it, for long enough that gc_system
-- sees it on both of its clocks.
--
-- Latency: rst is high at power-up, and from 3 clocks after request on; it ends clocks_g clocks after request did.

library ieee;
  use ieee.std_logic_1164.all;

entity gc_power_on is
  generic (
    -- 8 clocks of the slower of the two clocks, in clocks of clk, and the start of the oscillator.
    clocks_g : positive := 1023
  );
  port (
    clk     : in    std_ulogic;
    -- Asynchronous: no lock of the PLL, or the button.
    request : in    std_ulogic;
    rst     : out   std_ulogic := '1'
  );
end entity gc_power_on;

architecture rtl of gc_power_on is

  signal asked : std_ulogic;
  signal left  : natural range 0 to clocks_g := clocks_g;

begin

  i_synchronizer : entity work.gc_synchronizer
    port map (
      clk           => clk,
      rst           => '0',
      async_data(0) => request,
      out_valid     => open,
      out_data(0)   => asked
    );

  p_reset : process (clk) is
  begin

    if rising_edge(clk) then
      rst <= '1';
      if asked = '1' then
        left <= clocks_g;
      elsif left /= 0 then
        left <= left - 1;
      else
        rst <= '0';
      end if;
    end if;

  end process p_reset;

end architecture rtl;
