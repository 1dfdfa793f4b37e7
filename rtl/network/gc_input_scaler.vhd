-- SPDX-License-Identifier: MIT
--
-- x = S_i count: drops bits of each encoder count, multiplies by the scale, clamps to the trained range. In the lean
-- form the scale is part of the hidden weights: x is the count without those bits, clamped.
-- Axes that turn are left out: gc_turn_stage takes them.
--
-- The count is compared while it is multiplied: the product of a count outside the range is replaced by that of the
-- limit.
-- The offset of the normalisation and the half LSBs of the two truncations are part of the hidden biases.
-- Formats: 32-bit counts -> 18 bits, x_fraction_c. Latency: 3 clocks, or their number + 3 with one multiplier; in the
-- lean form 1. Out_x holds until the next result. Overflow: cannot happen after the clamp. Illegal input: a count
-- outside the trained range is clamped and its bit of out_clamped set.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_facts_pkg.all;
  use work.gc_fixed_pkg.all;
  use work.gc_image_pkg.all;
  use work.gc_network_pkg.all;
  use work.gc_scalars_pkg.all;

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
    -- Normalised positions of the axes that do not turn, the first lowest.
    out_x       : out   signed((inputs_c - ones(turning_c)) * operand_bits_c - 1 downto 0);
    -- Count of such an axis was outside the trained range.
    out_clamped : out   std_ulogic_vector(inputs_c - ones(turning_c) - 1 downto 0);
    -- Constants in use.
    scalars     : in    scalars_t := rom_scalars_c
  );
end entity gc_input_scaler;

architecture rtl of gc_input_scaler is

  constant product_bits_c : positive := 2 * operand_bits_c;
  constant positions_c    : natural  := inputs_c - ones(turning_c);

  -- What a count within the trained range is to the multiplier.

  function code (
    count : signed;
    axis  : natural
  ) return signed is
  begin

    return truncate(count, count_shift_c(axis), operand_bits_c);

  end function code;

  signal codes   : signed(positions_c * operand_bits_c - 1 downto 0);
  signal scales  : signed(positions_c * operand_bits_c - 1 downto 0);
  -- Position k: below the range 2 k, above it 2 k + 1.
  signal outside : std_ulogic_vector(2 * positions_c - 1 downto 0);
  signal far     : std_ulogic_vector(2 * positions_c - 1 downto 0);
  signal valid_1 : std_ulogic := '0';
  signal codes_1 : signed(positions_c * operand_bits_c - 1 downto 0);
  signal valid   : std_ulogic;
  signal product : signed(positions_c * product_bits_c - 1 downto 0);
  signal x       : signed(positions_c * operand_bits_c - 1 downto 0);
  signal clamped : std_ulogic_vector(positions_c - 1 downto 0);

