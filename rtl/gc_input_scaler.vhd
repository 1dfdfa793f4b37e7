-- SPDX-License-Identifier: MIT
--
-- x = S_i count: clamps each encoder count to the trained range, drops count_shift_c bits, multiplies by the scale.
--
-- The offset of the normalisation and the half LSBs of the two truncations are part of the hidden biases.
-- Formats: 32-bit counts -> 18 bits, x_fraction_c. Latency: 3 clocks, or inputs_c + 3 with one multiplier; out_x holds
-- until the next result. Overflow: cannot happen after the clamp. Illegal input: a count outside the trained range is
-- clamped and its bit of out_clamped set.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_fixed_pkg.all;
  use work.gc_network_pkg.all;

entity gc_input_scaler is
  generic (
    -- One multiplier for all axes, in turn.
    serial_g : boolean := false
  );
  port (
    clk         : in    std_ulogic;
    -- Synchronous, active high; clears valid and state.
    rst         : in    std_ulogic;
    in_valid    : in    std_ulogic;
    -- Encoder counts, axis 1 lowest.
    in_count    : in    signed(inputs_c * count_bits_c - 1 downto 0);
    out_valid   : out   std_ulogic;
    -- Normalised positions, axis 1 lowest.
    out_x       : out   signed(inputs_c * operand_bits_c - 1 downto 0);
    -- Count of this axis was outside the trained range.
    out_clamped : out   std_ulogic_vector(inputs_c - 1 downto 0)
  );
end entity gc_input_scaler;

architecture rtl of gc_input_scaler is

  constant product_bits_c : positive := 2 * operand_bits_c;

  signal valid_1   : std_ulogic := '0';
  signal code_1    : signed(inputs_c * operand_bits_c - 1 downto 0);
  signal clamped_1 : std_ulogic_vector(inputs_c - 1 downto 0);
  signal product   : signed(inputs_c * product_bits_c - 1 downto 0);

begin

  -- stage 1: clamp; holds until the next count, as gc_scale asks

  g_clamp : for i in 0 to inputs_c - 1 generate

    p_clamp : process (clk) is

      variable count_v   : signed(count_bits_c - 1 downto 0);
      variable clamped_v : std_ulogic;

    begin

      if rising_edge(clk) then
        if in_valid = '1' then
          count_v := in_count((i + 1) * count_bits_c - 1 downto i * count_bits_c);
          clamped_v := '1';
          if count_v < count_low_c(i) then
            count_v := to_signed(count_low_c(i), count_bits_c);
          elsif count_v > count_high_c(i) then
            count_v := to_signed(count_high_c(i), count_bits_c);
          else
            clamped_v := '0';
          end if;
          code_1((i + 1) * operand_bits_c - 1 downto i * operand_bits_c)
 <= truncate(count_v, count_shift_c, operand_bits_c);
          clamped_1(i) <= clamped_v;
        end if;
      end if;

    end process p_clamp;

  end generate g_clamp;

  p_valid : process (clk) is
  begin

    if rising_edge(clk) then
      valid_1 <= in_valid;
      if rst = '1' then
        valid_1 <= '0';
      end if;
    end if;

  end process p_valid;

  -- stages 2 and 3: multiply
  i_scale : entity work.gc_scale
    generic map (
      values_g  => inputs_c,
      serial_g  => serial_g,
      factors_g => input_scale_c
    )
    port map (
      clk          => clk,
      rst          => rst,
      in_valid     => valid_1,
      in_values    => code_1,
      out_valid    => out_valid,
      out_products => product
    );

  g_x : for i in 0 to inputs_c - 1 generate
    out_x((i + 1) * operand_bits_c - 1 downto i * operand_bits_c)
 <= truncate(product((i + 1) * product_bits_c - 1 downto i * product_bits_c), input_scale_fraction_c,
             operand_bits_c);
  end generate g_x;

  i_flags : entity work.gc_delay
    generic map (
      bits_g   => inputs_c,
      clocks_g => scale_latency(inputs_c, serial_g)
    )
    port map (
      clk      => clk,
      in_data  => clamped_1,
      out_data => out_clamped
    );

end architecture rtl;
