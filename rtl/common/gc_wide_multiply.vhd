-- SPDX-License-Identifier: MIT
--
-- out_product = in_a * in_b, signed, of operands of any width; modulo 2**product_bits_g where not all bits are kept.
--
-- One rule for every width: operands that fit 18 bits are multiplied by one gc_multiply; a wider one is cut into parts
-- of 17 bits, unsigned but for the highest, each product of two parts is a gc_multiply, and a tree adds them. Products
-- that lie above the bits that are kept are not made.
-- Formats: a_bits_g x b_bits_g -> product_bits_g. Latency: product_latency of gc_fixed_pkg, 2 clocks and one per level
-- of adders. Overflow: cannot happen.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_facts_pkg.all;
  use work.gc_fixed_pkg.all;

entity gc_wide_multiply is
  generic (
    -- Width of each operand and of the product, bits; of a full product the sum of theirs.
    a_bits_g       : positive := 32;
    b_bits_g       : positive := 25;
    product_bits_g : positive := 57
  );
  port (
    clk         : in    std_ulogic;
    -- Synchronous, active high; clears the valid bits.
    rst         : in    std_ulogic;
    in_valid    : in    std_ulogic;
    in_a        : in    signed(a_bits_g - 1 downto 0);
    in_b        : in    signed(b_bits_g - 1 downto 0);
    out_valid   : out   std_ulogic;
    out_product : out   signed(product_bits_g - 1 downto 0)
  );
end entity gc_wide_multiply;

architecture rtl of gc_wide_multiply is

  constant a_parts_c : positive := product_parts(a_bits_g);
  constant b_parts_c : positive := product_parts(b_bits_g);
  constant terms_c   : positive := product_terms(a_bits_g, b_bits_g, product_bits_g);

begin

  assert product_bits_g <= a_bits_g + b_bits_g
    report "gc_wide_multiply: need at most " & integer'image(a_bits_g + b_bits_g) & " bits of product, got "
           & integer'image(product_bits_g)
    severity failure;

  g_narrow : if a_parts_c = 1 and b_parts_c = 1 generate
    signal product_2 : signed(a_bits_g + b_bits_g - 1 downto 0);
  begin

    i_part : entity work.gc_multiply
      generic map (
        a_bits_g => a_bits_g,
        b_bits_g => b_bits_g
      )
      port map (
        clk         => clk,
        rst         => rst,
        in_valid    => in_valid,
        in_a        => in_a,
        in_b        => in_b,
        out_valid   => out_valid,
        out_product => product_2
      );

    out_product <= product_2(product_bits_g - 1 downto 0);
  end generate g_narrow;

  g_wide : if a_parts_c > 1 or b_parts_c > 1 generate
    signal valid_2 : std_ulogic_vector(terms_c - 1 downto 0);
    signal terms_2 : signed(terms_c * product_bits_g - 1 downto 0);
  begin

    -- stages 1 and 2: multiply

    g_a : for i in 0 to a_parts_c - 1 generate

      g_b : for k in 0 to b_parts_c - 1 generate
        constant low_c : natural := (i + k) * part_bits_c;
      begin

        g_part : if low_c < product_bits_g generate
          -- Place among the products that are made.
          constant term_c    : natural := product_place(i, k, b_bits_g, product_bits_g);
          signal   product_2 : signed(2 * operand_bits_c - 1 downto 0);
          signal   term_2    : signed(product_bits_g - 1 downto 0);
        begin

          i_part : entity work.gc_multiply
            generic map (
              a_bits_g => operand_bits_c,
              b_bits_g => operand_bits_c
            )
            port map (
              clk         => clk,
              rst         => rst,
              in_valid    => in_valid,
              in_a        => product_part(in_a, i),
              in_b        => product_part(in_b, k),
              out_valid   => valid_2(term_c),
              out_product => product_2
            );

          -- Extended above the product, cut at the bits that are kept.
          p_term : process (all) is
          begin

            for bit_number in 0 to product_bits_g - 1 loop

              if bit_number < low_c then
                term_2(bit_number) <= '0';
              elsif bit_number - low_c < product_2'length then
                term_2(bit_number) <= product_2(bit_number - low_c);
              else
                term_2(bit_number) <= product_2(product_2'high);
              end if;

            end loop;

          end process p_term;

          terms_2((term_c + 1) * product_bits_g - 1 downto term_c * product_bits_g) <= term_2;
        end generate g_part;

      end generate g_b;

    end generate g_a;

    -- stages from 3 on: add
    i_add : entity work.gc_adder_tree
      generic map (
        terms_g       => terms_c,
        bits_g        => product_bits_g,
        term_clocks_g => 0
      )
      port map (
        clk       => clk,
        rst       => rst,
        in_valid  => valid_2(0),
        in_terms  => terms_2,
        out_valid => out_valid,
        out_sum   => out_product
      );

  end generate g_wide;

end architecture rtl;
