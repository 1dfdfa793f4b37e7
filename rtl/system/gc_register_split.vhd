-- SPDX-License-Identifier: MIT
--
-- AXI4-Lite of one host to two blocks of registers, a low and a high one: whom each access is for, and who answers.
--
-- Only the handshakes pass through here; addresses, data and responses are wired past it. One write and one read may be
-- under way; the next is not taken before the response of the one before has gone.
-- Latency: 0 clocks, but that a write's data wait until the clock after its address.

library ieee;
  use ieee.std_logic_1164.all;

entity gc_register_split is
  port (
    clk         : in    std_ulogic;
    -- Synchronous, active high.
    rst         : in    std_ulogic;
    -- The host: addresses are of the high block.
    in_aw_high  : in    std_ulogic;
    in_awvalid  : in    std_ulogic;
    in_awready  : out   std_ulogic;
    in_wvalid   : in    std_ulogic;
    in_wready   : out   std_ulogic;
    in_bvalid   : out   std_ulogic;
    in_bready   : in    std_ulogic;
    in_ar_high  : in    std_ulogic;
    in_arvalid  : in    std_ulogic;
    in_arready  : out   std_ulogic;
    in_rvalid   : out   std_ulogic;
    in_rready   : in    std_ulogic;
    -- Whose responses these are.
    write_high  : out   std_ulogic;
    read_high   : out   std_ulogic;
    -- The blocks: low is bit 0.
    out_awvalid : out   std_ulogic_vector(1 downto 0);
    out_awready : in    std_ulogic_vector(1 downto 0);
    out_wvalid  : out   std_ulogic_vector(1 downto 0);
    out_wready  : in    std_ulogic_vector(1 downto 0);
    out_bvalid  : in    std_ulogic_vector(1 downto 0);
    out_bready  : out   std_ulogic_vector(1 downto 0);
    out_arvalid : out   std_ulogic_vector(1 downto 0);
    out_arready : in    std_ulogic_vector(1 downto 0);
    out_rvalid  : in    std_ulogic_vector(1 downto 0);
    out_rready  : out   std_ulogic_vector(1 downto 0)
  );
end entity gc_register_split;

architecture rtl of gc_register_split is

  signal awready  : std_ulogic;
  signal wready   : std_ulogic;
  signal bvalid   : std_ulogic;
  signal arready  : std_ulogic;
  signal rvalid   : std_ulogic;
  -- A write is under way, its data have not come yet, it is one of the high block; so of a read.
  signal writing  : std_ulogic := '0';
  signal data_due : std_ulogic := '0';
  signal to_high  : std_ulogic := '0';
  signal reading  : std_ulogic := '0';
  signal of_high  : std_ulogic := '0';

  function chosen (
    pair : std_ulogic_vector(1 downto 0);
    high : std_ulogic
  ) return std_ulogic is
  begin

    -- An address that nobody drives yet is none of the high block.
    if high = '1' then
      return pair(1);
    end if;

    return pair(0);

  end function chosen;

  function pair_of (
    value : std_ulogic;
    high  : std_ulogic
  ) return std_ulogic_vector is
  begin

    if high = '1' then
      return value & '0';
    end if;

    return '0' & value;

  end function pair_of;

begin

  out_awvalid <= pair_of(in_awvalid and not writing, in_aw_high);
  awready <= chosen(out_awready, in_aw_high) and not writing;
  out_wvalid <= pair_of(in_wvalid and data_due, to_high);
  wready <= chosen(out_wready, to_high) and data_due;
  bvalid <= chosen(out_bvalid, to_high) and writing;
  out_bready <= pair_of(in_bready and writing, to_high);

  out_arvalid <= pair_of(in_arvalid and not reading, in_ar_high);
  arready <= chosen(out_arready, in_ar_high) and not reading;
  rvalid <= chosen(out_rvalid, of_high) and reading;
  out_rready <= pair_of(in_rready and reading, of_high);

  p_writing : process (clk) is
  begin

    if rising_edge(clk) then
      if in_awvalid = '1' and awready = '1' then
        writing <= '1';
        data_due <= '1';
        to_high <= in_aw_high;
      end if;
      if in_wvalid = '1' and wready = '1' then
        data_due <= '0';
      end if;
      if bvalid = '1' and in_bready = '1' then
        writing <= '0';
      end if;
      if rst = '1' then
        writing <= '0';
        data_due <= '0';
      end if;
    end if;

  end process p_writing;

  p_reading : process (clk) is
  begin

    if rising_edge(clk) then
      if in_arvalid = '1' and arready = '1' then
        reading <= '1';
        of_high <= in_ar_high;
      end if;
      if rvalid = '1' and in_rready = '1' then
        reading <= '0';
      end if;
      if rst = '1' then
        reading <= '0';
      end if;
    end if;

  end process p_reading;

  in_awready <= awready;
  in_wready <= wready;
  in_bvalid <= bvalid;
  in_arready <= arready;
  in_rvalid <= rvalid;
  write_high <= to_high;
  read_high <= of_high;

end architecture rtl;
