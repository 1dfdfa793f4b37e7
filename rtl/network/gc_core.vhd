-- SPDX-License-Identifier: MIT
--
-- f = S_o (W_o^T Gamma(W_H^T S_i count + b_H) + b_o): encoder counts in, holding forces out.
--
-- lanes_g neurons per clock; 166 multiplications and 43 sums per inference at hidden size 20 and three axes; with n
-- neurons, p features and m axes p + p n + 2 n + n m + m and 2 n + m, those of gc_turn_stage apart.
-- Formats: 32-bit counts -> 24 bits, mN. Initiation interval: s = n / lanes_g clocks, rounded up (in_ready); latency
-- from accepted counts to forces: 14 + ceil(log2(p + 1)) + ceil(log2(lanes_g)) + s clocks; with one lane 2 m + 2 more,
-- 2 with one axis, as its scalers share a multiplier each; with all neurons at once
-- 18 + ceil(log2(p + 1)) + ceil(log2(lanes_g + 1)), as the bias is a term of the last sum. Where an axis turns, the
-- input takes turn_latency in place of scaler_latency (gc_fixed_pkg).
-- In the lean form (lean_c, of the ROM) p n + n + n m multiplications and n + m sums, 140 and 23 for 3-20-3: no
-- scalers, Gamma as a square. Latency: 8 + ceil(log2(p + 1)) + ceil(log2(lanes_g)) + s clocks, with all neurons at once
-- 12 + ceil(log2(p + 1)) + ceil(log2(lanes_g + 1)). It takes positions alone.
-- Overflow: no intermediate can, for any count. Illegal input: counts outside the trained range are clamped and
-- flagged; an output that does not fit saturates and is flagged.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_facts_pkg.all;
  use work.gc_fixed_pkg.all;
  use work.gc_image_pkg.all;
  use work.gc_network_pkg.all;
  use work.gc_scalars_pkg.all;

entity gc_core is
  generic (
    -- Neurons per clock; where it does not divide the hidden size, neurons of zero weight are added.
    lanes_g    : positive := 4;
    -- Whether the constants can be replaced, through the ports memory and scalars.
    loadable_g : boolean := false
  );
  port (
    clk           : in    std_ulogic;
    -- Synchronous, active high; forgets what is under way. Needed after a change of memory.bank or scalars.
    rst           : in    std_ulogic;
    -- Counts are taken in a clock with in_valid and in_ready.
    in_valid      : in    std_ulogic;
    in_ready      : out   std_ulogic;
    -- Encoder counts, axis 1 lowest.
    in_count      : in    signed(inputs_c * count_bits_c - 1 downto 0);
    -- One clock per result.
    out_valid     : out   std_ulogic;
    -- Holding forces, mN, axis 1 lowest.
    out_force     : out   signed(outputs_c * force_bits_c - 1 downto 0);
    -- Count of this axis was outside the trained range.
    out_clamped   : out   std_ulogic_vector(inputs_c - 1 downto 0);
    -- Output of this axis saturated.
    out_saturated : out   std_ulogic_vector(outputs_c - 1 downto 0);
    -- Loaded weights and constants; read where loadable_g.
    memory        : in    memory_t := rom_memory_c;
    scalars       : in    scalars_t := rom_scalars_c
  );
end entity gc_core;

architecture rtl of gc_core is

  -- Told while the constants are made: the lanes cannot even be built with weights of fewer bits.

  function checked_lanes return positive is
  begin

    assert not serial_form_c
      report "gc_core: need a ROM of the form paper or lean, got serial; take gc_core_serial"
      severity failure;
    return lanes_g;

  end function checked_lanes;

  constant steps_c   : positive := lane_steps(hidden_c, checked_lanes);
  -- With 20 clocks per inference one multiplier per scaler is enough.
  constant serial_c  : boolean := not lean_c and lanes_g = 1 and steps_c >= inputs_c and steps_c >= outputs_c;
  -- With all neurons at once the lanes are all over the chip: x travels two clocks longer, to a copy per region and on
  -- to one per lane; h one clock.
  constant spread_c  : boolean  := steps_c = 1;
  constant regions_c : positive := 4;
  -- From x to force: copies, lane, activation, output layer, output scaler.
  constant delay_c   : positive := 3 * boolean'pos(spread_c) + hidden_latency(features_c, lanes_g, lean_c)
                                   + activation_latency(lean_c)
                                   + (steps_c - 1 + output_latency(lanes_g, steps_c, lean_c))
                                   + output_scaler_latency(outputs_c, serial_c, lean_c);

  -- Clocks since the last accepted counts, and the step of the lanes; both rest at 0.
  signal since        : std_ulogic_vector(steps_c - 1 downto 0);
  signal since_runs   : std_ulogic;
  signal step         : std_ulogic_vector(steps_c - 1 downto 0);
  signal accept       : std_ulogic;
  signal x_valid      : std_ulogic;
  signal x            : signed(features_c * operand_bits_c - 1 downto 0);
  signal x_clamped    : std_ulogic_vector(inputs_c - 1 downto 0);
  signal lane_valid   : std_ulogic;
  -- The copies of x, one per region.
  signal region_valid : std_ulogic_vector(regions_c - 1 downto 0);
  signal region_x     : signed(regions_c * features_c * operand_bits_c - 1 downto 0);
  signal h_valid      : std_ulogic_vector(lanes_g - 1 downto 0);
  signal h            : signed(lanes_g * operand_bits_c - 1 downto 0);
  signal total_valid  : std_ulogic;
  signal total        : signed(outputs_c * output_sum_bits_c - 1 downto 0);
  signal used         : scalars_t;

