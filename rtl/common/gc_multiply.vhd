-- SPDX-License-Identifier: MIT
--
-- out_product = in_a * in_b, signed, full precision.
--
-- Operands and product are registered, so that the whole entity fits one DSP block with its own registers; a vendor's
-- primitive may replace it by a mapping file. The data have no clock enable, which would have to reach every DSP block:
-- the product follows the operands whatever in_valid says, and holds as long as they do.
--
-- Formats: a_bits_g x b_bits_g -> a_bits_g + b_bits_g. Latency: 2 clocks. Overflow: cannot happen.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity gc_multiply is
  generic (
    -- Width of each operand, bits.
    a_bits_g : positive := 18;
    b_bits_g : positive := 18
  );
  port (
    clk         : in    std_ulogic;
    -- Synchronous, active high; clears the valid bits.
    rst         : in    std_ulogic;
    in_valid    : in    std_ulogic;
    in_a        : in    signed(a_bits_g - 1 downto 0);
    in_b        : in    signed(b_bits_g - 1 downto 0);
    out_valid   : out   std_ulogic;
    out_product : out   signed(a_bits_g + b_bits_g - 1 downto 0)
  );
end entity gc_multiply;

architecture rtl of gc_multiply is

  signal valid_1   : std_ulogic := '0';
  signal valid_2   : std_ulogic := '0';
  signal a_1       : signed(a_bits_g - 1 downto 0);
  signal b_1       : signed(b_bits_g - 1 downto 0);
  signal product   : signed(a_bits_g + b_bits_g - 1 downto 0);
  signal product_2 : signed(a_bits_g + b_bits_g - 1 downto 0);

begin

  -- Outside the process: a simulator multiplies only when an operand changes.
  product <= a_1 * b_1;

  p_multiply : process (clk) is
  begin

    if rising_edge(clk) then
      -- stage 1
      a_1 <= in_a;
      b_1 <= in_b;
      valid_1 <= in_valid;
      -- stage 2
      product_2 <= product;
      valid_2 <= valid_1;
      if rst = '1' then
        valid_1 <= '0';
        valid_2 <= '0';
      end if;
    end if;

  end process p_multiply;

  out_valid <= valid_2;
  out_product <= product_2;

end architecture rtl;
