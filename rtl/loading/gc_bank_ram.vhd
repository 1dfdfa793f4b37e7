-- SPDX-License-Identifier: MIT
--
-- Two banks of words, one to write, one to read: a simple dual-port memory, inferred, with a registered output.
--
-- Its content is undefined until it is written. What is read must not be written in the same clock: synthesis need not
-- care (no_rw_check; for Yosys by name, as GHDL passes no attributes on). Latency: 1 clock, reading in every clock.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity gc_bank_ram is
  generic (
    -- Width of a word, bits.
    word_bits_g    : positive := 18;
    -- Width of an address within a bank, bits.
    address_bits_g : positive := 5
  );
  port (
    clk           : in    std_ulogic;
    in_write      : in    std_ulogic;
    in_write_bank : in    std_ulogic;
    in_write_addr : in    unsigned(address_bits_g - 1 downto 0);
    in_word       : in    std_ulogic_vector(word_bits_g - 1 downto 0);
    in_bank       : in    std_ulogic;
    in_addr       : in    unsigned(address_bits_g - 1 downto 0);
    out_word      : out   std_ulogic_vector(word_bits_g - 1 downto 0)
  );
end entity gc_bank_ram;

architecture rtl of gc_bank_ram is

  subtype word_t is std_ulogic_vector(word_bits_g - 1 downto 0);

  type words_t is array (0 to 2 ** (address_bits_g + 1) - 1) of word_t;

  signal ram : words_t;

  attribute ramstyle     : string;
  attribute syn_ramstyle : string;
  attribute ramstyle of ram     : signal is "no_rw_check";
  attribute syn_ramstyle of ram : signal is "no_rw_check";

begin

  p_ram : process (clk) is
  begin

    if rising_edge(clk) then
      if in_write = '1' then
        ram(to_integer(in_write_bank & in_write_addr)) <= in_word;
      end if;
      out_word <= ram(to_integer(in_bank & in_addr));
    end if;

  end process p_ram;

end architecture rtl;
