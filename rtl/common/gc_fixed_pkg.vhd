-- SPDX-License-Identifier: MIT
--
-- The only place where bits are dropped.
--
-- Truncation is towards minus infinity; the half LSB that it costs on average is part of the bias downstream (see
-- gc_network_pkg), so rounding needs no adder.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_facts_pkg.all;

package gc_fixed_pkg is

  subtype operand_t is signed(operand_bits_c - 1 downto 0);

  -- Levels of adders in gc_adder_tree.

  function tree_depth (
    terms : positive
  ) return natural;

  -- Bits that are '1'.

  function ones (
    bits : std_ulogic_vector
  ) return natural;

  -- Clocks that lanes take for so many words; where they do not divide them the last clock is padded with zeros.

  function lane_steps (
    words : positive;
    lanes : positive
  ) return positive;

  -- Latency of gc_scale, clocks.

  function scale_latency (
    values : positive;
    serial : boolean
  ) return natural;

  -- Latency of gc_input_scaler, clocks: with one multiplier the codes wait a clock for it, else the products.

  function scaler_latency (
    values : positive;
    serial : boolean
  ) return natural;

  -- Latency of gc_turn_stage, clocks.

  function turn_latency (
    turns : positive;
    serial : boolean
  ) return natural;

  -- Latency of gc_hidden_lane, clocks.

  function hidden_latency (
    inputs : positive;
    lanes : positive;
    lean : boolean
  ) return natural;

  -- Latency of gc_activation, clocks.

  function activation_latency (
    lean : boolean
  ) return natural;

  -- Latency of gc_output_layer from the last of `steps` inputs, clocks.

  function output_latency (
    lanes : positive;
    steps : positive;
    lean : boolean
  ) return natural;

  -- Latency of gc_output_scaler, clocks.

  function output_scaler_latency (
    outputs : positive;
    serial : boolean;
    lean : boolean
  ) return natural;

  -- Clocks from a DSP block to an adder. With one lane the clock counts, with several and in the lean form the latency;
  -- with all neurons at once the blocks of the output layer are all over the chip.

  function hidden_term_clocks (
    lanes : positive;
    lean : boolean
  ) return natural;

  function output_term_clocks (
    lanes : positive;
    steps : positive;
    lean : boolean
  ) return natural;

  -- Drop the lowest bits. The caller guarantees that the result fits `bits`.

  function truncate (
    value : signed;
    drop : natural;
    bits : positive
  ) return signed;

  -- Whether value does not fit `bits`.

  function overflows (
    value : signed;
    bits : positive
  ) return std_ulogic;

  -- Clip to the range of a signed number of `bits`.

  function saturate (
    value : signed;
    bits : positive
  ) return signed;

end package gc_fixed_pkg;

package body gc_fixed_pkg is

  function tree_depth (
    terms : positive
  ) return natural is

    variable depth_v : natural := 0;

  begin

    while 2 ** depth_v < terms loop

      depth_v := depth_v + 1;

    end loop;

    return depth_v;

  end function tree_depth;

  function ones (
    bits : std_ulogic_vector
  ) return natural is

    variable ones_v : natural := 0;

  begin

    for i in bits'range loop

      if bits(i) = '1' then
        ones_v := ones_v + 1;
      end if;

    end loop;

    return ones_v;

  end function ones;

  function lane_steps (
    words : positive;
    lanes : positive
  ) return positive is
  begin

    return (words + lanes - 1) / lanes;

  end function lane_steps;

  function scaler_latency (
    values : positive;
    serial : boolean
  ) return natural is
  begin

    return 1 + scale_latency(values, serial);

  end function scaler_latency;

  function turn_latency (
    turns : positive;
    serial : boolean
  ) return natural is
  begin

    -- gc_phase, gc_sin_cos, the register that holds.
    if serial and turns > 1 then
      return turns + 6 + 7 + 1;
    end if;

    return 6 + 7 + 1;

  end function turn_latency;

  function scale_latency (
    values : positive;
    serial : boolean
  ) return natural is
  begin

    if serial and values > 1 then
      return values + 2;
    end if;

    return 2;

  end function scale_latency;

  function hidden_latency (
    inputs : positive;
    lanes : positive;
    lean : boolean
  ) return natural is
  begin

    return 2 + boolean'pos(not lean) + hidden_term_clocks(lanes, lean) + tree_depth(inputs + 1);

  end function hidden_latency;

  function activation_latency (
    lean : boolean
  ) return natural is
  begin

    return activation_clocks_c - boolean'pos(lean);

  end function activation_latency;

  function output_latency (
    lanes : positive;
    steps : positive;
    lean : boolean
  ) return natural is
  begin

    if steps = 1 then
      return 2 + output_term_clocks(lanes, steps, lean) + tree_depth(lanes + 1);
    end if;

    return 3 + output_term_clocks(lanes, steps, lean) + tree_depth(lanes);

  end function output_latency;

  function output_scaler_latency (
    outputs : positive;
    serial : boolean;
    lean : boolean
  ) return natural is
  begin

    if lean then
      return 1;
    end if;

    return 1 + scale_latency(outputs, serial);

  end function output_scaler_latency;

  function hidden_term_clocks (
    lanes : positive;
    lean : boolean
  ) return natural is
  begin

    return boolean'pos(lanes = 1 and not lean);

  end function hidden_term_clocks;

  function output_term_clocks (
    lanes : positive;
    steps : positive;
    lean : boolean
  ) return natural is
  begin

    if steps = 1 or (lanes = 1 and not lean) then
      return 1;
    end if;

    return 0;

  end function output_term_clocks;

  function truncate (
    value : signed;
    drop : natural;
    bits : positive
  ) return signed is
  begin

    return resize(shift_right(value, drop), bits);

  end function truncate;

  function overflows (
    value : signed;
    bits : positive
  ) return std_ulogic is

    alias    value_a   : signed(value'length - 1 downto 0) is value;
    variable differs_v : std_ulogic := '0';

  begin

    -- All bits from the new sign bit upwards must be equal.
    for i in bits to value_a'high loop

      differs_v := differs_v or (value_a(i) xor value_a(bits - 1));

    end loop;

    return differs_v;

  end function overflows;

  function saturate (
    value : signed;
    bits : positive
  ) return signed is

    alias    value_a : signed(value'length - 1 downto 0) is value;
    variable limit_v : signed(bits - 1 downto 0);

  begin

    if overflows(value, bits) = '0' then
      return resize(value, bits);
    end if;

    limit_v := (others => not value_a(value_a'high));
    limit_v(bits - 1) := value_a(value_a'high);
    return limit_v;

  end function saturate;

end package body gc_fixed_pkg;
