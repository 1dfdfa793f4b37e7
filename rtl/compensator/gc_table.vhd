-- SPDX-License-Identifier: MIT
--
-- out_value = value + step * fraction: a table of nodes with linear interpolation, rounded.
--
-- A word of the table holds the value of its node, low, and the step to the next node, high, 18 bits each.
-- Formats: fraction 17 bits unsigned -> 18 bits, that of the nodes. Latency: 4 clocks. Overflow: cannot happen, a value
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
    -- The table, 2**address_bits_g words, word 0 lowest.
    table_g        : std_ulogic_vector;
    -- Whether the words can be replaced, through the port memory; axis and section of theirs.
    loadable_g     : boolean := false;
    axis_g         : natural := 0;
    section_g      : natural := 0
  );
  port (
    clk         : in    std_ulogic;
    -- Synchronous, active high; clears the valid bits.
    rst         : in    std_ulogic;
    in_valid    : in    std_ulogic;
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

  constant words_c         : positive := 2 ** address_bits_g;
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

  signal valid_1    : std_ulogic := '0';
  signal rom_1      : word_t := (others => '0');
  signal word_1     : word_t;
  signal fraction_1 : unsigned(fraction_bits_c - 1 downto 0) := (others => '0');
  signal value_2    : operand_t;
  signal value_3    : operand_t;
  signal valid_3    : std_ulogic;
  signal product_3  : signed(word_bits_c - 1 downto 0);
  signal valid_4    : std_ulogic := '0';
  signal value_4    : operand_t;

begin

  assert table_g'length = words_c * word_bits_c
    report "gc_table: need " & integer'image(words_c * word_bits_c) & " table bits, got "
           & integer'image(table_g'length)
    severity failure;

  -- stage 1: read
  p_rom : process (clk) is
  begin

    if rising_edge(clk) then
      valid_1 <= in_valid;
      if in_valid = '1' then
        -- A table of zeros is not built.
        if table_g /= zeros_c then
          rom_1 <= rom_c(to_integer(in_address));
        end if;
        fraction_1 <= in_fraction;
      end if;
      if rst = '1' then
        valid_1 <= '0';
      end if;
    end if;

  end process p_rom;

  g_word : if loadable_g generate
    signal write  : std_ulogic;
    signal bank_1 : word_t;
  begin

    write <= memory.write(section_g) when memory.index(index_bits_c - 1 downto address_bits_g) = axis_g else '0';

    i_ram : entity work.gc_bank_ram
      generic map (
        word_bits_g    => word_bits_c,
        address_bits_g => address_bits_g
      )
      port map (
        clk           => clk,
        in_write      => write,
        in_write_bank => memory.write_bank,
        in_write_addr => memory.index(address_bits_g - 1 downto 0),
        in_word       => field(memory.data, word_bits_c),
        in_bank       => memory.bank(1),
        in_addr       => in_address,
        out_word      => bank_1
      );

    word_1 <= rom_1 when memory.bank = "00" else bank_1;
  else generate
    word_1 <= rom_1;
  end generate g_word;

  -- stages 2 and 3: multiply
  i_multiply : entity work.gc_multiply
    generic map (
      a_bits_g => operand_bits_c,
      b_bits_g => operand_bits_c
    )
    port map (
      clk         => clk,
      rst         => rst,
      in_valid    => valid_1,
      in_a        => signed(word_1(word_1'high downto operand_bits_c)),
      in_b        => signed('0' & fraction_1),
      out_valid   => valid_3,
      out_product => product_3
    );

  -- stage 4: add the node and half an LSB, which is the next bit below it
  p_sum : process (clk) is

    variable node_v : signed(word_bits_c - 1 downto 0);

  begin

    if rising_edge(clk) then
      value_2 <= signed(word_1(operand_bits_c - 1 downto 0));
      value_3 <= value_2;
      node_v := shift_left(resize(value_3, word_bits_c), fraction_bits_c);
      node_v(fraction_bits_c - 1) := '1';
      value_4 <= truncate(node_v + product_3, fraction_bits_c, operand_bits_c);
      valid_4 <= valid_3;
      if rst = '1' then
        valid_4 <= '0';
      end if;
    end if;

  end process p_sum;

  out_valid <= valid_4;
  out_value <= value_4;

end architecture rtl;
