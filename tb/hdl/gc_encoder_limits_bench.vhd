-- SPDX-License-Identifier: MIT
--
-- The functions of gc_encoder_pkg for every filter of 0 to filters_g - 1 samples, the first one lowest.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_encoder_pkg.all;

entity gc_encoder_limits_bench is
  generic (
    filters_g : positive := 16
  );
  port (
    out_levels  : out   unsigned(filters_g * 8 - 1 downto 0);
    out_periods : out   unsigned(filters_g * 8 - 1 downto 0)
  );
end entity gc_encoder_limits_bench;

architecture sim of gc_encoder_limits_bench is

begin

  g_filter : for i in 0 to filters_g - 1 generate
    out_levels((i + 1) * 8 - 1 downto i * 8)  <= to_unsigned(shortest_level(i), 8);
    out_periods((i + 1) * 8 - 1 downto i * 8) <= to_unsigned(shortest_period(i), 8);
  end generate g_filter;

end architecture sim;
