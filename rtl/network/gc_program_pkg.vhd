-- SPDX-License-Identifier: MIT
--
-- What gc_core_serial does in each clock of an inference, as a table made of the weights: one word per clock.
--
-- A product begins in every clock, its slot. Of each neuron come p products of an input and a weight, three at least,
-- then the square of the neuron before, whose u is there by then; after the last neuron, n products of h per output. Six
-- neurons at least: those added weigh nothing. The last h then stands in the memory before it is read.
-- Fields stand in the word that is out in the clock of their stage, so that nothing is delayed beside the data: those of
-- the sum and of what takes it sum_clocks_c and take_clocks_c words after the slot, the neuron whose h it reads one word
-- before.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_fixed_pkg.all;
  use work.gc_network_pkg.all;

package gc_program_pkg is

  -- Sums of both layers and of the square.
  constant sum_bits_c : positive := output_sum_bits_c;

  -- Neurons, and products of each before its sum is taken.

  function at_least (
    least : positive;
    number : positive
  ) return positive;

  constant neurons_c : positive := at_least(6, hidden_c);
  constant taps_c    : positive := at_least(3, features_c);

  -- Operands of the multiplier, in order: the inputs, h, u.
  constant source_h_c    : positive := features_c;
  constant source_u_c    : positive := features_c + 1;
  constant source_bits_c : positive := tree_depth(features_c + 2);

  constant neuron_bits_c : positive := tree_depth(neurons_c);

  -- Words after the slot.
  constant sum_clocks_c  : positive := 3;
  constant take_clocks_c : positive := 4;

  constant outputs_slot_c : positive := (neurons_c + 1) * (taps_c + 1);
  -- Clocks of an inference, and one beyond them.
  constant words_c        : positive := outputs_slot_c + outputs_c * neurons_c + take_clocks_c;
  constant address_bits_c : positive := tree_depth(words_c + 1);

  type slot_t is record
    -- The slot's own: whether it is a product of the network, its operand, and its weight unless that is t.
    multiplies : std_ulogic;
    source     : unsigned(source_bits_c - 1 downto 0);
    weight     : signed(weight_bits_c - 1 downto 0);
    -- The next slot's: the neuron whose h is read.
    reads      : unsigned(neuron_bits_c - 1 downto 0);
    -- Of the slot sum_clocks_c before: whether a sum starts, with this bias, or is that of a square.
    starts     : std_ulogic;
    squares    : std_ulogic;
    bias       : signed(sum_bits_c - 1 downto 0);
    -- Of the slot take_clocks_c before: what its sum is, the neuron whose h that is; and whether it is the last.
    takes_a    : std_ulogic;
    takes_h    : std_ulogic;
    takes_y    : std_ulogic;
    writes     : unsigned(neuron_bits_c - 1 downto 0);
    ends       : std_ulogic;
  end record slot_t;

  constant flags_c     : positive := 7;
  constant word_bits_c : positive := weight_bits_c + sum_bits_c + source_bits_c + 2 * neuron_bits_c + flags_c;

  subtype word_t is std_ulogic_vector(word_bits_c - 1 downto 0);

  -- A power of two: a step never points outside.

  type program_t is array (0 to 2 ** address_bits_c - 1) of word_t;

  function program return program_t;

  function to_slot (
    word : word_t
  ) return slot_t;

end package gc_program_pkg;

