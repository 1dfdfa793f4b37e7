-- SPDX-License-Identifier: MIT
--
-- Modbus RTU slave as AXI4-Lite master, from the characters of gc_uart: registers for a host without a bus.
--
-- The 32-bit register at byte offset A is the Modbus registers A/2, its high half, and A/2 + 1. Functions 03 and 04
-- read up to 124 of them, 16 writes, 23 writes and then reads, whole words only. Behind the bus, from 16#1000# on, are
-- registers of the port itself, to be read: frames answered, frames dropped, words written, exceptions sent.
-- A frame ends with gap_clocks_g clocks of silence. It is dropped and counted if its CRC-16 is wrong, or a character,
-- or its length is below 4 or above 256; nothing of it is used before. Frames of other units and for all get no answer.
-- Exceptions: 01 another function; 03 a quantity or a length that the function cannot have; 02 half a word, or beyond
-- the registers; 04 a response other than OKAY, with which a run ends: words before stand, and are counted; or none
-- within bus_clocks_g: the bus is asked nothing more of that kind, read or write, until it has responded.
-- What comes while a frame is carried out and answered is not heard.
-- Latency from the end of the gap to the answer: 5 clocks, 7 more per word written and 6 per word read, and those of
-- the bus.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_crc_pkg.all;

entity gc_modbus is
  generic (
    -- Address of this slave on the line.
    unit_g       : positive range 1 to 247 := 1;
    -- Clocks of 3.5 characters, or of the silence that ends a frame.
    gap_clocks_g : positive := 13_900;
    -- Clocks that the bus has for a response.
    bus_clocks_g : positive := 40_000
  );
  port (
    clk           : in    std_ulogic;
    -- Synchronous, active high.
    rst           : in    std_ulogic;
    -- From gc_uart.
    rx_valid      : in    std_ulogic;
    rx_data       : in    byte_t;
    rx_error      : in    std_ulogic;
    rx_receiving  : in    std_ulogic;
    -- To gc_uart: taken in a clock with tx_ready, which is low until all of it is sent.
    tx_valid      : out   std_ulogic;
    tx_ready      : in    std_ulogic;
    tx_data       : out   byte_t;
    -- An answer is on its way: switches the driver of a line that is shared.
    tx_enable     : out   std_ulogic;
    m_axi_awaddr  : out   std_ulogic_vector(11 downto 0);
    m_axi_awprot  : out   std_ulogic_vector(2 downto 0);
    m_axi_awvalid : out   std_ulogic;
    m_axi_awready : in    std_ulogic;
    m_axi_wdata   : out   std_ulogic_vector(31 downto 0);
    m_axi_wstrb   : out   std_ulogic_vector(3 downto 0);
    m_axi_wvalid  : out   std_ulogic;
    m_axi_wready  : in    std_ulogic;
    m_axi_bresp   : in    std_ulogic_vector(1 downto 0);
    m_axi_bvalid  : in    std_ulogic;
    m_axi_bready  : out   std_ulogic;
    m_axi_araddr  : out   std_ulogic_vector(11 downto 0);
    m_axi_arprot  : out   std_ulogic_vector(2 downto 0);
    m_axi_arvalid : out   std_ulogic;
    m_axi_arready : in    std_ulogic;
    m_axi_rdata   : in    std_ulogic_vector(31 downto 0);
    m_axi_rresp   : in    std_ulogic_vector(1 downto 0);
    m_axi_rvalid  : in    std_ulogic;
    m_axi_rready  : out   std_ulogic
  );
end entity gc_modbus;

