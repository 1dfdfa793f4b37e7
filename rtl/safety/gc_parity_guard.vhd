-- SPDX-License-Identifier: MIT
--
-- Finds a wrong bit in registers that live elsewhere: keeps the parity of what they ought to hold.
--
--   parity := XOR of in_next                in a clock with in_load, the one in which in_next is written to them
--   out_upset = XOR of in_word /= parity    one clock later, as long as they differ
--
-- Any odd number of wrong bits is found, so any single one; the parity itself is one of the bits. Two wrong bits of one
-- word are not: give each word of up to 32 bits a guard of its own.
-- For a register whose next value is not at hand, in_next is its present value, and in_load tells when it may have
-- changed: what goes wrong in those clocks is not found.
-- Latency: 1 clock. Reset: what is loaded meanwhile is what the registers hold after it.

library ieee;
  use ieee.std_logic_1164.all;

library work;
  use work.gc_safety_pkg.all;

entity gc_parity_guard is
  generic (
    width_g : positive := 32
  );
  port (
    clk        : in    std_ulogic;
    -- Synchronous, active high.
    rst        : in    std_ulogic;
    in_load    : in    std_ulogic;
    in_next    : in    std_ulogic_vector(width_g - 1 downto 0);
    -- What the registers hold.
    in_word    : in    std_ulogic_vector(width_g - 1 downto 0);
    -- Parity that belongs to in_word of this clock where in_next is in_word: to go along with it.
    out_parity : out   std_ulogic;
    out_upset  : out   std_ulogic := '0'
  );
end entity gc_parity_guard;

architecture rtl of gc_parity_guard is

  signal parity : std_ulogic := '0';

begin

  out_parity <= parity_of(in_next) when in_load = '1' else parity;

  p_guard : process (clk) is
  begin

    if rising_edge(clk) then
      parity <= out_parity;
      out_upset <= parity xor parity_of(in_word);
      if rst = '1' then
        out_upset <= '0';
      end if;
    end if;

  end process p_guard;

end architecture rtl;
