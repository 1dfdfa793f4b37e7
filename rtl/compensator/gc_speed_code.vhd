-- SPDX-License-Identifier: MIT
--
-- The signed period of gc_speed_meter as a place in a table over speed: a floating-point code, no division.
--
--   |period| = 2**exponent (1 + (eighth + fraction) / 8);  address = direction, exponent, eighth
--
-- Speed falls with the address, eight nodes per octave; down has the upper half of the table. A period of 0, which the
-- speed meter never gives, counts as 1; standstill and unknown speed (2**31 - 1) are in the octave of exponent 30.
-- Formats: 32 bits -> 9 bits and 17 bits, truncated. Latency: 3 clocks. Overflow: cannot happen.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_facts_pkg.all;
  use work.gc_fixed_pkg.all;

entity gc_speed_code is
  port (
    clk          : in    std_ulogic;
    -- Synchronous, active high; clears the valid bits.
    rst          : in    std_ulogic;
    in_valid     : in    std_ulogic;
    -- Clocks per 4 counts, negative when counting down.
    in_period    : in    signed(31 downto 0);
    out_valid    : out   std_ulogic;
    out_address  : out   unsigned(8 downto 0);
    out_fraction : out   unsigned(operand_bits_c - 2 downto 0)
  );
end entity gc_speed_code;

architecture rtl of gc_speed_code is

  signal valid_1     : std_ulogic := '0';
  signal valid_2     : std_ulogic := '0';
  signal valid_3     : std_ulogic := '0';
  signal down_1      : std_ulogic := '0';
  signal down_2      : std_ulogic := '0';
  signal magnitude_1 : unsigned(31 downto 0) := (others => '0');
  signal magnitude_2 : unsigned(31 downto 0) := (others => '0');
  signal exponent_2  : unsigned(4 downto 0) := (others => '0');
  signal address_3   : unsigned(8 downto 0);
  signal fraction_3  : unsigned(operand_bits_c - 2 downto 0);

begin

  p_code : process (clk) is

    variable exponent_v : natural range 0 to 31;
    variable mantissa_v : unsigned(31 downto 0);

  begin

    if rising_edge(clk) then
      -- stage 1: sign and magnitude
      valid_1 <= in_valid;
      if in_valid = '1' then
        down_1 <= in_period(31);
        magnitude_1 <= unsigned(in_period);
        if in_period(31) = '1' then
          magnitude_1 <= unsigned(-in_period);
        end if;
      end if;

      -- stage 2: the leading one
      valid_2 <= valid_1;
      exponent_v := 0;

      for i in 1 to 31 loop

        if magnitude_1(i) = '1' then
          exponent_v := i;
        end if;

      end loop;

      exponent_2 <= to_unsigned(exponent_v, 5);
      magnitude_2 <= magnitude_1;
      down_2 <= down_1;

      -- stage 3: what follows it
      valid_3 <= valid_2;
      mantissa_v := shift_left(magnitude_2, to_integer(not exponent_2));
      address_3 <= down_2 & exponent_2 & mantissa_v(30 downto 28);
      fraction_3 <= mantissa_v(27 downto 29 - operand_bits_c);

      if rst = '1' then
        valid_1 <= '0';
        valid_2 <= '0';
        valid_3 <= '0';
      end if;
    end if;

  end process p_code;

  out_valid <= valid_3;
  out_address <= address_3;
  out_fraction <= fraction_3;

end architecture rtl;
