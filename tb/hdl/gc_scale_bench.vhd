-- SPDX-License-Identifier: MIT
--
-- gc_scale with factors 1001, 2002, 3003 ...: a top without an unconstrained generic, for the simulator.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity gc_scale_bench is
  generic (
    values_g : positive := 3;
    serial_g : boolean := false
  );
  port (
    clk          : in    std_ulogic;
    rst          : in    std_ulogic;
    in_valid     : in    std_ulogic;
    in_values    : in    signed(values_g * 18 - 1 downto 0);
    out_valid    : out   std_ulogic;
    out_products : out   signed(values_g * 36 - 1 downto 0)
  );
end entity gc_scale_bench;

architecture sim of gc_scale_bench is

  function factors return signed is

    variable factors_v : signed(values_g * 18 - 1 downto 0);

  begin

    for i in 0 to values_g - 1 loop

      factors_v((i + 1) * 18 - 1 downto i * 18) := to_signed(1001 * (i + 1), 18);

    end loop;

    return factors_v;

  end function factors;

begin

  i_scale : entity work.gc_scale
    generic map (
      values_g => values_g,
      serial_g => serial_g
    )
    port map (
      clk          => clk,
      rst          => rst,
      in_valid     => in_valid,
      in_values    => in_values,
      out_valid    => out_valid,
      out_products => out_products,
      factors      => factors
    );

end architecture sim;
