-- SPDX-License-Identifier: MIT
--
-- gc_weight_rom whose words can be replaced: out_word is that of the ROM or of one of two banks, as memory.bank says.
--
-- The bank that is not in use is written record by record, each lane taking its own. ROM and memory are one word
-- ahead, so that a slow memory has a clock of its own. Latency: as gc_weight_rom, but word 0 is there 2 clocks after
-- rst, which must also follow a change of memory.bank.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_fixed_pkg.all;
  use work.gc_image_pkg.all;

entity gc_weight_bank is
  generic (
    -- Width of a word, bits.
    word_bits_g : positive := 18;
    -- Words of the table, over all lanes.
    words_g     : positive := 20;
    -- Lanes, and which of them this is.
    lanes_g     : positive := 1;
    lane_g      : natural := 0;
    -- Section of the image.
    section_g   : natural := 0;
    -- The table in ROM, word 0 lowest.
    table_g     : std_ulogic_vector
  );
  port (
    clk      : in    std_ulogic;
    -- Synchronous, active high; back to word 0.
    rst      : in    std_ulogic;
    in_valid : in    std_ulogic;
    out_word : out   std_ulogic_vector(word_bits_g - 1 downto 0);
    -- Bank in use, and the words to write.
    memory   : in    memory_t
  );
end entity gc_weight_bank;

architecture rtl of gc_weight_bank is

  constant steps_c : positive := lane_steps(words_g, lanes_g);
  -- Whether the last word of this lane pads the table: no record is written there, the ROM has its zeros.
  constant pads_c  : boolean  := (steps_c - 1) * lanes_g + lane_g >= words_g;

  constant address_bits_c : positive := index_bits(steps_c);

  subtype address_t is unsigned(address_bits_c - 1 downto 0);

  -- Word 0 has to be brought forward.
  signal first        : std_ulogic := '1';
  signal advance      : std_ulogic;
  signal rom_word     : std_ulogic_vector(word_bits_g - 1 downto 0);
  signal bank_word    : std_ulogic_vector(word_bits_g - 1 downto 0);
  signal word         : std_ulogic_vector(word_bits_g - 1 downto 0);
  signal is_mine      : std_ulogic;
  signal write        : std_ulogic;
  signal write_addr   : address_t;
  signal address      : address_t := (others => '0');
  signal next_address : address_t;

begin

  advance <= in_valid or first;

  i_rom : entity work.gc_weight_rom
    generic map (
      word_bits_g => word_bits_g,
      words_g     => words_g,
      lanes_g     => lanes_g,
      lane_g      => lane_g,
      table_g     => table_g
    )
    port map (
      clk      => clk,
      rst      => rst,
      in_valid => advance,
      out_word => rom_word
    );

  -- Record lane_g + k * lanes_g of the section is word k of this lane.
  p_write : process (all) is
  begin

    is_mine <= '0';
    write_addr <= (others => '0');

    for k in 0 to steps_c - 1 loop

      if memory.index = lane_g + k * lanes_g then
        is_mine <= '1';
        write_addr <= to_unsigned(k, address_bits_c);
      end if;

    end loop;

  end process p_write;

  write <= memory.write(section_g) and is_mine;

  p_next : process (all) is
  begin

    next_address <= address;

    if advance = '1' then
      next_address <= address + 1;
      if address = steps_c - 1 then
        next_address <= (others => '0');
      end if;
    end if;

    if rst = '1' then
      next_address <= (others => '0');
    end if;

  end process p_next;

  p_address : process (clk) is
  begin

    if rising_edge(clk) then
      address <= next_address;
    end if;

  end process p_address;

  i_ram : entity work.gc_bank_ram
    generic map (
      word_bits_g    => word_bits_g,
      address_bits_g => address_bits_c
    )
    port map (
      clk           => clk,
      in_write      => write,
      in_write_bank => memory.write_bank,
      in_write_addr => write_addr,
      in_word       => field(memory.data, word_bits_g),
      in_bank       => memory.bank(1),
      in_addr       => next_address,
      out_word      => bank_word
    );

  p_word : process (clk) is
  begin

    if rising_edge(clk) then
      if advance = '1' then
        word <= bank_word;
        if memory.bank = "00" or (pads_c and address = steps_c - 1) then
          word <= rom_word;
        end if;
      end if;
      first <= rst;
    end if;

  end process p_word;

  out_word <= word;

end architecture rtl;