architecture rtl of gc_modbus is

  subtype half_t is unsigned(15 downto 0);

  subtype word_t is std_ulogic_vector(31 downto 0);

  type bytes_t is array (natural range <>) of byte_t;

  type halves_t is array (natural range <>) of half_t;

  type words_t is array (natural range <>) of unsigned(31 downto 0);

  constant read_holding_c    : byte_t := x"03";
  constant read_input_c      : byte_t := x"04";
  constant write_registers_c : byte_t := x"10";
  constant write_and_read_c  : byte_t := x"17";

  -- Modbus registers of the bus and the port; of one frame, read, written, and written by function 23.
  constant registers_c    : positive := 2056;
  constant most_read_c    : positive := 124;
  constant most_written_c : positive := 123;
  constant most_of_both_c : positive := 121;

  constant longest_c     : positive := 256;
  constant shortest_c    : positive := 4;
  -- Bytes before the data of function 16 and 23; the latter is all that is decoded.
  constant write_head_c  : positive := 7;
  constant head_c        : positive := 11;
  -- And before the data of an answer to a read.
  constant answer_head_c : positive := 3;

  subtype code_t is std_ulogic_vector(2 downto 0);

  constant no_exception_c     : code_t := "000";
  constant illegal_function_c : code_t := "001";
  constant illegal_address_c  : code_t := "010";
  constant illegal_value_c    : code_t := "011";
  constant device_failure_c   : code_t := "100";

  constant answered_c   : natural := 0;
  constant dropped_c    : natural := 1;
  constant written_c    : natural := 2;
  constant exceptions_c : natural := 3;

  -- What is wrong with a run of registers.

  function run_code (
    start    : half_t;
    number : half_t;
    most     : positive
  ) return code_t is

    variable code_v : code_t := no_exception_c;

  begin

    if number = 0 or number > most then
      code_v := illegal_value_c;
    elsif start(0) = '1' or number(0) = '1' or start > registers_c or start + number > registers_c then
      code_v := illegal_address_c;
    end if;

    return code_v;

  end function run_code;

  -- What is wrong with two runs: a value before an address.

  function worse_code (
    a : code_t;
    b : code_t
  ) return code_t is

    variable code_v : code_t := a;

  begin

    if a = no_exception_c or b = illegal_value_c then
      code_v := b;
    end if;

    return code_v;

  end function worse_code;

  -- What is wrong with a frame of so many bytes: its halves begin at byte 2 and, of what function 23 writes, at 6.
  -- One value on every way: what GHDL writes as Verilog would be a latch otherwise.

  function frame_code (
    head   : bytes_t;
    halves : halves_t;
    length : natural
  ) return code_t is

    variable code_v   : code_t := illegal_function_c;
    variable length_v : natural range 0 to head_c + 2 + 255;

  begin

    length_v := length;

    if head(1) = read_holding_c or head(1) = read_input_c then
      code_v := run_code(halves(0), halves(1), most_read_c);
      length_v := 8;
    elsif head(1) = write_registers_c then
      code_v := run_code(halves(0), halves(1), most_written_c);
      length_v := write_head_c + 2 + to_integer(unsigned(head(6)));
    elsif head(1) = write_and_read_c then
      code_v := worse_code(run_code(halves(0), halves(1), most_read_c), run_code(halves(2), halves(3), most_of_both_c));
      length_v := head_c + 2 + to_integer(unsigned(head(10)));
    end if;

    if length /= length_v or (head(1) = write_registers_c and halves(1) * 2 /= unsigned(head(6)))
       or (head(1) = write_and_read_c and halves(3) * 2 /= unsigned(head(10))) then
      code_v := illegal_value_c;
    end if;

    return code_v;

  end function frame_code;

  type state_t is (
    idle, receive, check, decide, fetch, ask_write, write, start_read, ask_read, read, store, answer, load, send,
    send_crc, drain
  );

  signal state : state_t := idle;

  -- The frame
  signal length  : natural range 0 to longest_c := 0;
  signal bad     : std_ulogic := '0';
  signal silence : natural range 0 to gap_clocks_g - 1 := 0;
  signal crc     : crc16_t := crc16_start_c;
  signal head    : bytes_t(0 to head_c - 1) := (others => (others => '0'));
  signal halves  : halves_t(0 to 3);
  signal code    : code_t := no_exception_c;
  signal counts  : words_t(0 to 3) := (others => (others => '0'));

  -- The run: address of its next word, words left, bytes of that word that have moved.
  signal address : unsigned(10 downto 0) := (others => '0');
  signal left    : natural range 0 to most_read_c / 2 := 0;
  signal moved   : natural range 0 to 4 := 0;
  signal word    : word_t := (others => '0');

  -- What the bus is asked; writing, reading: it has still to respond; clocks that it was waited for.
  signal waddr   : unsigned(9 downto 0) := (others => '0');
  signal wdata   : word_t := (others => '0');
  signal raddr   : unsigned(9 downto 0) := (others => '0');
  signal awvalid : std_ulogic := '0';
  signal wvalid  : std_ulogic := '0';
  signal arvalid : std_ulogic := '0';
  signal writing : std_ulogic := '0';
  signal reading : std_ulogic := '0';
  signal waited  : natural range 0 to bus_clocks_g := 0;

  -- The frame; over it, what was read for the answer. fetched is the byte at place a clock before.
  signal memory  : bytes_t(0 to longest_c - 1);
  signal place   : unsigned(7 downto 0) := (others => '0');
  signal fetched : byte_t;
  signal keep    : std_ulogic := '0';
  signal kept    : byte_t := (others => '0');
  signal kept_at : unsigned(7 downto 0) := (others => '0');

  -- Place of the last byte of the answer, and the byte at place.
  signal last         : unsigned(7 downto 0) := (others => '0');
  signal answer_bytes : unsigned(7 downto 0);
  signal answer_byte  : byte_t;

