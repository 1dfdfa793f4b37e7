-- SPDX-License-Identifier: MIT
--
-- Reads channels 0 to channels_g - 1 of a serial ADC once per in_valid, and scales them to currents:
--
--   sense_current = saturated((code - cfg_zero) cfg_scale / 2**8)
--
-- A frame is frame_bits_g bits, first the highest, both ways at once (SPI mode 3: SCLK rests high, data change as it
-- falls and are read while it is high). Out goes command_g + channel 2**channel_shift_g; in comes, of the channel asked
-- for in the frame before, id_bits_g bits of its number, the code and zeros. So a scan has channels_g + 1 frames.
-- The defaults are those of the MAX11123 and MAX11125 (12 bits), as on the ULX3S, in their mode 'manual' with
-- CHAN_ID = 1, SWCNV = 1; an ADC of 16 bits without a number has code_bits_g = 16, id_bits_g = 0.
-- A number that is not the one asked for: the code is dropped and counted.
--
-- Timing: SCLK has 2 half_clocks_g clocks a period; CS is high for gap_clocks_g + 1 between frames, and leads and
-- trails SCLK by half_clocks_g. pin_miso is taken at the end of the high half, two flip-flops behind the pin.
-- Latency: a frame takes (2 frame_bits_g + 2) half_clocks_g + gap_clocks_g + 1 clocks; 4 more to sense_valid.
-- in_valid in a scan is not seen. Overflow: saturates; sts_errors stays at its largest value.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_fixed_pkg.all;

entity gc_adc_spi is
  generic (
    -- Channels, 1 to 8.
    channels_g      : positive := 3;
    -- Bits of a code, 8 to 16, of the channel's number before it, and of a frame.
    code_bits_g     : positive := 12;
    id_bits_g       : natural := 4;
    frame_bits_g    : positive := 16;
    -- What asks for channel 0, and the lowest bit of the channel in it.
    command_g       : natural := 16#0806#;
    channel_shift_g : natural := 7;
    -- Clocks of half a period of SCLK, at least 3, and between frames.
    half_clocks_g   : positive := 4;
    gap_clocks_g    : positive := 8
  );
  port (
    clk           : in    std_ulogic;
    -- Synchronous, active high: ends a scan.
    rst           : in    std_ulogic;
    -- One clock: begin a scan.
    in_valid      : in    std_ulogic;
    pin_cs_n      : out   std_ulogic := '1';
    pin_sclk      : out   std_ulogic := '1';
    pin_mosi      : out   std_ulogic := '0';
    -- Asynchronous.
    pin_miso      : in    std_ulogic;
    -- Code of no current, channel 0 lowest, and uA per code with 8 bits behind the point, signed.
    cfg_zero      : in    unsigned(channels_g * 16 - 1 downto 0);
    cfg_scale     : in    signed(channels_g * 24 - 1 downto 0);
    -- One clock per code of a channel; currents in uA hold until the next, channel 0 lowest.
    sense_valid   : out   std_ulogic_vector(channels_g - 1 downto 0) := (others => '0');
    sense_current : out   signed(channels_g * 32 - 1 downto 0) := (others => '0');
    -- Codes that came with a wrong number, since reset.
    sts_errors    : out   unsigned(15 downto 0)
  );
end entity gc_adc_spi;

architecture rtl of gc_adc_spi is

  -- Pins: idle is CS high; lead and trail are CS low with SCLK high.

  type state_t is (idle, lead, low, high, trail);

  subtype frame_t is std_ulogic_vector(frame_bits_g - 1 downto 0);

  -- Bits of a frame that come after the code.

  function unused_bits return natural is
  begin

    if id_bits_g + code_bits_g > frame_bits_g then
      return 0;
    end if;

    return frame_bits_g - id_bits_g - code_bits_g;

  end function unused_bits;

  constant unused_c : natural := unused_bits;

  subtype channel_t is natural range 0 to channels_g - 1;

  -- What asks for a channel.

  function command (
    channel : channel_t
  ) return frame_t is
  begin

    return std_ulogic_vector(to_unsigned(command_g + channel * 2 ** channel_shift_g, frame_bits_g));

  end function command;

  signal state   : state_t := idle;
  signal clocks  : natural range 0 to half_clocks_g - 1 := 0;
  signal gap     : natural range 0 to gap_clocks_g := 0;
  signal bits    : natural range 0 to frame_bits_g - 1 := 0;
  -- A scan is on; frames of it that are done; the channel that a frame asks for.
  signal scans   : std_ulogic := '0';
  signal frame   : natural range 0 to channels_g := 0;
  signal asked   : channel_t := 0;
  signal send    : frame_t := (others => '0');
  signal receive : frame_t := (others => '0');
  signal miso    : std_ulogic_vector(0 downto 0);

  -- The channel of a frame that came, and bit k: it is in stage k.
  signal channel : channel_t := 0;
  signal valid   : std_ulogic_vector(0 to 3) := (others => '0');
  signal code    : unsigned(code_bits_g - 1 downto 0);
  signal id      : unsigned(3 downto 0);
  signal above   : signed(16 downto 0) := (others => '0');
  signal scale   : signed(23 downto 0) := (others => '0');
  signal product : signed(40 downto 0);
  signal errors  : unsigned(15 downto 0) := (others => '0');