begin

  g_axis : for i in 0 to inputs_c - 1 generate

    g_position : if turning_c(i) = '0' generate
      -- Place among the positions, and among all that the hidden layer sees.
      constant k_c     : natural := i - ones(turning_c(i downto 0));
      constant first_c : natural := (i + ones(turning_c(i downto 0))) * operand_bits_c;
      constant low_c   : natural := k_c * operand_bits_c;
      constant high_c  : natural := low_c + operand_bits_c - 1;
      signal   count   : signed(count_bits_c - 1 downto 0);
    begin

      count <= in_count((i + 1) * count_bits_c - 1 downto i * count_bits_c);
      codes(high_c downto low_c) <= code(count, i);
      scales(high_c downto low_c) <= scalars.input_scale((i + 1) * operand_bits_c - 1 downto i * operand_bits_c);

      -- stage 1: compare; holds until the next count

      g_whole : if not lean_c generate

        p_compare : process (clk) is
        begin

          if rising_edge(clk) then
            if in_valid = '1' then
              outside(2 * k_c) <= '0';
              if count < scalars.count_low((i + 1) * count_bits_c - 1 downto i * count_bits_c) then
                outside(2 * k_c) <= '1';
              end if;
              outside(2 * k_c + 1) <= '0';
              if count > scalars.count_high((i + 1) * count_bits_c - 1 downto i * count_bits_c) then
                outside(2 * k_c + 1) <= '1';
              end if;
            end if;
          end if;

        end process p_compare;

      end generate g_whole;

      -- No scale hides the comparison: it is made on as many bits as the limits have, beside a look at those above.

      g_narrow : if lean_c generate
        constant bits_c   : positive := operand_bits_c + count_shift_c(i);
        signal   is_wide  : std_ulogic;
        signal   is_below : std_ulogic;
        signal   is_above : std_ulogic;
      begin
        is_wide <= overflows(count, bits_c);
        is_below <= '1' when count(bits_c - 1 downto 0)
                             < scalars.count_low(i * count_bits_c + bits_c - 1 downto i * count_bits_c) else
                    '0';
        is_above <= '1' when count(bits_c - 1 downto 0)
                             > scalars.count_high(i * count_bits_c + bits_c - 1 downto i * count_bits_c) else
                    '0';

        -- Gates: where an `if` chose, Yosys would take the way through the set of the flip-flops, which is slower.
        p_compare : process (clk) is
        begin

          if rising_edge(clk) then
            if in_valid = '1' then
              outside(2 * k_c) <= (is_wide and count(count_bits_c - 1)) or (is_below and not is_wide);
              outside(2 * k_c + 1) <= (is_wide and not count(count_bits_c - 1)) or (is_above and not is_wide);
            end if;
          end if;

        end process p_compare;

      end generate g_narrow;

      -- clamp

      p_clamp : process (all) is

        variable x_v : operand_t;

      begin

        x_v := truncate(product((k_c + 1) * product_bits_c - 1 downto k_c * product_bits_c), input_scale_fraction_c(i),
                        operand_bits_c);

        if far(2 * k_c) = '1' then
          x_v := scalars.x_low(first_c + operand_bits_c - 1 downto first_c);
        elsif far(2 * k_c + 1) = '1' then
          x_v := scalars.x_high(first_c + operand_bits_c - 1 downto first_c);
        end if;

        x(high_c downto low_c) <= x_v;
        clamped(k_c) <= far(2 * k_c) or far(2 * k_c + 1);

      end process p_clamp;

    end generate g_position;

  end generate g_axis;

  -- stage 1, where nothing multiplies at once: hold

  g_wait : if serial_g or lean_c generate

    p_wait : process (clk) is
    begin

      if rising_edge(clk) then
        valid_1 <= in_valid;
        if in_valid = '1' then
          codes_1 <= codes;
        end if;
        if rst = '1' then
          valid_1 <= '0';
        end if;
      end if;

    end process p_wait;

  end generate g_wait;

  -- Without a scale the lanes' multipliers take what leaves the clamp into their own registers.

  g_lean : if lean_c generate

    g_code : for k in 0 to positions_c - 1 generate
      product((k + 1) * product_bits_c - 1 downto k * product_bits_c)
 <= resize(codes_1((k + 1) * operand_bits_c - 1 downto k * operand_bits_c), product_bits_c);
    end generate g_code;

    far <= outside;
    out_valid <= valid_1;
    out_x <= x;
    out_clamped <= clamped;
  end generate g_lean;

  -- One multiplier takes its clocks: the codes wait for it, its products hold.

  g_serial : if serial_g and not lean_c generate

    i_scale : entity work.gc_scale
      generic map (
        values_g => positions_c,
        serial_g => true
      )
      port map (
        clk          => clk,
        rst          => rst,
        in_valid     => valid_1,
        in_values    => codes_1,
        out_valid    => valid,
        out_products => product,
        factors      => scales
      );

    i_far : entity work.gc_delay
      generic map (
        bits_g   => 2 * positions_c,
        clocks_g => scale_latency(positions_c, true)
      )
      port map (
        clk      => clk,
        in_data  => outside,
        out_data => far
      );

    out_valid <= valid;
    out_x <= x;
    out_clamped <= clamped;
  end generate g_serial;

  -- stages 1 and 2: multiply; stage 3: clamp, so that the way from the DSP blocks to all lanes starts at a register

  g_parallel : if not serial_g and not lean_c generate
    signal valid_3   : std_ulogic := '0';
    signal x_3       : signed(positions_c * operand_bits_c - 1 downto 0);
    signal clamped_3 : std_ulogic_vector(positions_c - 1 downto 0);
  begin

    i_scale : entity work.gc_scale
      generic map (
        values_g => positions_c
      )
      port map (
        clk          => clk,
        rst          => rst,
        in_valid     => in_valid,
        in_values    => codes,
        out_valid    => valid,
        out_products => product,
        factors      => scales
      );

    p_clamped : process (clk) is
    begin

      if rising_edge(clk) then
        far <= outside;
        valid_3 <= valid;
        if valid = '1' then
          x_3 <= x;
          clamped_3 <= clamped;
        end if;
        if rst = '1' then
          valid_3 <= '0';
        end if;
      end if;

    end process p_clamped;

    out_valid <= valid_3;
    out_x <= x_3;
    out_clamped <= clamped_3;
  end generate g_parallel;

end architecture rtl;
