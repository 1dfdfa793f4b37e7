-- SPDX-License-Identifier: MIT
--
-- CRC-32 of IEEE 802.3, as zlib computes it: of words as little-endian bytes, a word at a time.
--
-- Start: all ones. Result: the complement of the last value.
--
-- And CRC-16 of Modbus, a byte at a time. Start: all ones. Result: the last value, sent low byte first; zero after it.

library ieee;
  use ieee.std_logic_1164.all;

package gc_crc_pkg is

  subtype crc_t is std_ulogic_vector(31 downto 0);

  constant crc_start_c : crc_t := (others => '1');

  -- The value after one more word.

  function crc_step (
    crc  : crc_t;
    word : crc_t
  ) return crc_t;

  subtype byte_t is std_ulogic_vector(7 downto 0);

  subtype crc16_t is std_ulogic_vector(15 downto 0);

  constant crc16_start_c : crc16_t := (others => '1');

  -- The value after one more byte.

  function crc16_step (
    crc  : crc16_t;
    byte : byte_t
  ) return crc16_t;

end package gc_crc_pkg;

package body gc_crc_pkg is

  constant polynomial_c : crc_t := x"EDB88320";

  -- A word of which only this bit is set, shifted through the register, bit 0 first.

  function remainder (
    bit_set : natural
  ) return crc_t is

    variable crc_v : crc_t := (others => '0');

  begin

    crc_v(bit_set) := '1';

    for i in crc_t'reverse_range loop

      if crc_v(0) = '1' then
        crc_v := ('0' & crc_v(31 downto 1)) xor polynomial_c;
      else
        crc_v := '0' & crc_v(31 downto 1);
      end if;

    end loop;

    return crc_v;

  end function remainder;

  type remainders_t is array (0 to 31) of crc_t;

  function all_remainders return remainders_t is

    variable remainders_v : remainders_t;

  begin

    for i in remainders_v'range loop

      remainders_v(i) := remainder(i);

    end loop;

    return remainders_v;

  end function all_remainders;

  constant remainders_c : remainders_t := all_remainders;

  -- Linear: the sum of the remainders of all bits that are set, as a tree.

  function crc_step (
    crc  : crc_t;
    word : crc_t
  ) return crc_t is

    constant mixed_c : crc_t := crc xor word;

    variable sums_v : remainders_t;

  begin

    for i in sums_v'range loop

      sums_v(i) := remainders_c(i) and (crc_t'range => mixed_c(i));

    end loop;

    for level in 0 to 4 loop

      for i in sums_v'range loop

        if i mod 2 ** (level + 1) = 0 then
          sums_v(i) := sums_v(i) xor sums_v(i + 2 ** level);
        end if;

      end loop;

    end loop;

    return sums_v(0);

  end function crc_step;

  constant polynomial_16_c : crc16_t := x"A001";

  function crc16_step (
    crc  : crc16_t;
    byte : byte_t
  ) return crc16_t is

    variable crc_v : crc16_t := crc xor (x"00" & byte);

  begin

    for i in byte_t'range loop

      if crc_v(0) = '1' then
        crc_v := ('0' & crc_v(15 downto 1)) xor polynomial_16_c;
      else
        crc_v := '0' & crc_v(15 downto 1);
      end if;

    end loop;

    return crc_v;

  end function crc16_step;

end package body gc_crc_pkg;
