-- SPDX-License-Identifier: MIT
--
-- Asynchronous serial port: a start bit, eight data bits, lowest first, parity if wanted, one stop bit.
--
-- Time: clock_hz_g / baud_g clocks per bit on average, whole or not; no edge is more than a clock away from its place.
-- Received bits are the majority of three samples, 2, 3 and 4 eighths of a bit after their beginning: a pulse shorter
-- than an eighth changes none. With c clocks per bit and n bits per character a sender is understood that is fast by
-- less than (1/2 - 2/c) / (n - 1/2 + 2/c), 3.6 % at 3 Mbaud and 40 MHz, or slow by less than 3/8 / n.
-- Latency: out_valid comes in the middle of the stop bit and the stages of gc_synchronizer later; pin_tx falls 1 clock
-- after in_valid. Illegal input: a start bit that is high in its middle was none; a character with a wrong parity or a
-- low stop bit comes with out_error; after a break the line must be high before the next character.

library ieee;
  use ieee.std_logic_1164.all;

library work;
  use work.gc_safety_pkg.all;

entity gc_uart is
  generic (
    -- Hz of clk, at least eight times the baud rate.
    clock_hz_g : positive := 40_000_000;
    -- Bits per second.
    baud_g     : positive := 115_200;
    -- 0: no parity; 1: odd; 2: even.
    parity_g   : natural range 0 to 2 := 0
  );
  port (
    clk           : in    std_ulogic;
    -- Synchronous, active high.
    rst           : in    std_ulogic;
    -- Asynchronous; high at rest.
    pin_rx        : in    std_ulogic;
    pin_tx        : out   std_ulogic;
    -- A character was received; one clock.
    out_valid     : out   std_ulogic;
    out_data      : out   std_ulogic_vector(7 downto 0);
    -- With out_valid: it is not the one that was sent.
    out_error     : out   std_ulogic;
    -- A character is being received.
    sts_receiving : out   std_ulogic;
    -- A character to send, taken in a clock with in_ready; in_ready is low until all of it is sent.
    in_valid      : in    std_ulogic;
    in_ready      : out   std_ulogic;
    in_data       : in    std_ulogic_vector(7 downto 0)
  );
end entity gc_uart;

architecture rtl of gc_uart is

  -- Start bit, data and parity.
  constant bits_c   : positive := 9 + (parity_g + 1) / 2;
  -- The parity of data and parity bit, where there is one.
  constant odd_c    : std_ulogic_vector(0 to 2) := "010";
  constant parity_c : std_ulogic_vector(0 to 2) := "011";

  -- A phase goes through clock_hz_g in an eighth of a bit that is received, in a bit that is sent.
  constant eighth_step_c : positive := 8 * baud_g;
  -- The eighth, from 0, at whose end the last of the three samples is taken.
  constant decision_c    : positive := 3;

  signal known     : std_ulogic;
  signal synced    : std_ulogic;
  signal level     : std_ulogic;
  -- The line was high, the clock before or in the stop bit.
  signal was_high  : std_ulogic := '0';
  -- The last two samples.
  signal samples   : std_ulogic_vector(1 downto 0) := (others => '0');
  signal majority  : std_ulogic;
  signal receiving : std_ulogic := '0';
  signal rx_phase  : natural range 0 to clock_hz_g - 1 := 0;
  signal eighth    : natural range 0 to 7 := 0;
  signal rx_bit    : natural range 0 to bits_c := 0;
  signal rx_data   : std_ulogic_vector(7 downto 0) := (others => '0');
  signal rx_parity : std_ulogic := '0';
  signal rx_valid  : std_ulogic := '0';
  signal rx_error  : std_ulogic := '0';

  signal tx_phase : natural range 0 to clock_hz_g - 1 := 0;
  -- Bits to come, the next one lowest, and how many are left with the one on the line.
  signal tx_bits  : std_ulogic_vector(8 downto 0);
  signal tx_left  : natural range 0 to bits_c + 1 := 0;
  signal tx_level : std_ulogic := '1';

begin

  assert clock_hz_g / baud_g >= 8
    report "gc_uart: need clock_hz_g >= 8 baud_g, got " & integer'image(clock_hz_g) & " and " & integer'image(baud_g)
    severity failure;

  -- Received

  i_synchronizer : entity work.gc_synchronizer
    port map (
      clk           => clk,
      rst           => rst,
      async_data(0) => pin_rx,
      out_valid     => known,
      out_data(0)   => synced
    );

  level <= synced and known;
  majority <= (level and samples(0)) or (level and samples(1)) or (samples(0) and samples(1));

  p_receive : process (clk) is
  begin

    if rising_edge(clk) then
      rx_valid <= '0';
      if receiving = '0' then
        rx_phase <= 0;
        eighth <= 0;
        rx_bit <= 0;
        rx_parity <= odd_c(parity_g);
        was_high <= level;
        receiving <= was_high and not level;
      elsif rx_phase < clock_hz_g - eighth_step_c then
        rx_phase <= rx_phase + eighth_step_c;
      else
        rx_phase <= rx_phase - (clock_hz_g - eighth_step_c);
        eighth <= (eighth + 1) mod 8;
        samples <= samples(0) & level;
        if eighth = decision_c then
          was_high <= majority;
          if rx_bit = 0 then
            receiving <= not majority;
          elsif rx_bit = bits_c then
            receiving <= '0';
            rx_valid <= '1';
            rx_error <= not majority or (rx_parity and parity_c(parity_g));
          else
            rx_parity <= rx_parity xor majority;
            if rx_bit <= 8 then
              rx_data <= majority & rx_data(7 downto 1);
            end if;
          end if;
          rx_bit <= (rx_bit + 1) mod (bits_c + 1);
        end if;
      end if;
      if rst = '1' then
        was_high <= '0';
        receiving <= '0';
        rx_valid <= '0';
      end if;
    end if;

  end process p_receive;

  out_valid <= rx_valid;
  out_data <= rx_data;
  out_error <= rx_error;
  sts_receiving <= receiving;

  -- Sent

  p_send : process (clk) is
  begin

    if rising_edge(clk) then
      if tx_left = 0 then
        tx_phase <= 0;
        tx_bits <= (odd_c(parity_g) xor parity_of(in_data)) & in_data;
        if in_valid = '1' then
          tx_level <= '0';
          tx_left <= bits_c + 1;
        end if;
      elsif tx_phase < clock_hz_g - baud_g then
        tx_phase <= tx_phase + baud_g;
      else
        tx_phase <= tx_phase - (clock_hz_g - baud_g);
        tx_bits <= '1' & tx_bits(8 downto 1);
        tx_left <= tx_left - 1;
        tx_level <= '1';
        if tx_left > 2 then
          tx_level <= tx_bits(0);
        end if;
      end if;
      if rst = '1' then
        tx_left <= 0;
        tx_level <= '1';
      end if;
    end if;

  end process p_send;

  in_ready <= '1' when tx_left = 0 else '0';
  pin_tx <= tx_level;

end architecture rtl;
