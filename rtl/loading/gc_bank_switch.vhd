-- SPDX-License-Identifier: MIT
--
-- Which constants are in use: those of the ROM, or of one of two banks. A swap waits until no inference is under way,
-- so that each computes with one set, and then replaces all constants in the same clock.
--
-- While a swap waits, out_hold asks that no inference begins; after it the core is reset for one clock, in which it
-- takes up the new constants. Meanwhile a new image or load_rom replaces the swap that waits, and load_begin drops it.
-- Latency: 3 clocks from load_rom to the end of out_hold if nothing is under way. Reset: the ROM.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_crc_pkg.all;
  use work.gc_image_pkg.all;
  use work.gc_scalars_pkg.all;

entity gc_bank_switch is
  port (
    clk         : in    std_ulogic;
    -- Synchronous, active high; back to the ROM.
    rst         : in    std_ulogic;
    -- An image can be used: its bank, scalars and CRC.
    in_accept   : in    std_ulogic;
    in_bank     : in    std_ulogic_vector(1 downto 0);
    in_scalars  : in    scalars_t;
    in_crc      : in    crc_t;
    load_rom    : in    std_ulogic;
    load_begin  : in    std_ulogic;
    -- An inference begins, its result is there; 63 at most at a time.
    in_start    : in    std_ulogic;
    in_done     : in    std_ulogic;
    -- No inference may begin.
    out_hold    : out   std_ulogic;
    -- Resets the core.
    out_restart : out   std_ulogic;
    -- Bank and scalars in use.
    out_bank    : out   std_ulogic_vector(1 downto 0);
    out_scalars : out   scalars_t;
    -- A swap waits.
    sts_waiting : out   std_ulogic;
    -- CRC-32 of the image in use, 0 with the ROM.
    sts_crc     : out   crc_t
  );
end entity gc_bank_switch;

architecture rtl of gc_bank_switch is

  signal under_way : unsigned(5 downto 0) := (others => '0');
  signal waiting   : std_ulogic := '0';
  signal next_bank : std_ulogic_vector(1 downto 0) := "00";
  signal swap      : std_ulogic;
  signal restart   : std_ulogic := '0';
  signal bank      : std_ulogic_vector(1 downto 0) := "00";
  signal scalars   : scalars_t := rom_scalars_c;
  signal crc       : crc_t := (others => '0');

begin

  p_under_way : process (clk) is
  begin

    if rising_edge(clk) then
      if in_start = '1' and in_done = '0' then
        under_way <= under_way + 1;
      elsif in_start = '0' and in_done = '1' then
        under_way <= under_way - 1;
      end if;
      if rst = '1' then
        under_way <= (others => '0');
      end if;
    end if;

  end process p_under_way;

  -- Not with load_begin, which opens the bank that is not in use in this clock.
  swap <= waiting and not load_begin when under_way = 0 else '0';

  p_wait : process (clk) is
  begin

    if rising_edge(clk) then
      if swap = '1' then
        waiting <= '0';
      end if;
      if in_accept = '1' then
        waiting <= '1';
        next_bank <= in_bank;
      end if;
      if load_rom = '1' then
        waiting <= '1';
        next_bank <= "00";
      end if;
      if load_begin = '1' or rst = '1' then
        waiting <= '0';
      end if;
    end if;

  end process p_wait;

  p_swap : process (clk) is
  begin

    if rising_edge(clk) then
      restart <= swap;
      if swap = '1' then
        bank <= next_bank;
        scalars <= in_scalars;
        crc <= in_crc;
      end if;
      -- Reset and return to the ROM: its constants, which the core takes up in the clock after.
      if rst = '1' or (swap = '1' and next_bank = "00") then
        restart <= '1';
        bank <= "00";
        scalars <= rom_scalars_c;
        crc <= (others => '0');
      end if;
    end if;

  end process p_swap;

  out_hold <= waiting or restart;
  out_restart <= restart;
  out_bank <= bank;
  out_scalars <= scalars;
  sts_waiting <= waiting;
  sts_crc <= crc;

end architecture rtl;
