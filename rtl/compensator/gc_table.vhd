-- SPDX-License-Identifier: MIT
--
-- out_value = value + step * fraction: a table of nodes with linear interpolation, rounded; of several axes, one table
-- beside the other in one memory, of which in_turn tells the one to read.
--
-- A word of the table holds the value of its node, low, and the step to the next node, high, 18 bits each.
-- Formats: fraction 17 bits unsigned -> 18 bits, that of the nodes. Latency: 5 clocks. Overflow: cannot happen, a value
-- between two nodes lies between theirs.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_facts_pkg.all;
  use work.gc_fixed_pkg.all;
  use work.gc_image_pkg.all;

entity gc_table is
  generic (
    -- Width of an address, bits.
    address_bits_g : positive := 8;
    -- Axes that have a table here, and the first of them.
    axes_g         : positive := 1;
    axis_g         : natural := 0;
    -- Their tables, 2**address_bits_g words each, word 0 of the first axis lowest.
    table_g        : std_ulogic_vector;
    -- Whether the words can be replaced, through the port memory, and their section.
    loadable_g     : boolean := false;
    section_g      : natural := 0
  );
  port (
    clk         : in    std_ulogic;
    -- Synchronous, active high; clears the valid bits.
    rst         : in    std_ulogic;
    in_valid    : in    std_ulogic;
    -- Whose table, 0 that of the first axis.
    in_turn     : in    unsigned(index_bits(axes_g) - 1 downto 0);
    in_address  : in    unsigned(address_bits_g - 1 downto 0);
    -- Place between the node and the next one.
    in_fraction : in    unsigned(operand_bits_c - 2 downto 0);
    out_valid   : out   std_ulogic;
    out_value   : out   operand_t;
    -- Loaded words; read where loadable_g.
    memory      : in    memory_t := rom_memory_c
  );
end entity gc_table;

architecture rtl of gc_table is

  constant words_c         : positive := axes_g * 2 ** address_bits_g;
  -- A place among all words; of one axis alone, in_turn says nothing.
  constant place_bits_c    : positive := tree_depth(axes_g) + address_bits_g;
  constant word_bits_c     : positive := 2 * operand_bits_c;
  constant fraction_bits_c : positive := operand_bits_c - 1;

  subtype word_t is std_ulogic_vector(word_bits_c - 1 downto 0);

  type words_t is array (0 to words_c - 1) of word_t;

  function table_words return words_t is

    alias    table_a : std_ulogic_vector(table_g'length - 1 downto 0) is table_g;
    variable words_v : words_t;

  begin

    for k in 0 to words_c - 1 loop

      words_v(k) := table_a((k + 1) * word_bits_c - 1 downto k * word_bits_c);

    end loop;

    return words_v;

  end function table_words;

  constant rom_c   : words_t := table_words;
  constant zeros_c : std_ulogic_vector(table_g'range) := (others => '0');

  signal place      : unsigned(place_bits_c - 1 downto 0);
  signal valid_1    : std_ulogic := '0';
  signal rom_1      : word_t := (others => '0');
  signal word_1     : word_t;
  signal fraction_1 : unsigned(fraction_bits_c - 1 downto 0) := (others => '0');
  signal valid_2    : std_ulogic := '0';
  signal word_2     : word_t;
  signal fraction_2 : unsigned(fraction_bits_c - 1 downto 0);
  signal value_3    : operand_t;
  signal value_4    : operand_t;
  signal valid_4    : std_ulogic;
  signal product_4  : signed(word_bits_c - 1 downto 0);
  signal valid_5    : std_ulogic := '0';
  signal value_5    : operand_t;

begin

  assert table_g'length = words_c * word_bits_c
    report "gc_table: need " & integer'image(words_c * word_bits_c) & " table bits, got "
           & integer'image(table_g'length)
    severity failure;

  place <= resize(in_turn & in_address, place_bits_c);

  -- stage 1: read
  p_rom : process (clk) is
  begin

    if rising_edge(clk) then
      valid_1 <= in_valid;
      if in_valid = '1' then
        -- A table of zeros is not built.
        if table_g /= zeros_c then
          rom_1 <= rom_c(to_integer(place));
        end if;
        fraction_1 <= in_fraction;
      end if;
      if rst = '1' then
        valid_1 <= '0';
      end if;
    end if;

  end process p_rom;

  g_word : if loadable_g generate
    constant first_c : natural := axis_g * 2 ** address_bits_g;
    signal   index   : unsigned(index_bits_c - 1 downto 0);
    signal   write   : std_ulogic;
    signal   bank_1  : word_t;
  begin

    -- Of the records of all axes those from first_c on.
    index <= memory.index - first_c;
    write <= memory.write(section_g) when index < words_c else '0';

    i_ram : entity work.gc_bank_ram
      generic map (
        word_bits_g    => word_bits_c,
        address_bits_g => place_bits_c
      )
      port map (
        clk           => clk,
        in_write      => write,
        in_write_bank => memory.write_bank,
        in_write_addr => index(place_bits_c - 1 downto 0),
        in_word       => field(memory.data, word_bits_c),
        in_bank       => memory.bank(1),
        in_addr       => place,
        out_word      => bank_1
      );

    word_1 <= rom_1 when memory.bank = "00" else bank_1;
  else generate
    word_1 <= rom_1;
  end generate g_word;

  -- stage 2: the way out of the memory takes a clock of its own
  p_word : process (clk) is
  begin

    if rising_edge(clk) then
      valid_2 <= valid_1;
      word_2 <= word_1;
      fraction_2 <= fraction_1;
      if rst = '1' then
        valid_2 <= '0';
      end if;
    end if;

  end process p_word;

  -- stages 3 and 4: multiply
  i_multiply : entity work.gc_multiply
    generic map (
      a_bits_g => operand_bits_c,
      b_bits_g => operand_bits_c
    )
    port map (
      clk         => clk,
      rst         => rst,
      in_valid    => valid_2,
      in_a        => signed(word_2(word_2'high downto operand_bits_c)),
      in_b        => signed('0' & fraction_2),
      out_valid   => valid_4,
      out_product => product_4
    );

  -- stage 5: add the node and half an LSB, which is the next bit below it
  p_sum : process (clk) is

    variable node_v : signed(word_bits_c - 1 downto 0);

  begin

    if rising_edge(clk) then
      value_3 <= signed(word_2(operand_bits_c - 1 downto 0));
      value_4 <= value_3;
      node_v := shift_left(resize(value_4, word_bits_c), fraction_bits_c);
      node_v(fraction_bits_c - 1) := '1';
      value_5 <= truncate(node_v + product_4, fraction_bits_c, operand_bits_c);
      valid_5 <= valid_4;
      if rst = '1' then
        valid_5 <= '0';
      end if;
    end if;

  end process p_sum;

  out_valid <= valid_5;
  out_value <= value_5;

end architecture rtl;
