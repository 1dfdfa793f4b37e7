-- SPDX-License-Identifier: MIT
--
-- The functions of gc_fixed_pkg on an 8-bit value, for the simulator.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_fixed_pkg.all;

entity gc_fixed_bench is
  port (
    value         : in    signed(7 downto 0);
    out_truncated : out   signed(5 downto 0);
    out_saturated : out   signed(4 downto 0);
    out_overflows : out   std_ulogic
  );
end entity gc_fixed_bench;

architecture sim of gc_fixed_bench is

begin

  out_truncated <= truncate(value, 2, 6);
  out_saturated <= saturate(value, 5);
  out_overflows <= overflows(value, 5);

end architecture sim;