begin

  assert half_clocks_g >= 3
    report "gc_adc_spi: need half_clocks_g >= 3, got " & integer'image(half_clocks_g)
    severity failure;

  assert code_bits_g <= 16 and id_bits_g <= 4 and id_bits_g + code_bits_g <= frame_bits_g
    report "gc_adc_spi: need code_bits_g <= 16, id_bits_g <= 4 and both within frame_bits_g, got "
           & integer'image(code_bits_g) & ", " & integer'image(id_bits_g) & " and " & integer'image(frame_bits_g)
    severity failure;

  i_miso : entity work.gc_synchronizer
    port map (
      clk           => clk,
      rst           => '0',
      async_data(0) => pin_miso,
      out_valid     => open,
      out_data      => miso
    );

  p_frames : process (clk) is
  begin

    if rising_edge(clk) then
      valid(0) <= '0';
      if clocks /= half_clocks_g - 1 then
        clocks <= clocks + 1;
      end if;
      if gap /= gap_clocks_g then
        gap <= gap + 1;
      end if;

      if state = idle then
        clocks <= 0;
        if scans = '0' then
          frame <= 0;
          asked <= 0;
          scans <= in_valid;
        elsif gap = gap_clocks_g then
          state <= lead;
          pin_cs_n <= '0';
          send <= command(asked);
          bits <= 0;
        end if;
      elsif clocks = half_clocks_g - 1 then
        clocks <= 0;
        if state = lead or (state = high and bits /= frame_bits_g - 1) then
          state <= low;
          pin_sclk <= '0';
          pin_mosi <= send(frame_bits_g - 1);
          send <= send(frame_bits_g - 2 downto 0) & '0';
        elsif state = low then
          state <= high;
          pin_sclk <= '1';
        elsif state = high then
          state <= trail;
        else
          state <= idle;
          pin_cs_n <= '1';
          gap <= 0;
        end if;
        if state = high then
          receive <= receive(frame_bits_g - 2 downto 0) & miso(0);
          if bits /= frame_bits_g - 1 then
            bits <= bits + 1;
          end if;
        end if;
        if state = trail then
          -- The first frame brings what was asked for in the scan before.
          if frame /= 0 then
            valid(0) <= '1';
            channel <= frame - 1;
          end if;
          if frame = channels_g then
            scans <= '0';
          else
            frame <= frame + 1;
          end if;
          asked <= 0;
          if frame < channels_g - 1 then
            asked <= asked + 1;
          end if;
        end if;
      end if;

      if rst = '1' then
        state <= idle;
        pin_cs_n <= '1';
        pin_sclk <= '1';
        scans <= '0';
        gap <= 0;
        valid(0) <= '0';
      end if;
    end if;

  end process p_frames;

  code <= resize(shift_right(unsigned(receive), unused_c), code_bits_g);
  id <= shift_right(resize(unsigned(receive(frame_bits_g - 1 downto frame_bits_g - 4)), 4), 4 - id_bits_g);

  i_multiply : entity work.gc_multiply
    generic map (
      a_bits_g => 17,
      b_bits_g => 24
    )
    port map (
      clk         => clk,
      rst         => rst,
      in_valid    => '0',
      in_a        => above,
      in_b        => scale,
      out_valid   => open,
      out_product => product
    );

  p_scale : process (clk) is
  begin

    if rising_edge(clk) then
      valid(1 to 3) <= valid(0 to 2);
      sense_valid <= (others => '0');
      if valid(0) = '1' and id_bits_g > 0 and id /= channel then
        valid(1) <= '0';
        if errors /= (errors'range => '1') then
          errors <= errors + 1;
        end if;
      end if;

      for i in 0 to channels_g - 1 loop

        if channel = i then
          -- stage 1: distance from zero; stages 2 and 3: the product
          above <= signed(resize(code, 17)) - signed('0' & cfg_zero((i + 1) * 16 - 1 downto i * 16));
          scale <= cfg_scale((i + 1) * 24 - 1 downto i * 24);
          -- stage 4
          if valid(3) = '1' then
            sense_valid(i) <= '1';
            sense_current((i + 1) * 32 - 1 downto i * 32) <= saturate(truncate(product, 8, 33), 32);
          end if;
        end if;

      end loop;

      if rst = '1' then
        valid(1 to 3) <= (others => '0');
        sense_valid <= (others => '0');
        sense_current <= (others => '0');
        errors <= (others => '0');
      end if;
    end if;

  end process p_scale;

  sts_errors <= errors;

end architecture rtl;
