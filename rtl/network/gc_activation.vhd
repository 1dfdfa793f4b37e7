-- SPDX-License-Identifier: MIT
--
-- h = Gamma(a) = a (beta - theta |a|), beta = 1, theta = 1/4; the clip to |a| <= L = 2 is done by the format of a.
--
-- The product by theta is a shift; it counts as a multiplication of the budget all the same. The slope is truncated,
-- so h stays below +1. At a = 0 the slope is +1, which wraps in its format; the product with a is 0 all the same.
-- In the lean form h = sign(a) (1 - u**2), u = 1 - |a| / 2: u is the lower bits of a, inverted where a >= 0, and 0
-- where a saturates; u**2 less 1 is the product with another top bit, and its complement where a >= 0. No sum is left.
-- Formats: 18 bits, preactivation_fraction_c = 16 -> 18 bits, hidden_fraction_c = 17, truncated (half LSB in the output
-- biases). Latency: 3 clocks, in the lean form 2. Overflow: cannot happen.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_facts_pkg.all;
  use work.gc_fixed_pkg.all;
  use work.gc_network_pkg.all;

entity gc_activation is
  port (
    clk       : in    std_ulogic;
    -- Synchronous, active high; clears the valid bits.
    rst       : in    std_ulogic;
    in_valid  : in    std_ulogic;
    in_a      : in    operand_t;
    out_valid : out   std_ulogic;
    out_h     : out   operand_t
  );
end entity gc_activation;

architecture rtl of gc_activation is

  constant product_bits_c : positive := 2 * operand_bits_c;

  signal product : signed(product_bits_c - 1 downto 0);

begin

  g_paper : if not lean_c generate
    constant drop_c : positive := preactivation_fraction_c + slope_fraction_c - hidden_fraction_c;
    -- beta with 18 fraction bits.
    constant beta_c : signed(operand_bits_c + 1 downto 0) := to_signed(2 ** (slope_fraction_c + 1), operand_bits_c + 2);

    signal valid_1 : std_ulogic := '0';
    signal a_1     : operand_t;
    signal slope_1 : operand_t;
  begin

    -- stage 1: slope = beta - theta |a|; as a sum of beta and a or its complement, without `abs`
    p_slope : process (clk) is

      variable theta_a_v : signed(operand_bits_c + 1 downto 0);

    begin

      if rising_edge(clk) then
        a_1 <= in_a;
        theta_a_v := resize(in_a, operand_bits_c + 2);
        if in_a(in_a'high) = '1' then
          slope_1 <= truncate(beta_c + theta_a_v, 1, operand_bits_c);
        else
          slope_1 <= truncate(beta_c - theta_a_v, 1, operand_bits_c);
        end if;
        valid_1 <= in_valid;
        if rst = '1' then
          valid_1 <= '0';
        end if;
      end if;

    end process p_slope;

    -- stages 2 and 3: multiply
    i_multiply : entity work.gc_multiply
      generic map (
        a_bits_g => operand_bits_c,
        b_bits_g => operand_bits_c
      )
      port map (
        clk         => clk,
        rst         => rst,
        in_valid    => valid_1,
        in_a        => a_1,
        in_b        => slope_1,
        out_valid   => out_valid,
        out_product => product
      );

    out_h <= truncate(product, drop_c, operand_bits_c);
  end generate g_paper;

  g_lean : if lean_c generate
    constant sign_c : natural := operand_bits_c - 1;
    -- Of u**2, which has 2 sign_c fraction bits.
    constant drop_c : natural := 2 * sign_c - hidden_fraction_c;

    signal u          : operand_t;
    -- Whether a < 0, beside the product.
    signal is_below_1 : std_ulogic;
    signal is_below_2 : std_ulogic;
  begin

    u <= '0' & (in_a(sign_c - 1 downto 0) xor (sign_c - 1 downto 0 => not in_a(sign_c)));

    -- stages 1 and 2: square
    i_multiply : entity work.gc_multiply
      generic map (
        a_bits_g => operand_bits_c,
        b_bits_g => operand_bits_c
      )
      port map (
        clk         => clk,
        rst         => rst,
        in_valid    => in_valid,
        in_a        => u,
        in_b        => u,
        out_valid   => out_valid,
        out_product => product
      );

    p_sign : process (clk) is
    begin

      if rising_edge(clk) then
        is_below_1 <= in_a(sign_c);
        is_below_2 <= is_below_1;
      end if;

    end process p_sign;

    out_h <= is_below_2 & (product(drop_c + sign_c - 1 downto drop_c) xor (sign_c - 1 downto 0 => not is_below_2));
  end generate g_lean;

end architecture rtl;
