-- SPDX-License-Identifier: MIT
--
-- Records what happens, tick by tick, in a ring of block RAM.
--
-- A record is 2 + 5 axes_g words of 32 bits:
--   0               tick number
--   1               31: records were lost before this one; 30: the measured current of an axis is older than the record
--                   before; 29 .. 0 in_status
--   2 + 5 i ..      of axis i: count, speed period, measured current (uA), command (uA), feed-forward (mN or mN m)
-- One per 2**cfg_ticks ticks, of the last of them. With cfg_mean count, currents, command and feed-forward are means of
-- all, rounded to the nearest, halves upwards.
--
-- cfg_mode, and what becomes of a record that finds the ring full:
--   1 free    it is lost, counted, and the next one that is kept says so
--   2 single  recording ends
--   3 fault   until in_trigger the cfg_before newest records are kept, older ones give way; after it as single
--   0 off     nothing is recorded, and what was stays to be read. Leaving it, or a change of mode, begins anew.
-- The ring holds as many whole records as go into 2**address_bits_g words.
-- Reading changes nothing, so a line may repeat it: read_addr counts words from the first of the oldest record. in_drop
-- gives the oldest record's place back; not while waiting for the trigger.
--
-- The other cfg_* are taken with the mode. What comes with in_valid holds for 2 + 5 axes_g clocks more; the record is
-- there, and the next tick may come, 4 clocks after that. Latency of read_word: 1 clock.
-- Overflow: sts_lost stays at its largest value; sums of 2**15 ticks fit their 47 bits.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_fixed_pkg.all;

entity gc_recorder is
  generic (
    -- Axes, 1 to 8.
    axes_g         : positive := 3;
    -- Words of the ring, as a power of two: room for one record at least.
    address_bits_g : positive := 10
  );
  port (
    clk           : in    std_ulogic;
    -- Synchronous, active high: nothing recorded.
    rst           : in    std_ulogic;
    cfg_mode      : in    unsigned(1 downto 0);
    -- Ticks of a record, as a power of two, and whether it is their mean.
    cfg_ticks     : in    unsigned(3 downto 0);
    cfg_mean      : in    std_ulogic;
    -- Records to keep of before the trigger.
    cfg_before    : in    unsigned(address_bits_g - 1 downto 0);
    -- One clock per tick, and what there is to record of it, axis 1 lowest.
    in_valid      : in    std_ulogic;
    in_tick       : in    unsigned(31 downto 0);
    in_status     : in    std_ulogic_vector(29 downto 0);
    in_count      : in    signed(axes_g * 32 - 1 downto 0);
    in_period     : in    signed(axes_g * 32 - 1 downto 0);
    in_command    : in    signed(axes_g * 32 - 1 downto 0);
    in_force      : in    signed(axes_g * 32 - 1 downto 0);
    -- Level: what ends the waiting of mode fault.
    in_trigger    : in    std_ulogic;
    -- One clock per measured current of an axis; uA, axis 1 lowest.
    sense_valid   : in    std_ulogic_vector(axes_g - 1 downto 0);
    sense_current : in    signed(axes_g * 32 - 1 downto 0);
    -- Word after the first of the oldest record, below 2 + 5 axes_g times sts_records.
    read_addr     : in    unsigned(address_bits_g - 1 downto 0);
    read_word     : out   std_ulogic_vector(31 downto 0);
    -- One clock: the oldest record was read.
    in_drop       : in    std_ulogic;
    -- Whole records in the ring.
    sts_records   : out   unsigned(address_bits_g - 1 downto 0);
    -- Records that found no room, since recording began.
    sts_lost      : out   unsigned(31 downto 0);
    -- The trigger came.
    sts_triggered : out   std_ulogic;
    -- Recording has ended.
    sts_done      : out   std_ulogic
  );
end entity gc_recorder;