begin

  g_halves : for k in halves'range generate
    halves(k) <= unsigned(head(2 + 2 * k)) & unsigned(head(3 + 2 * k));
  end generate g_halves;

  p_memory : process (clk) is
  begin

    if rising_edge(clk) then
      fetched <= memory(to_integer(place));
      if keep = '1' then
        memory(to_integer(kept_at)) <= kept;
      end if;
    end if;

  end process p_memory;

  p_modbus : process (clk) is
  begin

    if rising_edge(clk) then
      keep <= '0';
      waited <= 0;
      if m_axi_awready = '1' then
        awvalid <= '0';
      end if;
      if m_axi_wready = '1' then
        wvalid <= '0';
      end if;
      if m_axi_arready = '1' then
        arvalid <= '0';
      end if;
      if m_axi_bvalid = '1' then
        writing <= '0';
        if m_axi_bresp = "00" then
          counts(written_c) <= counts(written_c) + 1;
        end if;
      end if;
      if m_axi_rvalid = '1' then
        reading <= '0';
      end if;

      -- No case, and no array by index: GHDL 2.0 writes both into its Verilog without a default.
      if state = idle then
        length <= 0;
        bad <= '0';
        silence <= 0;
        crc <= crc16_start_c;
        state <= receive;
      elsif state = receive then
        if rx_valid = '1' then
          silence <= 0;
          crc <= crc16_step(crc, rx_data);
          bad <= bad or rx_error;
          keep <= '1';
          kept <= rx_data;
          kept_at <= to_unsigned(length mod longest_c, 8);

          for k in head'range loop

            if length = k then
              head(k) <= rx_data;
            end if;

          end loop;

          if length = longest_c then
            bad <= '1';
          else
            length <= length + 1;
          end if;
        elsif length > 0 and rx_receiving = '0' then
          if silence = gap_clocks_g - 1 then
            state <= check;
          else
            silence <= silence + 1;
          end if;
        end if;
      elsif state = check then
        code <= frame_code(head, halves, length);
        state <= decide;
        if bad = '1' or length < shortest_c or unsigned(crc) /= 0 then
          counts(dropped_c) <= counts(dropped_c) + 1;
          state <= idle;
        elsif unsigned(head(0)) /= unit_g then
          state <= idle;
        end if;
      elsif state = decide then
        moved <= 0;
        if code /= no_exception_c then
          state <= answer;
        elsif head(1) = write_registers_c then
          address <= halves(0)(11 downto 1);
          left <= to_integer(halves(1)(6 downto 1));
          place <= to_unsigned(write_head_c, 8);
          state <= fetch;
        elsif head(1) = write_and_read_c then
          address <= halves(2)(11 downto 1);
          left <= to_integer(halves(3)(6 downto 1));
          place <= to_unsigned(head_c, 8);
          state <= fetch;
        else
          state <= start_read;
        end if;

      -- A word of the frame, and its write
      elsif state = fetch then
        word <= word(23 downto 0) & fetched;
        if moved < 4 then
          moved <= moved + 1;
          place <= place + 1;
        else
          moved <= 0;
          state <= ask_write;
        end if;
      elsif state = ask_write then
        if writing = '1' or address(10) = '1' then
          code <= device_failure_c;
          state <= answer;
        else
          waddr <= address(9 downto 0);
          wdata <= word;
          awvalid <= '1';
          wvalid <= '1';
          writing <= '1';
          state <= write;
        end if;
      elsif state = write then
        waited <= waited + 1;
        if m_axi_bvalid = '1' and m_axi_bresp = "00" then
          address <= address + 1;
          left <= left - 1;
          if left > 1 then
            state <= fetch;
          elsif head(1) = write_registers_c then
            state <= answer;
          else
            state <= start_read;
          end if;
        elsif m_axi_bvalid = '1' or waited = bus_clocks_g - 1 then
          code <= device_failure_c;
          state <= answer;
        end if;

      -- A word read, and its bytes into the answer
      elsif state = start_read then
        address <= halves(0)(11 downto 1);
        left <= to_integer(halves(1)(6 downto 1));
        place <= to_unsigned(answer_head_c, 8);
        state <= ask_read;
      elsif state = ask_read then
        if address(10) = '1' then

          for k in counts'range loop

            if address(1 downto 0) = k then
              word <= std_ulogic_vector(counts(k));
            end if;

          end loop;

          state <= store;
        elsif reading = '1' then
          code <= device_failure_c;
          state <= answer;
        else
          raddr <= address(9 downto 0);
          arvalid <= '1';
          reading <= '1';
          state <= read;
        end if;
      elsif state = read then
        waited <= waited + 1;
        if m_axi_rvalid = '1' and m_axi_rresp = "00" then
          word <= m_axi_rdata;
          state <= store;
        elsif m_axi_rvalid = '1' or waited = bus_clocks_g - 1 then
          code <= device_failure_c;
          state <= answer;
        end if;
      elsif state = store then
        keep <= '1';
        kept <= word(31 downto 24);
        kept_at <= place;
        word <= word(23 downto 0) & x"00";
        place <= place + 1;
        if moved < 3 then
          moved <= moved + 1;
        else
          moved <= 0;
          address <= address + 1;
          left <= left - 1;
          if left > 1 then
            state <= ask_read;
          else
            state <= answer;
          end if;
        end if;

      -- The answer
      elsif state = answer then
        crc <= crc16_start_c;
        moved <= 0;
        place <= (others => '0');
        counts(answered_c) <= counts(answered_c) + 1;
        if code /= no_exception_c then
          counts(exceptions_c) <= counts(exceptions_c) + 1;
          last <= to_unsigned(2, 8);
        elsif head(1) = write_registers_c then
          last <= to_unsigned(5, 8);
        else
          last <= answer_bytes + 2;
        end if;
        state <= load;
      elsif state = load then
        state <= send;
      elsif state = send then
        if tx_ready = '1' then
          crc <= crc16_step(crc, answer_byte);
          place <= place + 1;
          if place = last then
            state <= send_crc;
          else
            state <= load;
          end if;
        end if;
      elsif state = send_crc then
        if tx_ready = '1' then
          crc <= x"00" & crc(15 downto 8);
          moved <= moved + 1;
          if moved = 1 then
            state <= drain;
          end if;
        end if;
      elsif state = drain then
        if tx_ready = '1' then
          state <= idle;
        end if;
      end if;

      if rst = '1' then
        state <= idle;
        awvalid <= '0';
        wvalid <= '0';
        arvalid <= '0';
        writing <= '0';
        reading <= '0';
        counts <= (others => (others => '0'));
      end if;
    end if;

  end process p_modbus;

  -- Bytes of data in the answer to a read.
  answer_bytes <= halves(1)(6 downto 0) & '0';

  p_answer : process (all) is
  begin

    answer_byte <= fetched;

    if place = 1 and code /= no_exception_c then
      answer_byte <= head(1) or x"80";
    elsif place = 2 and code /= no_exception_c then
      answer_byte <= "00000" & code;
    elsif place = 2 and head(1) /= write_registers_c then
      answer_byte <= std_ulogic_vector(answer_bytes);
    end if;

  end process p_answer;

  tx_valid <= '1' when state = send or state = send_crc else '0';
  tx_data <= crc(7 downto 0) when state = send_crc else answer_byte;
  tx_enable <= '1' when state = load or state = send or state = send_crc or state = drain else '0';

  m_axi_awaddr <= std_ulogic_vector(waddr) & "00";
  m_axi_awprot <= "000";
  m_axi_awvalid <= awvalid;
  m_axi_wdata <= wdata;
  m_axi_wstrb <= "1111";
  m_axi_wvalid <= wvalid;
  m_axi_bready <= '1';
  m_axi_araddr <= std_ulogic_vector(raddr) & "00";
  m_axi_arprot <= "000";
  m_axi_arvalid <= arvalid;
  m_axi_rready <= '1';

end architecture rtl;