begin

  assert steps_c * lanes_g = hidden_c
    report "gc_core: " & integer'image(hidden_c) & " neurons and " & integer'image(steps_c * lanes_g - hidden_c)
           & " of zero weight, so that " & integer'image(lanes_g) & " lanes divide them"
    severity note;

  -- The one place where ROM or loaded scalars are chosen; as a top of its own it needs no loaded ones.
  used <= in_use(loadable_g, scalars);

  -- One inference per steps_c clocks at the input, steps_c clocks of the lanes for each x.
  in_ready <= since(0);
  accept <= in_valid and since(0);
  since_runs <= in_valid or not since(0);

  i_since : entity work.gc_ring
    generic map (
      length_g => steps_c
    )
    port map (
      clk      => clk,
      rst      => rst,
      in_valid => since_runs,
      out_turn => since
    );

  lane_valid <= x_valid or not step(0);

  i_step : entity work.gc_ring
    generic map (
      length_g => steps_c
    )
    port map (
      clk      => clk,
      rst      => rst,
      in_valid => lane_valid,
      out_turn => step
    );

  i_input_stage : entity work.gc_input_stage
    generic map (
      serial_g => serial_c,
      shared_g => steps_c >= ones(turning_c)
    )
    port map (
      clk         => clk,
      rst         => rst,
      in_valid    => accept,
      in_count    => in_count,
      out_valid   => x_valid,
      out_x       => x,
      out_clamped => x_clamped,
      scalars     => used
    );

  g_regions : if spread_c generate

    g_region : for region in 0 to regions_c - 1 generate

      i_x : entity work.gc_copy
        generic map (
          bits_g => x'length
        )
        port map (
          clk       => clk,
          rst       => rst,
          in_valid  => lane_valid,
          in_data   => x,
          out_valid => region_valid(region),
          out_data  => region_x((region + 1) * x'length - 1 downto region * x'length)
        );

    end generate g_region;

  end generate g_regions;

  g_lane : for lane in 0 to lanes_g - 1 generate
    signal near_valid  : std_ulogic;
    signal near_x      : signed(features_c * operand_bits_c - 1 downto 0);
    signal a_valid     : std_ulogic;
    signal a           : operand_t;
    signal gamma_valid : std_ulogic;
    signal gamma       : operand_t;
  begin

    g_near : if not spread_c generate
      near_valid <= lane_valid;
      near_x <= x;
      h_valid(lane) <= gamma_valid;
      h((lane + 1) * operand_bits_c - 1 downto lane * operand_bits_c) <= gamma;
    end generate g_near;

    g_spread : if spread_c generate
      constant region_c : natural := lane * regions_c / lanes_g;
    begin

      i_x : entity work.gc_copy
        generic map (
          bits_g => x'length
        )
        port map (
          clk       => clk,
          rst       => rst,
          in_valid  => region_valid(region_c),
          in_data   => region_x((region_c + 1) * x'length - 1 downto region_c * x'length),
          out_valid => near_valid,
          out_data  => near_x
        );

      i_h : entity work.gc_copy
        generic map (
          bits_g => operand_bits_c
        )
        port map (
          clk       => clk,
          rst       => rst,
          in_valid  => gamma_valid,
          in_data   => gamma,
          out_valid => h_valid(lane),
          out_data  => h((lane + 1) * operand_bits_c - 1 downto lane * operand_bits_c)
        );

    end generate g_spread;

    i_hidden_lane : entity work.gc_hidden_lane
      generic map (
        lanes_g    => lanes_g,
        lane_g     => lane,
        loadable_g => loadable_g
      )
      port map (
        clk       => clk,
        rst       => rst,
        in_valid  => near_valid,
        in_x      => near_x,
        out_valid => a_valid,
        out_a     => a,
        memory    => memory
      );

    i_activation : entity work.gc_activation
      port map (
        clk       => clk,
        rst       => rst,
        in_valid  => a_valid,
        in_a      => a,
        out_valid => gamma_valid,
        out_h     => gamma
      );

  end generate g_lane;

  i_output_layer : entity work.gc_output_layer
    generic map (
      lanes_g    => lanes_g,
      loadable_g => loadable_g
    )
    port map (
      clk       => clk,
      rst       => rst,
      in_valid  => h_valid(0),
      in_h      => h,
      out_valid => total_valid,
      out_total => total,
      memory    => memory,
      scalars   => used
    );

  i_output_scaler : entity work.gc_output_scaler
    generic map (
      serial_g => serial_c
    )
    port map (
      clk           => clk,
      rst           => rst,
      in_valid      => total_valid,
      in_total      => total,
      out_valid     => out_valid,
      out_force     => out_force,
      out_saturated => out_saturated,
      scalars       => used
    );

  -- The flags of the input travel beside the data.
  i_clamped : entity work.gc_delay
    generic map (
      bits_g   => inputs_c,
      clocks_g => delay_c
    )
    port map (
      clk      => clk,
      in_data  => x_clamped,
      out_data => out_clamped
    );

end architecture rtl;