package body gc_program_pkg is

  constant idle_c : slot_t :=
  (
    source => (others => '0'),
    weight => (others => '0'),
    reads  => (others => '0'),
    bias   => (others => '0'),
    writes => (others => '0'),
    others => '0'
  );

  type slots_t is array (0 to 2 ** address_bits_c - 1) of slot_t;

  function at_least (
    least : positive;
    number : positive
  ) return positive is
  begin

    if number < least then
      return least;
    end if;

    return number;

  end function at_least;

  -- Weight number `place` of a word of weights.

  function weight (
    word : std_ulogic_vector;
    place : natural
  ) return signed is
  begin

    return signed(word((place + 1) * weight_bits_c - 1 downto place * weight_bits_c));

  end function weight;

  -- Hidden layer: the products of a neuron, and the square of the one before.

  function with_hidden (
    slots : slots_t
  ) return slots_t is

    variable slots_v : slots_t := slots;
    variable first_v : natural;
    variable bias_v  : signed(sum_bits_c - 1 downto 0);

  begin

    for neuron in 0 to neurons_c loop

      first_v := neuron * (taps_c + 1);
      bias_v := (others => '0');

      if neuron < hidden_c then
        bias_v := resize(signed(hidden_words_c(neuron)(hidden_word_bits_c - 1 downto features_c * weight_bits_c)),
                         sum_bits_c);

        for i in 0 to features_c - 1 loop

          slots_v(first_v + i).multiplies := '1';
          slots_v(first_v + i).source := to_unsigned(i, source_bits_c);
          slots_v(first_v + i).weight := weight(hidden_words_c(neuron), i);

        end loop;

      end if;

      if neuron < neurons_c then
        slots_v(first_v + sum_clocks_c).starts := '1';
        slots_v(first_v + sum_clocks_c).bias := bias_v;
        slots_v(first_v + taps_c - 1 + take_clocks_c).takes_a := '1';
      end if;

      if neuron > 0 then
        if neuron <= hidden_c then
          slots_v(first_v + taps_c).multiplies := '1';
        end if;

        slots_v(first_v + taps_c).source := to_unsigned(source_u_c, source_bits_c);
        slots_v(first_v + taps_c + sum_clocks_c).squares := '1';
        slots_v(first_v + taps_c + take_clocks_c).takes_h := '1';
        slots_v(first_v + taps_c + take_clocks_c).writes := to_unsigned(neuron - 1, neuron_bits_c);
      end if;

    end loop;

    return slots_v;

  end function with_hidden;

  -- Output layer: the products of an output.

  function with_outputs (
    slots : slots_t
  ) return slots_t is

    variable slots_v : slots_t := slots;
    variable first_v : positive;

  begin

    for i in 0 to outputs_c - 1 loop

      first_v := outputs_slot_c + i * neurons_c;

      for neuron in 0 to neurons_c - 1 loop

        slots_v(first_v + neuron - 1).reads := to_unsigned(neuron, neuron_bits_c);
        slots_v(first_v + neuron).source := to_unsigned(source_h_c, source_bits_c);

        if neuron < hidden_c then
          slots_v(first_v + neuron).multiplies := '1';
          slots_v(first_v + neuron).weight := weight(output_words_c(neuron), i);
        end if;

      end loop;

      slots_v(first_v + sum_clocks_c).starts := '1';
      slots_v(first_v + sum_clocks_c).bias := output_bias_c((i + 1) * sum_bits_c - 1 downto i * sum_bits_c);
      slots_v(first_v + neurons_c - 1 + take_clocks_c).takes_y := '1';

    end loop;

    slots_v(words_c - 1).ends := '1';
    return slots_v;

  end function with_outputs;

  -- Where the fields are in a word; the flags one after the other.
  constant bias_c   : positive := weight_bits_c;
  constant source_c : positive := bias_c + sum_bits_c;
  constant reads_c  : positive := source_c + source_bits_c;
  constant writes_c : positive := reads_c + neuron_bits_c;
  constant flag_c   : positive := writes_c + neuron_bits_c;

  function to_word (
    slot : slot_t
  ) return word_t is

    variable word_v : word_t;

  begin

    word_v(bias_c - 1 downto 0) := std_ulogic_vector(slot.weight);
    word_v(source_c - 1 downto bias_c) := std_ulogic_vector(slot.bias);
    word_v(reads_c - 1 downto source_c) := std_ulogic_vector(slot.source);
    word_v(writes_c - 1 downto reads_c) := std_ulogic_vector(slot.reads);
    word_v(flag_c - 1 downto writes_c) := std_ulogic_vector(slot.writes);
    word_v(flag_c) := slot.multiplies;
    word_v(flag_c + 1) := slot.starts;
    word_v(flag_c + 2) := slot.squares;
    word_v(flag_c + 3) := slot.takes_a;
    word_v(flag_c + 4) := slot.takes_h;
    word_v(flag_c + 5) := slot.takes_y;
    word_v(flag_c + 6) := slot.ends;
    return word_v;

  end function to_word;

  function to_slot (
    word : word_t
  ) return slot_t is

    variable slot_v : slot_t;

  begin

    slot_v.weight := signed(word(bias_c - 1 downto 0));
    slot_v.bias := signed(word(source_c - 1 downto bias_c));
    slot_v.source := unsigned(word(reads_c - 1 downto source_c));
    slot_v.reads := unsigned(word(writes_c - 1 downto reads_c));
    slot_v.writes := unsigned(word(flag_c - 1 downto writes_c));
    slot_v.multiplies := word(flag_c);
    slot_v.starts := word(flag_c + 1);
    slot_v.squares := word(flag_c + 2);
    slot_v.takes_a := word(flag_c + 3);
    slot_v.takes_h := word(flag_c + 4);
    slot_v.takes_y := word(flag_c + 5);
    slot_v.ends := word(flag_c + 6);
    return slot_v;

  end function to_slot;

  function program return program_t is

    variable slots_v   : slots_t := (others => idle_c);
    variable program_v : program_t;

  begin

    slots_v := with_outputs(with_hidden(slots_v));

    for k in program_t'range loop

      program_v(k) := to_word(slots_v(k));

    end loop;

    return program_v;

  end function program;

end package body gc_program_pkg;
