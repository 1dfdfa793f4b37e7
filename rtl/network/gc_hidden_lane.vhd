-- SPDX-License-Identifier: MIT
--
-- a = W x + b for one hidden neuron per clock: features_c products and one n-ary sum with the bias, then saturation to
-- the range [-L, L) of the activation. In the lean form products lose bits before they are summed, and no register
-- follows the saturation: the next multiplier has it.
--
-- Lane l of lanes_g computes the neurons l, l + lanes_g ... in turn, one per in_valid, all on the same x.
-- Formats: 18 bits, x_fraction_c -> 18 bits, preactivation_fraction_c, truncated (half LSB in the bias).
-- Latency: 3 + ceil(log2(features_c + 1)) clocks, one more with one lane; in the lean form 2 + ceil(log2(features_c +
-- 1)). Overflow: the sum cannot, hidden_sum_bits_c holds every partial sum.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_facts_pkg.all;
  use work.gc_fixed_pkg.all;
  use work.gc_image_pkg.all;
  use work.gc_network_pkg.all;

entity gc_hidden_lane is
  generic (
    -- Lanes, and which of them this is.
    lanes_g    : positive := 1;
    lane_g     : natural := 0;
    -- Whether the weights can be replaced, through the port memory.
    loadable_g : boolean := false
  );
  port (
    clk       : in    std_ulogic;
    -- Synchronous, active high; clears valid and state.
    rst       : in    std_ulogic;
    in_valid  : in    std_ulogic;
    -- What gc_input_stage tells of the axes, axis 1 lowest.
    in_x      : in    signed(features_c * operand_bits_c - 1 downto 0);
    out_valid : out   std_ulogic;
    -- Pre-activation of the neuron.
    out_a     : out   operand_t;
    -- Loaded words; read where loadable_g.
    memory    : in    memory_t := rom_memory_c
  );
end entity gc_hidden_lane;

architecture rtl of gc_hidden_lane is

  constant sum_bits_c     : positive := hidden_sum_bits_c;
  constant bias_low_c     : positive := features_c * operand_bits_c;
  constant product_bits_c : positive := 2 * operand_bits_c;
  constant kept_bits_c    : positive := hidden_sum_bits_c - preactivation_drop_c;

  signal word      : std_ulogic_vector(hidden_word_bits_c - 1 downto 0);
  signal bias_1    : signed(sum_bits_c - 1 downto 0);
  signal bias_2    : signed(sum_bits_c - 1 downto 0);
  signal valid_2   : std_ulogic_vector(features_c - 1 downto 0);
  signal terms_2   : signed((features_c + 1) * sum_bits_c - 1 downto 0);
  signal sum_valid : std_ulogic;
  signal sum       : signed(sum_bits_c - 1 downto 0);

begin

  g_weights : if loadable_g generate

    i_bank : entity work.gc_weight_bank
      generic map (
        word_bits_g => hidden_word_bits_c,
        words_g     => hidden_c,
        lanes_g     => lanes_g,
        lane_g      => lane_g,
        section_g   => hidden_section_c,
        table_g     => flat(hidden_words_c)
      )
      port map (
        clk      => clk,
        rst      => rst,
        in_valid => in_valid,
        out_word => word,
        memory   => memory
      );

  else generate

    i_rom : entity work.gc_weight_rom
      generic map (
        word_bits_g => hidden_word_bits_c,
        words_g     => hidden_c,
        lanes_g     => lanes_g,
        lane_g      => lane_g,
        table_g     => flat(hidden_words_c),
        ring_g      => lean_c
      )
      port map (
        clk      => clk,
        rst      => rst,
        in_valid => in_valid,
        out_word => word
      );

  end generate g_weights;

  -- stages 1 and 2: multiply

  g_input : for i in 0 to features_c - 1 generate
    signal product_2 : signed(product_bits_c - 1 downto 0);
  begin

    i_multiply : entity work.gc_multiply
      generic map (
        a_bits_g => operand_bits_c,
        b_bits_g => operand_bits_c
      )
      port map (
        clk         => clk,
        rst         => rst,
        in_valid    => in_valid,
        in_a        => in_x((i + 1) * operand_bits_c - 1 downto i * operand_bits_c),
        in_b        => signed(word((i + 1) * operand_bits_c - 1 downto i * operand_bits_c)),
        out_valid   => valid_2(i),
        out_product => product_2
      );

    terms_2((i + 1) * sum_bits_c - 1 downto i * sum_bits_c) <= truncate(product_2, hidden_product_drop_c, sum_bits_c);
  end generate g_input;

  p_bias : process (clk) is
  begin

    if rising_edge(clk) then
      bias_1 <= signed(word(bias_low_c + sum_bits_c - 1 downto bias_low_c));
      bias_2 <= bias_1;
    end if;

  end process p_bias;

  terms_2((features_c + 1) * sum_bits_c - 1 downto features_c * sum_bits_c) <= bias_2;

  i_sum : entity work.gc_adder_tree
    generic map (
      terms_g       => features_c + 1,
      bits_g        => sum_bits_c,
      term_clocks_g => hidden_term_clocks(lanes_g, lean_c)
    )
    port map (
      clk       => clk,
      rst       => rst,
      in_valid  => valid_2(0),
      in_terms  => terms_2,
      out_valid => sum_valid,
      out_sum   => sum
    );

  -- last stage: truncate and saturate

  g_lean : if lean_c generate
    out_valid <= sum_valid;
    out_a <= saturate(truncate(sum, preactivation_drop_c, kept_bits_c), operand_bits_c);
  end generate g_lean;

  g_paper : if not lean_c generate
    signal valid_a : std_ulogic := '0';
    signal a       : operand_t;
  begin

    p_saturate : process (clk) is
    begin

      if rising_edge(clk) then
        a <= saturate(truncate(sum, preactivation_drop_c, kept_bits_c), operand_bits_c);
        valid_a <= sum_valid;
        if rst = '1' then
          valid_a <= '0';
        end if;
      end if;

    end process p_saturate;

    out_valid <= valid_a;
    out_a <= a;
  end generate g_paper;

end architecture rtl;
