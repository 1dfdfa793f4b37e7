-- SPDX-License-Identifier: MIT
--
-- out_sum = sum of in_terms: one n-ary sum, a register after every two-operand adder and, if wanted, at every term.
--
-- The registers at the terms stand near the adders: the way from a DSP block takes a clock of its own.
-- Formats: terms_g terms of bits_g bits, term 0 lowest in the vector -> bits_g.
-- Latency: term_clocks_g + ceil(log2(terms_g)) clocks. Overflow: wraps; bits_g must hold every partial sum.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_fixed_pkg.all;

entity gc_adder_tree is
  generic (
    -- Number of terms.
    terms_g       : positive := 4;
    -- Width of every term and of the sum, bits.
    bits_g        : positive := 38;
    -- Registers at the terms: 1, or none: 0.
    term_clocks_g : natural range 0 to 1 := 1
  );
  port (
    clk       : in    std_ulogic;
    -- Synchronous, active high; clears the valid bits.
    rst       : in    std_ulogic;
    in_valid  : in    std_ulogic;
    in_terms  : in    signed(terms_g * bits_g - 1 downto 0);
    out_valid : out   std_ulogic;
    out_sum   : out   signed(bits_g - 1 downto 0)
  );
end entity gc_adder_tree;

architecture rtl of gc_adder_tree is

  constant depth_c  : natural := tree_depth(terms_g);
  -- Terms after padding with zeros to a power of two; adders of two zeros vanish in synthesis.
  constant leaves_c : positive := 2 ** depth_c;

  type sums_t is array (natural range <>) of signed(bits_g - 1 downto 0);

  -- A heap: node 1 is the root, nodes 2k and 2k + 1 feed node k, the leaves are at the end.
  signal node  : sums_t(1 to 2 * leaves_c - 1);
  signal valid : std_ulogic_vector(0 to depth_c + term_clocks_g) := (others => '0');

begin

  g_leaf : for i in 0 to leaves_c - 1 generate

    g_near : if i < terms_g and term_clocks_g = 0 generate
      node(leaves_c + i) <= in_terms((i + 1) * bits_g - 1 downto i * bits_g);
    end generate g_near;

    g_term : if i < terms_g and term_clocks_g = 1 generate

      p_term : process (clk) is
      begin

        if rising_edge(clk) then
          node(leaves_c + i) <= in_terms((i + 1) * bits_g - 1 downto i * bits_g);
        end if;

      end process p_term;

    end generate g_term;

    g_padding : if i >= terms_g generate
      node(leaves_c + i) <= (others => '0');
    end generate g_padding;

  end generate g_leaf;

  g_node : for k in 1 to leaves_c - 1 generate

    p_add : process (clk) is
    begin

      if rising_edge(clk) then
        node(k) <= node(2 * k) + node(2 * k + 1);
      end if;

    end process p_add;

  end generate g_node;

  valid(0) <= in_valid;

  g_valid : for i in 1 to depth_c + term_clocks_g generate

    p_valid : process (clk) is
    begin

      if rising_edge(clk) then
        valid(i) <= valid(i - 1);
        if rst = '1' then
          valid(i) <= '0';
        end if;
      end if;

    end process p_valid;

  end generate g_valid;

  out_valid <= valid(depth_c + term_clocks_g);
  out_sum <= node(1);

end architecture rtl;
