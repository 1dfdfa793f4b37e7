-- SPDX-License-Identifier: MIT
--
-- Reads an absolute encoder over BiSS C, point to point: its position, checked by its CRC, once per in_valid.
--
--   MA   ~~~|_|~|_|~|_|~| ... |_|~|_|~~~~~~~~~~~~   2 half_clocks_g clocks a period, rests high
--   SLO  ~~~~~~~|___| 1 | 0 | position, highest bit first | nE | nW | CRC, inverted |___|~~~~
--              ack  start CDS
--
-- The encoder answers at rising edges of MA. pin_slo is taken just before the next one, two flip-flops behind the pin:
-- driver, cable and encoder may take a period less 3 clocks; whole periods more are bits that begin later.
-- CRC: x**6 + x + 1 over position, nE and nW, from zero. Source: BiSS Interface, protocol description C5, 2015.
--
-- What keeps out_count as it was and is told by sts_error, until cfg_clear: a CRC that does not match; the encoder's
-- own error (nE = '0'); no start bit within start_periods_g periods; a line that is low before a frame, or still low
-- when MA has rested. So a wire that is broken or stuck is told with the next frame, whichever level it has.
--
-- Format: position_bits_g bits, two's complement -> 32 bits, counts.
-- Latency: 2 half_clocks_g clocks for each of position_bits_g + 9 periods and those up to the start bit, at most
-- start_periods_g, then rest_clocks_g and 1. in_valid in a frame is not seen.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity gc_biss is
  generic (
    -- Bits of a position, 2 to 32.
    position_bits_g : positive := 26;
    -- Clocks of half a period of MA, at least 2.
    half_clocks_g   : positive := 10;
    -- Periods within which the start bit has to come.
    start_periods_g : positive := 64;
    -- Clocks for which MA rests: the encoder's time-out at least.
    rest_clocks_g   : positive := 1600
  );
  port (
    clk         : in    std_ulogic;
    -- Synchronous, active high: no frame, no error.
    rst         : in    std_ulogic;
    -- One clock: begin a frame.
    in_valid    : in    std_ulogic;
    pin_ma      : out   std_ulogic := '1';
    -- Asynchronous; pull it up.
    pin_slo     : in    std_ulogic;
    -- One clock per frame without an error; the position holds until the next.
    out_valid   : out   std_ulogic := '0';
    out_count   : out   signed(31 downto 0) := (others => '0');
    -- The last frame was good.
    out_known   : out   std_ulogic := '0';
    cfg_clear   : in    std_ulogic;
    -- Level, a cause of gc_safety.
    sts_error   : out   std_ulogic := '0';
    -- nW = '0' in the last good frame.
    sts_warning : out   std_ulogic := '0'
  );
end entity gc_biss;

architecture rtl of gc_biss is

  -- position, nE, nW and CRC
  constant crc_bits_c  : positive := 6;
  constant data_bits_c : positive := position_bits_g + 2;
  constant bits_c      : positive := data_bits_c + crc_bits_c;

  -- rest: MA is high until the encoder's time-out is over. ack, start: waiting for a low and then a high SLO.

  type state_t is (idle, ack, start, cds, data, rest);

  subtype crc_t is std_ulogic_vector(crc_bits_c - 1 downto 0);

  -- The CRC after one more bit.

  function crc_step (
    crc : crc_t;
    value : std_ulogic
  ) return crc_t is

    constant carry_c : std_ulogic := crc(crc_t'high) xor value;

  begin

    return crc(crc_t'high - 1 downto 1) & (crc(0) xor carry_c) & carry_c;

  end function crc_step;

  -- After its complement, which is itself and six '1': after itself it is zero, so it is what six '1' leave.

  function complement_left return crc_t is

    variable crc_v : crc_t := (others => '0');

  begin

    for i in crc_t'range loop

      crc_v := crc_step(crc_v, '1');

    end loop;

    return crc_v;

  end function complement_left;

  constant left_c : crc_t := complement_left;

  signal state   : state_t := idle;
  signal slo     : std_ulogic_vector(0 downto 0);
  signal ma      : std_ulogic := '1';
  signal clocks  : natural range 0 to half_clocks_g - 1 := 0;
  signal waits   : natural range 0 to start_periods_g := 0;
  signal resting : natural range 0 to rest_clocks_g := 0;
  signal bits    : natural range 0 to bits_c - 1 := 0;
  signal word    : std_ulogic_vector(data_bits_c - 1 downto 0) := (others => '0');
  signal crc     : crc_t := (others => '0');
  signal good    : std_ulogic := '0';

begin

  assert position_bits_g >= 2 and position_bits_g <= 32
    report "gc_biss: need position_bits_g in 2 to 32, got " & integer'image(position_bits_g)
    severity failure;

  assert half_clocks_g >= 2
    report "gc_biss: need half_clocks_g >= 2, got " & integer'image(half_clocks_g)
    severity failure;

  i_slo : entity work.gc_synchronizer
    port map (
      clk           => clk,
      rst           => '0',
      async_data(0) => pin_slo,
      out_valid     => open,
      out_data      => slo
    );

  p_biss : process (clk) is

    variable sample_v : std_ulogic;
    variable bad_v    : std_ulogic;

  begin

    if rising_edge(clk) then
      out_valid <= '0';
      bad_v := '0';
      sample_v := '0';

      -- MA; a sample is taken in the clock before it rises
      if state = idle or state = rest then
        ma <= '1';
        clocks <= 0;
      elsif clocks = half_clocks_g - 1 then
        clocks <= 0;
        ma <= not ma;
        sample_v := not ma;
      else
        clocks <= clocks + 1;
      end if;

      if state = idle and in_valid = '1' then
        state <= ack;
        waits <= 0;
        if slo(0) = '0' then
          bad_v := '1';
          state <= idle;
        end if;
      end if;

      if sample_v = '1' then
        if state = ack and slo(0) = '0' then
          state <= start;
        elsif state = start and slo(0) = '1' then
          state <= cds;
        elsif state = ack or state = start then
          waits <= waits + 1;
          if waits = start_periods_g - 1 then
            bad_v := '1';
            good <= '0';
            state <= rest;
          end if;
        elsif state = cds then
          bits <= 0;
          crc <= (others => '0');
          state <= data;
        else
          crc <= crc_step(crc, slo(0));
          if bits < data_bits_c then
            word <= word(data_bits_c - 2 downto 0) & slo(0);
          end if;
          if bits /= bits_c - 1 then
            bits <= bits + 1;
          else
            good <= '1';
            state <= rest;
          end if;
        end if;
      end if;

      -- Judged when the line is back.
      resting <= 0;
      if state = rest then
        resting <= resting + 1;
        if resting = rest_clocks_g - 1 then
          state <= idle;
          if good = '1' then
            if crc /= left_c or word(1) = '0' or slo(0) = '0' then
              bad_v := '1';
            else
              out_valid <= '1';
              out_known <= '1';
              out_count <= resize(signed(word(data_bits_c - 1 downto 2)), 32);
              sts_warning <= not word(0);
            end if;
          end if;
        end if;
      end if;

      if cfg_clear = '1' then
        sts_error <= '0';
      end if;
      if bad_v = '1' then
        sts_error <= '1';
        out_known <= '0';
      end if;

      if rst = '1' then
        state <= idle;
        ma <= '1';
        clocks <= 0;
        out_valid <= '0';
        out_known <= '0';
        out_count <= (others => '0');
        sts_error <= '0';
        sts_warning <= '0';
      end if;
    end if;

  end process p_biss;

  pin_ma <= ma;

end architecture rtl;
