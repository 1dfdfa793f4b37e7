-- SPDX-License-Identifier: MIT
--
-- gc_weight_rom with the words 1, 2, 3 ...: a top without an unconstrained generic, for the simulator.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity gc_weight_rom_bench is
  generic (
    words_g : positive := 20;
    lanes_g : positive := 4;
    lane_g  : natural := 0;
    ring_g  : boolean := false
  );
  port (
    clk      : in    std_ulogic;
    rst      : in    std_ulogic;
    in_valid : in    std_ulogic;
    out_word : out   std_ulogic_vector(7 downto 0)
  );
end entity gc_weight_rom_bench;

architecture sim of gc_weight_rom_bench is

  function table return std_ulogic_vector is

    variable table_v : std_ulogic_vector(words_g * 8 - 1 downto 0);

  begin

    for i in 0 to words_g - 1 loop

      table_v((i + 1) * 8 - 1 downto i * 8) := std_ulogic_vector(to_unsigned(i + 1, 8));

    end loop;

    return table_v;

  end function table;

begin

  i_rom : entity work.gc_weight_rom
    generic map (
      word_bits_g => 8,
      words_g     => words_g,
      lanes_g     => lanes_g,
      lane_g      => lane_g,
      table_g     => table,
      ring_g      => ring_g
    )
    port map (
      clk      => clk,
      rst      => rst,
      in_valid => in_valid,
      out_word => out_word
    );

end architecture sim;
