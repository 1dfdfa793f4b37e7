-- SPDX-License-Identifier: MIT
--
-- Generated from weights/spheiro by `make rom`; do not edit.
--
-- Tables of gc_compensator. A word is the value of a node, low, and the step to the next node, high, 18 bits each.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

package gc_compensation_pkg is

  -- SHA-256 of compensation.csv, or of nothing where there is no such file.
  constant compensation_hash_c : std_ulogic_vector(255 downto 0) :=
    x"e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";

  -- Width of an axis' friction, mN.
  constant friction_bits_c : positive := 25;

  -- Which axes have a table that is not zero throughout, axis 1 lowest.
  constant friction_used_c : std_ulogic_vector(2 downto 0) := "000";
  constant mu_used_c       : std_ulogic_vector(2 downto 0) := "000";
  constant position_used_c : std_ulogic_vector(2 downto 0) := "000";

  -- Turns of the position table per count, 2**-32.
  constant phase_step_bits_c : positive := 25;

  type phase_steps_t is array (0 to 2) of natural;

  constant phase_step_c : phase_steps_t := (0 => 0, 1 => 0, 2 => 0);

  subtype table_word_t is std_ulogic_vector(35 downto 0);

  -- Friction, mN, and mu, 2**-17, over the code of gc_speed_code: 512 words per axis, axis 1 first.
  type speed_words_t is array (0 to 1535) of table_word_t;

  constant friction_words_c : speed_words_t := (
    others => (others => '0')
  );

  constant mu_words_c : speed_words_t := (
    others => (others => '0')
  );

  -- Force, mN, over one pitch: 256 words per axis, axis 1 first.
  type position_words_t is array (0 to 767) of table_word_t;

  constant position_words_c : position_words_t := (
    others => (others => '0')
  );

  -- The words of so many axes as one vector, word 0 of the first of them lowest.
  function speed_table (words : speed_words_t; first : natural; axes : positive) return std_ulogic_vector;

  function position_table (first : natural; axes : positive) return std_ulogic_vector;

  -- Phase steps as one vector, axis 1 lowest.
  function flat (steps : phase_steps_t) return signed;

end package gc_compensation_pkg;

package body gc_compensation_pkg is

  function speed_table (words : speed_words_t; first : natural; axes : positive) return std_ulogic_vector is
    variable flat_v : std_ulogic_vector(axes * 512 * table_word_t'length - 1 downto 0);
  begin
    for i in 0 to axes * 512 - 1 loop
      flat_v((i + 1) * table_word_t'length - 1 downto i * table_word_t'length) := words(first * 512 + i);
    end loop;
    return flat_v;
  end function speed_table;

  function position_table (first : natural; axes : positive) return std_ulogic_vector is
    variable flat_v : std_ulogic_vector(axes * 256 * table_word_t'length - 1 downto 0);
  begin
    for i in 0 to axes * 256 - 1 loop
      flat_v((i + 1) * table_word_t'length - 1 downto i * table_word_t'length)
        := position_words_c(first * 256 + i);
    end loop;
    return flat_v;
  end function position_table;

  function flat (steps : phase_steps_t) return signed is
    variable flat_v : signed((steps'high + 1) * phase_step_bits_c - 1 downto 0);
  begin
    for i in steps'range loop
      flat_v((i + 1) * phase_step_bits_c - 1 downto i * phase_step_bits_c) := to_signed(steps(i), phase_step_bits_c);
    end loop;
    return flat_v;
  end function flat;

end package body gc_compensation_pkg;
