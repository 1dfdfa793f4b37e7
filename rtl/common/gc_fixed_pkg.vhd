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

  -- Bits of an address of so many places, at least one.

  function index_bits (
    places : positive
  ) return positive;

  -- Bits that are '1'.

  function ones (
    bits : std_ulogic_vector
  ) return natural;

  -- Clocks that lanes take for so many words; where they do not divide them the last clock is padded with zeros.

  function lane_steps (
    words : positive;
    lanes : positive
  ) return positive;

  -- How many axes share a unit, in turn, where so many clocks lie between results: as many as fit and divide them all.

  function turns_of (
    axes : positive;
    interval : positive
  ) return positive;

  -- Of gc_wide_multiply: width of a part of an operand that does not fit one, and how many there are of an operand.

  constant part_bits_c : positive := operand_bits_c - 1;

  function product_parts (
    bits : positive
  ) return positive;

  -- One of them, the lowest 0, as an operand; the highest has the sign.

  function product_part (
    value : signed;
    part : natural
  ) return signed;

  -- Products of two parts that reach so many bits, and the place of one of them.

  function product_terms (
    a_bits : positive;
    b_bits : positive;
    product_bits : positive
  ) return positive;

  function product_place (
    a_part : natural;
    b_part : natural;
    b_bits : positive;
    product_bits : positive
  ) return natural;

  -- Latency of gc_wide_multiply, clocks.

  function product_latency (
    a_bits : positive;
    b_bits : positive;
    product_bits : positive
  ) return positive;

  -- Latency of gc_scale, clocks.

  function scale_latency (
    values : positive;
    serial : boolean;
    value_bits : positive := operand_bits_c
  ) return natural;

  -- Latencies of gc_compensator and gc_current_scaler, clocks, with so many axes in turn.

  function compensator_latency (
    turns : positive
  ) return positive;

  function current_scaler_latency (
    turns : positive
  ) return positive;

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

  function index_bits (
    places : positive
  ) return positive is
  begin

    if places = 1 then
      return 1;
    end if;

    return tree_depth(places);

  end function index_bits;

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

  function turns_of (
    axes : positive;
    interval : positive
  ) return positive is

    variable turns_v : positive := 1;

  begin

    for k in 1 to axes loop

      if k <= interval and axes mod k = 0 then
        turns_v := k;
      end if;

    end loop;

    return turns_v;

  end function turns_of;

  function product_parts (
    bits : positive
  ) return positive is
  begin

    return 1 + (bits - 2) / part_bits_c;

  end function product_parts;

  function product_part (
    value : signed;
    part : natural
  ) return signed is

    alias    value_a : signed(value'length - 1 downto 0) is value;
    constant low_c   : natural := part * part_bits_c;

  begin

    if part = product_parts(value'length) - 1 then
      return resize(value_a(value_a'high downto low_c), operand_bits_c);
    end if;

    return '0' & value_a(low_c + part_bits_c - 1 downto low_c);

  end function product_part;

  function product_place (
    a_part : natural;
    b_part : natural;
    b_bits : positive;
    product_bits : positive
  ) return natural is

    variable place_v : natural := b_part;

  begin

    for i in 0 to a_part - 1 loop

      for k in 0 to product_parts(b_bits) - 1 loop

        if (i + k) * part_bits_c < product_bits then
          place_v := place_v + 1;
        end if;

      end loop;

    end loop;

    return place_v;

  end function product_place;

  function product_terms (
    a_bits : positive;
    b_bits : positive;
    product_bits : positive
  ) return positive is
  begin

    return product_place(product_parts(a_bits), 0, b_bits, product_bits);

  end function product_terms;

  function product_latency (
    a_bits : positive;
    b_bits : positive;
    product_bits : positive
  ) return positive is
  begin

    return 2 + tree_depth(product_terms(a_bits, b_bits, product_bits));

  end function product_latency;

  function scale_latency (
    values : positive;
    serial : boolean;
    value_bits : positive := operand_bits_c
  ) return natural is

    constant product_c : positive := product_latency(value_bits, operand_bits_c, value_bits + operand_bits_c);

  begin

    if serial and values > 1 then
      return values + product_c;
    end if;

    return product_c;

  end function scale_latency;

  function compensator_latency (
    turns : positive
  ) return positive is
  begin

    return compensator_clocks_c + turns - 1;

  end function compensator_latency;

  function current_scaler_latency (
    turns : positive
  ) return positive is
  begin

    if turns > 1 then
      return current_scaler_clocks_c + turns;
    end if;

    return current_scaler_clocks_c;

  end function current_scaler_latency;

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
