-- SPDX-License-Identifier: MIT
--
-- x = S_i count: clamps each encoder count to the trained range, drops count_shift_c bits, multiplies by the scale.
--
-- The offset of the normalisation and the half LSBs of the two truncations are part of the hidden biases.
-- Formats: 32-bit counts -> 18 bits, x_fraction_c. Latency: 5 clocks, or inputs_c + 4 with one multiplier; out_x holds
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

  -- What a count within the trained range is to the multiplier.

  function code (
    count : signed
  ) return signed is
  begin

    return truncate(count, count_shift_c, operand_bits_c);

  end function code;

  signal valid_1   : std_ulogic := '0';
  signal valid_2   : std_ulogic := '0';
  signal code_1    : signed(inputs_c * operand_bits_c - 1 downto 0);
  signal below_1   : std_ulogic_vector(inputs_c - 1 downto 0);
  signal above_1   : std_ulogic_vector(inputs_c - 1 downto 0);
  signal code_2    : signed(inputs_c * operand_bits_c - 1 downto 0);
  signal clamped_2 : std_ulogic_vector(inputs_c - 1 downto 0);
  signal product   : signed(inputs_c * product_bits_c - 1 downto 0);
  signal x_valid   : std_ulogic;
  signal x         : signed(inputs_c * operand_bits_c - 1 downto 0);
  signal x_clamped : std_ulogic_vector(inputs_c - 1 downto 0);

begin

  g_clamp : for i in 0 to inputs_c - 1 generate

    p_clamp : process (clk) is

      variable count_v : signed(count_bits_c - 1 downto 0);
      variable code_v  : operand_t;

    begin

      if rising_edge(clk) then
        -- stage 1: compare; holds until the next count
        if in_valid = '1' then
          count_v := in_count((i + 1) * count_bits_c - 1 downto i * count_bits_c);
          code_1((i + 1) * operand_bits_c - 1 downto i * operand_bits_c) <= code(count_v);
          below_1(i) <= '0';
          above_1(i) <= '0';
          if count_v < count_low_c(i) then
            below_1(i) <= '1';
          end if;
          if count_v > count_high_c(i) then
            above_1(i) <= '1';
          end if;
        end if;
        -- stage 2: clamp
        code_v := code_1((i + 1) * operand_bits_c - 1 downto i * operand_bits_c);
        if below_1(i) = '1' then
          code_v := code(to_signed(count_low_c(i), count_bits_c));
        elsif above_1(i) = '1' then
          code_v := code(to_signed(count_high_c(i), count_bits_c));
        end if;
        code_2((i + 1) * operand_bits_c - 1 downto i * operand_bits_c) <= code_v;
        clamped_2(i) <= below_1(i) or above_1(i);
      end if;

    end process p_clamp;

  end generate g_clamp;

  p_valid : process (clk) is
  begin

    if rising_edge(clk) then
      valid_1 <= in_valid;
      valid_2 <= valid_1;
      if rst = '1' then
        valid_1 <= '0';
        valid_2 <= '0';
      end if;
    end if;

  end process p_valid;

  -- stages 3 and 4, or more with one multiplier: multiply
  i_scale : entity work.gc_scale
    generic map (
      values_g  => inputs_c,
      serial_g  => serial_g,
      factors_g => input_scale_c
    )
    port map (
      clk          => clk,
      rst          => rst,
      in_valid     => valid_2,
      in_values    => code_2,
      out_valid    => x_valid,
      out_products => product
    );

  g_x : for i in 0 to inputs_c - 1 generate
    x((i + 1) * operand_bits_c - 1 downto i * operand_bits_c)
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
      in_data  => clamped_2,
      out_data => x_clamped
    );

  g_near : if serial_g generate
    out_valid <= x_valid;
    out_x <= x;
    out_clamped <= x_clamped;
  end generate g_near;

  -- last stage with several lanes: the way from the DSP block to all of them takes a clock of its own

  g_far : if not serial_g generate
    signal valid_5   : std_ulogic := '0';
    signal x_5       : signed(inputs_c * operand_bits_c - 1 downto 0);
    signal clamped_5 : std_ulogic_vector(inputs_c - 1 downto 0);
  begin

    p_x : process (clk) is
    begin

      if rising_edge(clk) then
        valid_5 <= x_valid;
        x_5 <= x;
        clamped_5 <= x_clamped;
        if rst = '1' then
          valid_5 <= '0';
        end if;
      end if;

    end process p_x;

    out_valid <= valid_5;
    out_x <= x_5;
    out_clamped <= clamped_5;
  end generate g_far;

end architecture rtl;