architecture rtl of gc_recorder is

  constant fields_c   : positive := 5;
  constant words_c    : positive := 2 + fields_c * axes_g;
  constant capacity_c : natural := 2 ** address_bits_g / words_c;

  constant off_c   : unsigned(1 downto 0) := "00";
  constant free_c  : unsigned(1 downto 0) := "01";
  constant fault_c : unsigned(1 downto 0) := "11";

  subtype address_t is unsigned(address_bits_g - 1 downto 0);

  subtype word_t is signed(31 downto 0);

  -- Of 2**15 words.

  subtype sum_t is signed(46 downto 0);

  subtype index_t is natural range 0 to words_c - 1;

  type words_t is array (index_t) of word_t;

  type sums_t is array (index_t) of sum_t;

  type ring_t is array (0 to 2 ** address_bits_g - 1) of std_ulogic_vector(31 downto 0);

  -- Whether a word is averaged.

  function averaged return std_ulogic_vector is

    variable averaged_v : std_ulogic_vector(index_t) := (others => '0');

  begin

    for i in 0 to axes_g - 1 loop

      averaged_v(2 + fields_c * i) := '1';
      averaged_v(4 + fields_c * i) := '1';
      averaged_v(5 + fields_c * i) := '1';
      averaged_v(6 + fields_c * i) := '1';

    end loop;

    return averaged_v;

  end function averaged;

  constant averaged_c : std_ulogic_vector(index_t) := averaged;

  signal mode   : unsigned(1 downto 0) := off_c;
  signal ticks  : natural range 0 to 15 := 0;
  signal whole  : unsigned(14 downto 0) := (others => '0');
  signal mean   : std_ulogic := '0';
  signal before : address_t := (others => '0');

  signal words   : words_t;
  signal sensed  : signed(axes_g * 32 - 1 downto 0) := (others => '0');
  signal unknown : std_ulogic_vector(axes_g - 1 downto 0) := (others => '1');

  -- Ticks of this record before the next one; the tick that is worked on is its first; the record has a place.
  signal turn  : unsigned(14 downto 0) := (others => '0');
  signal first : std_ulogic := '0';
  signal keep  : std_ulogic := '0';

  -- Bit k: a word is in stage k.
  signal valid   : std_ulogic_vector(0 to 3) := (others => '0');
  signal index   : index_t := 0;
  signal index_1 : index_t := 0;
  signal index_2 : index_t := 0;
  signal index_3 : index_t := 0;
  signal word_1  : word_t;
  signal sum_2   : sum_t;
  signal mean_3  : word_t;
  signal sums    : sums_t;
  signal ring    : ring_t;

  -- First words of the oldest record and of the next.
  signal oldest    : address_t := (others => '0');
  signal newest    : address_t := (others => '0');
  signal records   : natural range 0 to capacity_c := 0;
  signal lost      : unsigned(31 downto 0) := (others => '0');
  signal gap       : std_ulogic := '0';
  signal stale     : std_ulogic;
  signal status    : std_ulogic_vector(31 downto 0);
  signal triggered : std_ulogic := '0';
  signal done      : std_ulogic := '0';

