-- SPDX-License-Identifier: MIT
--
-- total = V h + b: output products of lanes_g neurons per clock, an adder tree over the lanes, one accumulator per
-- output that starts from the bias. With all neurons in one clock the bias is a term of the tree instead.
--
-- In_valid comes ceil(hidden_c / lanes_g) times per inference, neurons in the order of gc_hidden_lane.
-- Formats: 18 bits, hidden_fraction_c -> output_sum_bits_c, full precision, or with products that lose bits in the lean
-- form. Latency from the last in_valid of an inference: 3 + ceil(log2(lanes_g)) clocks, with one lane 4 in the paper's
-- form, 3 + ceil(log2(lanes_g + 1)) with all neurons in one clock. Overflow: cannot happen, output_sum_bits_c holds
-- every partial sum.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_facts_pkg.all;
  use work.gc_fixed_pkg.all;
  use work.gc_image_pkg.all;
  use work.gc_network_pkg.all;
  use work.gc_scalars_pkg.all;

entity gc_output_layer is
  generic (
    -- Neurons per clock.
    lanes_g    : positive := 1;
    -- Whether weights can be replaced, through the port memory.
    loadable_g : boolean := false
  );
  port (
    clk       : in    std_ulogic;
    -- Synchronous, active high; clears valid and state.
    rst       : in    std_ulogic;
    in_valid  : in    std_ulogic;
    -- Activations, lane 0 lowest.
    in_h      : in    signed(lanes_g * operand_bits_c - 1 downto 0);
    out_valid : out   std_ulogic;
    -- Output sums, axis 1 lowest.
    out_total : out   signed(outputs_c * output_sum_bits_c - 1 downto 0);
    -- Loaded words; read where loadable_g.
    memory    : in    memory_t := rom_memory_c;
    -- Constants in use.
    scalars   : in    scalars_t := rom_scalars_c
  );
end entity gc_output_layer;

architecture rtl of gc_output_layer is

  constant steps_c        : positive := lane_steps(hidden_c, lanes_g);
  constant sum_bits_c     : positive := output_sum_bits_c;
  constant product_bits_c : positive := 2 * operand_bits_c;

  -- The bias is the last term when there is nothing to accumulate.

  function terms_per_output return positive is
  begin

    if steps_c = 1 then
      return lanes_g + 1;
    end if;

    return lanes_g;

  end function terms_per_output;

  constant terms_c : positive := terms_per_output;

  signal valid_2    : std_ulogic_vector(lanes_g * outputs_c - 1 downto 0);
  -- Output-major: the terms of one output are neighbours.
  signal terms_2    : signed(outputs_c * terms_c * sum_bits_c - 1 downto 0);
  signal tree       : signed(outputs_c * sum_bits_c - 1 downto 0);
  signal tree_valid : std_ulogic_vector(outputs_c - 1 downto 0);

begin

  -- stages 1 and 2: multiply

  g_lane : for lane in 0 to lanes_g - 1 generate
    signal word : std_ulogic_vector(output_word_bits_c - 1 downto 0);
  begin

    g_weights : if loadable_g generate

      i_bank : entity work.gc_weight_bank
        generic map (
          word_bits_g => output_word_bits_c,
          words_g     => hidden_c,
          lanes_g     => lanes_g,
          lane_g      => lane,
          section_g   => output_section_c,
          table_g     => flat(output_words_c)
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
          word_bits_g => output_word_bits_c,
          words_g     => hidden_c,
          lanes_g     => lanes_g,
          lane_g      => lane,
          table_g     => flat(output_words_c),
          ring_g      => lean_c
        )
        port map (
          clk      => clk,
          rst      => rst,
          in_valid => in_valid,
          out_word => word
        );

    end generate g_weights;

    g_output : for k in 0 to outputs_c - 1 generate
      constant term_c    : natural := k * terms_c + lane;
      signal   product_2 : signed(product_bits_c - 1 downto 0);
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
          in_a        => in_h((lane + 1) * operand_bits_c - 1 downto lane * operand_bits_c),
          in_b        => signed(word((k + 1) * operand_bits_c - 1 downto k * operand_bits_c)),
          out_valid   => valid_2(k * lanes_g + lane),
          out_product => product_2
        );

      terms_2((term_c + 1) * sum_bits_c - 1 downto term_c * sum_bits_c)
 <= truncate(product_2, output_product_drop_c, sum_bits_c);
    end generate g_output;

  end generate g_lane;

  -- one stage per level: sum over the lanes

  g_tree : for k in 0 to outputs_c - 1 generate

    i_tree : entity work.gc_adder_tree
      generic map (
        terms_g       => terms_c,
        bits_g        => sum_bits_c,
        term_clocks_g => output_term_clocks(lanes_g, steps_c, lean_c)
      )
      port map (
        clk       => clk,
        rst       => rst,
        in_valid  => valid_2(0),
        in_terms  => terms_2((k + 1) * terms_c * sum_bits_c - 1 downto k * terms_c * sum_bits_c),
        out_valid => tree_valid(k),
        out_sum   => tree((k + 1) * sum_bits_c - 1 downto k * sum_bits_c)
      );

  end generate g_tree;

  g_once : if steps_c = 1 generate

    g_bias : for k in 0 to outputs_c - 1 generate
      terms_2((k + 1) * terms_c * sum_bits_c - 1 downto ((k + 1) * terms_c - 1) * sum_bits_c)
 <= scalars.output_bias((k + 1) * sum_bits_c - 1 downto k * sum_bits_c);
    end generate g_bias;

    out_valid <= tree_valid(0);
    out_total <= tree;
  end generate g_once;

  -- last stage: accumulate; the bias, where the next sum starts, is the reset value and needs no multiplexer

  g_accumulate : if steps_c > 1 generate
    signal step  : std_ulogic_vector(steps_c - 1 downto 0);
    signal last  : std_ulogic;
    signal acc   : signed(outputs_c * sum_bits_c - 1 downto 0) := output_bias_c;
    signal total : signed(outputs_c * sum_bits_c - 1 downto 0);
    signal valid : std_ulogic := '0';
  begin

    i_step : entity work.gc_ring
      generic map (
        length_g => steps_c
      )
      port map (
        clk      => clk,
        rst      => rst,
        in_valid => tree_valid(0),
        out_turn => step
      );

    last <= step(steps_c - 1) and tree_valid(0);

    g_output : for k in 0 to outputs_c - 1 generate
      constant low_c  : natural := k * sum_bits_c;
      constant high_c : natural := low_c + sum_bits_c - 1;
    begin

      p_accumulate : process (clk) is

        variable sum_v : signed(sum_bits_c - 1 downto 0);

      begin

        if rising_edge(clk) then
          sum_v := acc(high_c downto low_c) + tree(high_c downto low_c);
          if tree_valid(0) = '1' then
            acc(high_c downto low_c) <= sum_v;
            total(high_c downto low_c) <= sum_v;
          end if;
          if rst = '1' or last = '1' then
            acc(high_c downto low_c) <= scalars.output_bias(high_c downto low_c);
          end if;
        end if;

      end process p_accumulate;

    end generate g_output;

    p_valid : process (clk) is
    begin

      if rising_edge(clk) then
        valid <= last;
        if rst = '1' then
          valid <= '0';
        end if;
      end if;

    end process p_valid;

    out_valid <= valid;
    out_total <= total;
  end generate g_accumulate;

end architecture rtl;
