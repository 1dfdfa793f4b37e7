-- SPDX-License-Identifier: MIT
--
-- Receives an image word by word (gc_image_pkg tells its layout): writes its tables into the bank that is not in use,
-- keeps its scalars, and accepts it if its length and its CRC-32 are right.
--
-- Formats: 32-bit words -> memory.write with one record each; one word per clock at most. Latency: a record is written
-- 1 clock after its last word; out_accept comes 1 clock after load_commit. Illegal input: words before load_begin and
-- after load_commit are dropped; a commit of an image that is too short, too long or damaged, or without load_begin,
-- sets sts_bad. A new load_begin starts over.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_crc_pkg.all;
  use work.gc_facts_pkg.all;
  use work.gc_image_pkg.all;
  use work.gc_scalars_pkg.all;

entity gc_loader is
  port (
    clk         : in    std_ulogic;
    -- Synchronous, active high; forgets the image.
    rst         : in    std_ulogic;
    load_begin  : in    std_ulogic;
    load_valid  : in    std_ulogic;
    load_word   : in    std_ulogic_vector(image_word_bits_c - 1 downto 0);
    -- The image is whole; not in the clock of its last word.
    load_commit : in    std_ulogic;
    load_crc    : in    crc_t;
    -- Bank in use, which passes through to memory.
    in_bank     : in    std_ulogic_vector(1 downto 0);
    memory      : out   memory_t;
    -- The image can be used; its bank, scalars and CRC hold until load_begin.
    out_accept  : out   std_ulogic;
    out_bank    : out   std_ulogic_vector(1 downto 0);
    out_scalars : out   scalars_t;
    out_crc     : out   crc_t;
    -- The last commit was refused, until load_begin.
    sts_bad     : out   std_ulogic
  );
end entity gc_loader;

architecture rtl of gc_loader is

  constant kept_bits_c : positive := record_words_c(scalar_section_c) * image_word_bits_c;

  -- The last words, newest highest: a record when its last word is in, and the scalars once the image is whole.
  signal kept       : std_ulogic_vector(kept_bits_c - 1 downto 0);
  -- Section under way; all are done: the highest bit.
  signal section    : std_ulogic_vector(sections_c downto 0) := (others => '0');
  signal index      : unsigned(index_bits_c - 1 downto 0) := (others => '0');
  signal word       : unsigned(index_bits_c - 1 downto 0) := (others => '0');
  signal takes      : std_ulogic;
  signal ends       : std_ulogic;
  signal ends_all   : std_ulogic;
  signal is_loading : std_ulogic := '0';
  signal is_right   : std_ulogic;
  signal crc        : crc_t := crc_start_c;
  signal write_bank : std_ulogic := '0';
  signal write      : std_ulogic_vector(sections_c - 1 downto 0) := (others => '0');
  signal written    : unsigned(index_bits_c - 1 downto 0) := (others => '0');
  signal accept     : std_ulogic := '0';
  signal bad        : std_ulogic := '0';

begin

  takes <= load_valid and is_loading;

  -- Whether this word ends a record, and a section. One word more than all ends the whole: no section is left then.
  p_ends : process (all) is
  begin

    ends <= section(sections_c);
    ends_all <= section(sections_c);

    for s in 0 to sections_c - 1 loop

      if section(s) = '1' and word = record_words_c(s) - 1 then
        ends <= '1';
        if index = section_records_c(s) - 1 then
          ends_all <= '1';
        end if;
      end if;

    end loop;

  end process p_ends;

  p_receive : process (clk) is
  begin

    if rising_edge(clk) then
      write <= (others => '0');
      if takes = '1' then
        kept <= load_word & kept(kept'high downto image_word_bits_c);
        crc <= crc_step(crc, load_word);
        word <= word + 1;
        if ends = '1' then
          word <= (others => '0');
          index <= index + 1;
          write <= section(sections_c - 1 downto 0);
          written <= index;
        end if;
        if ends_all = '1' then
          index <= (others => '0');
          section <= section(sections_c - 1 downto 0) & '0';
        end if;
      end if;
      if load_begin = '1' then
        crc <= crc_start_c;
        word <= (others => '0');
        index <= (others => '0');
        section <= (0 => '1', others => '0');
        write_bank <= in_bank(0);
      end if;
    end if;

  end process p_receive;

  is_right <= is_loading and section(sections_c) when load_crc = not crc else '0';

  p_commit : process (clk) is
  begin

    if rising_edge(clk) then
      accept <= load_commit and is_right;
      if load_commit = '1' then
        is_loading <= '0';
        bad <= not is_right;
      end if;
      if load_begin = '1' then
        is_loading <= '1';
        accept <= '0';
        bad <= '0';
      end if;
      if rst = '1' then
        is_loading <= '0';
        accept <= '0';
        bad <= '0';
      end if;
    end if;

  end process p_commit;

  memory.bank <= in_bank;
  memory.write <= write;
  memory.write_bank <= write_bank;
  memory.index <= written;
  memory.data <= kept(kept'high downto kept_bits_c - record_bits_c);

  out_accept <= accept;
  out_bank <= write_bank & not write_bank;
  out_scalars <= scalars_of(kept(scalar_bits_c - 1 downto 0));
  out_crc <= not crc;
  sts_bad <= bad;

end architecture rtl;