begin

  assert axes_g <= 8
    report "gc_recorder: need axes_g <= 8, got " & integer'image(axes_g)
    severity failure;

  assert capacity_c > 0
    report "gc_recorder: need 2**address_bits_g >= " & integer'image(words_c) & ", got address_bits_g = "
           & integer'image(address_bits_g)
    severity failure;

  words(0) <= signed(in_tick);
  status <= gap & stale & in_status;
  words(1) <= signed(status);
  stale <= '0' when unsigned(unknown) = 0 else '1';

  g_words : for i in 0 to axes_g - 1 generate
    words(2 + fields_c * i) <= in_count((i + 1) * 32 - 1 downto i * 32);
    words(3 + fields_c * i) <= in_period((i + 1) * 32 - 1 downto i * 32);
    words(4 + fields_c * i) <= sensed((i + 1) * 32 - 1 downto i * 32);
    words(5 + fields_c * i) <= in_command((i + 1) * 32 - 1 downto i * 32);
    words(6 + fields_c * i) <= in_force((i + 1) * 32 - 1 downto i * 32);
  end generate g_words;

  sts_records <= to_unsigned(records, address_bits_g);
  sts_lost <= lost;
  sts_triggered <= triggered;
  sts_done <= done;

  p_words : process (clk) is

    variable sum_v  : sum_t;
    variable half_v : sum_t;

  begin

    if rising_edge(clk) then
      -- stage 0: a word a clock, beginning with the clock after the tick
      if valid(0) = '1' then
        if index = words_c - 1 then
          index <= 0;
        else
          index <= index + 1;
        end if;
      end if;

      -- stage 1: the word
      word_1 <= words(index);
      index_1 <= index;

      -- stage 2: its sum over the ticks of the record
      sum_v := resize(word_1, sum_t'length);
      if mean = '1' and first = '0' and averaged_c(index_1) = '1' then
        sum_v := sum_v + sums(index_1);
      end if;
      sum_2 <= sum_v;
      index_2 <= index_1;

      -- stage 3: the mean
      if valid(2) = '1' then
        sums(index_2) <= sum_2;
      end if;
      half_v := shift_right(shift_left(to_signed(1, sum_t'length), ticks), 1);
      mean_3 <= sum_2(31 downto 0);
      if mean = '1' and averaged_c(index_2) = '1' then
        mean_3 <= truncate(sum_2 + half_v, ticks, 32);
      end if;
      index_3 <= index_2;

      if cfg_mode /= mode or rst = '1' then
        index <= 0;
      end if;
    end if;

  end process p_words;

  p_ring : process (clk) is
  begin

    if rising_edge(clk) then
      if valid(3) = '1' and keep = '1' then
        ring(to_integer(newest + index_3)) <= std_ulogic_vector(mean_3);
      end if;
      read_word <= ring(to_integer(oldest + read_addr));
    end if;

  end process p_ring;

  p_record : process (clk) is

    variable records_v : natural range 0 to capacity_c;
    variable waits_v   : std_ulogic;
    variable give_v    : std_ulogic;

  begin

    if rising_edge(clk) then
      records_v := records;
      waits_v := '0';
      if mode = fault_c and triggered = '0' then
        waits_v := '1';
      end if;
      give_v := in_drop and not waits_v;

      valid <= valid(0) & valid(0 to 2);
      if index = words_c - 1 then
        valid(0) <= '0';
      end if;

      -- The flags of a record that is kept are out.
      unknown <= unknown and not sense_valid;
      if valid(0) = '1' and index = 1 and keep = '1' then
        unknown <= not sense_valid;
        gap <= '0';
      end if;

      -- Its last word is.
      if valid(3) = '1' and index_3 = words_c - 1 and keep = '1' then
        newest <= newest + words_c;
        records_v := records_v + 1;
        if mode /= free_c and waits_v = '0' and records_v = capacity_c then
          done <= '1';
        end if;
      end if;

      if in_trigger = '1' and mode = fault_c then
        triggered <= '1';
      end if;

      -- A tick; the last of a record finds its place.
      if in_valid = '1' and unsigned(valid) = 0 and mode /= off_c and done = '0' then
        valid(0) <= '1';
        keep <= '0';
        first <= '0';
        if turn = 0 then
          first <= '1';
        end if;
        turn <= turn + 1;
        if turn = whole then
          turn <= (others => '0');
          keep <= '1';
          if waits_v = '1' then
            if before = 0 then
              keep <= '0';
            elsif records = capacity_c or records >= before then
              give_v := '1';
            end if;
          elsif records = capacity_c then
            keep <= '0';
            if mode /= free_c then
              done <= '1';
            else
              gap <= '1';
              if lost /= (lost'range => '1') then
                lost <= lost + 1;
              end if;
            end if;
          end if;
        end if;
      end if;

      if give_v = '1' and records /= 0 then
        oldest <= oldest + words_c;
        records_v := records_v - 1;
      end if;
      records <= records_v;

      if cfg_mode /= mode then
        mode <= cfg_mode;
        ticks <= to_integer(cfg_ticks);
        whole <= resize(shift_left(to_unsigned(1, 16), to_integer(cfg_ticks)) - 1, 15);
        mean <= cfg_mean;
        before <= cfg_before;
        valid <= (others => '0');
        turn <= (others => '0');
        if cfg_mode /= off_c then
          oldest <= (others => '0');
          newest <= (others => '0');
          records <= 0;
          lost <= (others => '0');
          gap <= '0';
          unknown <= not sense_valid;
          sensed <= (others => '0');
          triggered <= '0';
          done <= '0';
        end if;
      end if;

      for i in 0 to axes_g - 1 loop

        if sense_valid(i) = '1' then
          sensed((i + 1) * 32 - 1 downto i * 32) <= sense_current((i + 1) * 32 - 1 downto i * 32);
        end if;

      end loop;

      if rst = '1' then
        mode <= off_c;
        valid <= (others => '0');
        oldest <= (others => '0');
        newest <= (others => '0');
        records <= 0;
        lost <= (others => '0');
        triggered <= '0';
        done <= '0';
      end if;
    end if;

  end process p_record;

end architecture rtl;
