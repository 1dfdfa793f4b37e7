-- SPDX-License-Identifier: MIT
--
-- The constants of a core that can be replaced at run time: the layout of their image, and how they reach their users.
--
-- An image is a sequence of records, each a whole number of 32-bit words, the low one first, fields from bit 0 upwards:
-- hidden layer and output layer with a record per neuron, the tables of friction, mu and position with one per node,
-- axis 1 first, and last the scalars, one record. Tables live in memories beside their users, in two banks; the scalars
-- in one register.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_compensation_pkg.all;
  use work.gc_facts_pkg.all;
  use work.gc_fixed_pkg.all;
  use work.gc_network_pkg.all;
  use work.gc_scalars_pkg.all;

package gc_image_pkg is

  -- Records of each section, and words of a record; those of the hidden layer are the longest of a table.

  type section_numbers_t is array (0 to sections_c - 1) of positive;

  constant section_records_c : section_numbers_t :=
  (
    hidden_section_c   => hidden_c,
    output_section_c   => hidden_c,
    friction_section_c => outputs_c * 2 ** speed_address_bits_c,
    mu_section_c       => outputs_c * 2 ** speed_address_bits_c,
    position_section_c => outputs_c * 2 ** position_address_bits_c,
    scalar_section_c   => 1
  );

  constant record_words_c : section_numbers_t :=
  (
    hidden_section_c   => (hidden_word_bits_c + image_word_bits_c - 1) / image_word_bits_c,
    output_section_c   => (output_word_bits_c + image_word_bits_c - 1) / image_word_bits_c,
    friction_section_c => (table_word_t'length + image_word_bits_c - 1) / image_word_bits_c,
    mu_section_c       => (table_word_t'length + image_word_bits_c - 1) / image_word_bits_c,
    position_section_c => (table_word_t'length + image_word_bits_c - 1) / image_word_bits_c,
    scalar_section_c   => (scalar_bits_c + image_word_bits_c - 1) / image_word_bits_c
  );

  constant record_bits_c : positive := record_words_c(hidden_section_c) * image_word_bits_c;
  constant index_bits_c  : positive := 16;

  -- Which constants are in use, "00" the ROM, "01" and "10" the banks; and the record that is written.

  type memory_t is record
    bank       : std_ulogic_vector(1 downto 0);
    -- One clock per record, the bit of its section.
    write      : std_ulogic_vector(sections_c - 1 downto 0);
    -- '0' the bank "01", '1' the bank "10".
    write_bank : std_ulogic;
    -- Record within the section.
    index      : unsigned(index_bits_c - 1 downto 0);
    -- The last words of the image, newest highest.
    data       : std_ulogic_vector(record_bits_c - 1 downto 0);
  end record memory_t;

  constant rom_memory_c : memory_t :=
  (
    bank       => "00",
    write      => (others => '0'),
    write_bank => '0',
    index      => (others => '0'),
    data       => (others => '0')
  );

  -- The scalars in use: those of a port, or of the ROM.

  function in_use (
    loadable : boolean;
    scalars  : scalars_t
  ) return scalars_t;

  -- The lowest bits of a record whose last word is the highest of data.

  function field (
    data : std_ulogic_vector(record_bits_c - 1 downto 0);
    bits : positive
  ) return std_ulogic_vector;

end package gc_image_pkg;

package body gc_image_pkg is

  function in_use (
    loadable : boolean;
    scalars  : scalars_t
  ) return scalars_t is
  begin

    if loadable then
      return scalars;
    end if;

    return rom_scalars_c;

  end function in_use;

  function field (
    data : std_ulogic_vector(record_bits_c - 1 downto 0);
    bits : positive
  ) return std_ulogic_vector is

    constant words_c : positive := (bits + image_word_bits_c - 1) / image_word_bits_c;
    constant low_c   : natural  := record_bits_c - words_c * image_word_bits_c;

  begin

    return data(low_c + bits - 1 downto low_c);

  end function field;

end package body gc_image_pkg;
