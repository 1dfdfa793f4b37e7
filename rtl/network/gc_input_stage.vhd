-- SPDX-License-Identifier: MIT
--
-- x: what the hidden layer sees of the encoder counts, axis by axis: the position, scaled and clamped to the trained
-- range, or sine and cosine of an axis that turns.
--
-- Formats: 32-bit counts -> 18 bits, x_fraction_c. Latency: that of gc_turn_stage, on which positions wait, where an
-- axis turns, else of gc_input_scaler; out_x holds until the next result. Overflow: cannot happen. Illegal input: as in
-- gc_input_scaler; an axis that turns has none.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_facts_pkg.all;
  use work.gc_fixed_pkg.all;
  use work.gc_image_pkg.all;
  use work.gc_network_pkg.all;
  use work.gc_scalars_pkg.all;

entity gc_input_stage is
  generic (
    -- One multiplier for all positions, in turn.
    serial_g : boolean := false;
    -- One way from count to sine and cosine for all axes that turn, in turn.
    shared_g : boolean := false
  );
  port (
    clk         : in    std_ulogic;
    -- Synchronous, active high; clears valid and state.
    rst         : in    std_ulogic;
    in_valid    : in    std_ulogic;
    -- Encoder counts, axis 1 lowest.
    in_count    : in    signed(inputs_c * count_bits_c - 1 downto 0);
    out_valid   : out   std_ulogic;
    -- Axis 1 lowest; cosine above sine.
    out_x       : out   signed(features_c * operand_bits_c - 1 downto 0);
    -- Count of this axis was outside the trained range.
    out_clamped : out   std_ulogic_vector(inputs_c - 1 downto 0);
    -- Constants in use.
    scalars     : in    scalars_t := rom_scalars_c
  );
end entity gc_input_stage;

architecture rtl of gc_input_stage is

  constant turns_c     : natural  := ones(turning_c);
  constant positions_c : natural  := inputs_c - turns_c;
  constant pair_bits_c : positive := 2 * operand_bits_c;

begin

  g_straight : if turns_c = 0 generate

    i_input_scaler : entity work.gc_input_scaler
      generic map (
        serial_g => serial_g
      )
      port map (
        clk         => clk,
        rst         => rst,
        in_valid    => in_valid,
        in_count    => in_count,
        out_valid   => out_valid,
        out_x       => out_x,
        out_clamped => out_clamped,
        scalars     => scalars
      );

  end generate g_straight;

  g_turns : if turns_c > 0 generate
    signal turn_x : signed(turns_c * pair_bits_c - 1 downto 0);
  begin

    i_turn_stage : entity work.gc_turn_stage
      generic map (
        shared_g => shared_g
      )
      port map (
        clk       => clk,
        rst       => rst,
        in_valid  => in_valid,
        in_count  => in_count,
        out_valid => out_valid,
        out_x     => turn_x
      );

    g_axis : for i in 0 to inputs_c - 1 generate

      g_turn : if turning_c(i) = '1' generate
        constant k_c     : natural := ones(turning_c(i downto 0)) - 1;
        constant first_c : natural := i + k_c;
      begin
        out_x((first_c + 2) * operand_bits_c - 1 downto first_c * operand_bits_c)
 <= turn_x((k_c + 1) * pair_bits_c - 1 downto k_c * pair_bits_c);
        out_clamped(i) <= '0';
      end generate g_turn;

    end generate g_axis;

  end generate g_turns;

  -- Positions wait for sines and cosines.

  g_mixed : if turns_c > 0 and positions_c > 0 generate
    constant wait_c : positive := turn_latency(turns_c, shared_g) - scaler_latency(positions_c, serial_g);

    signal position_x : signed(positions_c * operand_bits_c - 1 downto 0);
    signal clamped    : std_ulogic_vector(positions_c - 1 downto 0);
    signal waited     : std_ulogic_vector(positions_c * (operand_bits_c + 1) - 1 downto 0);
  begin

    i_input_scaler : entity work.gc_input_scaler
      generic map (
        serial_g => serial_g
      )
      port map (
        clk         => clk,
        rst         => rst,
        in_valid    => in_valid,
        in_count    => in_count,
        out_valid   => open,
        out_x       => position_x,
        out_clamped => clamped,
        scalars     => scalars
      );

    i_wait : entity work.gc_delay
      generic map (
        bits_g   => waited'length,
        clocks_g => wait_c
      )
      port map (
        clk      => clk,
        in_data  => clamped & std_ulogic_vector(position_x),
        out_data => waited
      );

    g_axis : for i in 0 to inputs_c - 1 generate

      g_position : if turning_c(i) = '0' generate
        constant k_c     : natural := i - ones(turning_c(i downto 0));
        constant first_c : natural := i + ones(turning_c(i downto 0));
      begin
        out_x((first_c + 1) * operand_bits_c - 1 downto first_c * operand_bits_c)
 <= signed(waited((k_c + 1) * operand_bits_c - 1 downto k_c * operand_bits_c));
        out_clamped(i) <= waited(positions_c * operand_bits_c + k_c);
      end generate g_position;

    end generate g_axis;

  end generate g_mixed;

end architecture rtl;
