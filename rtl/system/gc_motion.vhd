-- SPDX-License-Identifier: MIT
--
-- What moves the robot and what remembers it: gc_setpoint, gc_servo and gc_recorder between gc_force_path and gc_drive.
--
-- Setpoints and servo go on with each inference that begins; a record is taken of each result, once gc_drive has made
-- a command of it. out_busy keeps the next inference from beginning before: so none of the three misses a tick.
-- A move is taken only while the brakes are released. run = '0' ends it, and the servo starts from nothing again.
-- Words of the oldest record go to the host one by one: it names one and turns in_fetch.turn over, which comes back
-- with the word; zero where there is none. Places of records come free as in_settings.record_taken goes up; until they
-- are, no word is answered.
-- Latency: 1 clock from in_valid to out_valid.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_facts_pkg.all;
  use work.gc_network_pkg.all;
  use work.gc_servo_pkg.all;
  use work.gc_system_pkg.all;

entity gc_motion is
  generic (
    -- Words of the recorder's ring, as a power of two.
    record_bits_g : positive
  );
  port (
    clk           : in    std_ulogic;
    -- Synchronous, active high.
    rst           : in    std_ulogic;
    -- The command is active; the brakes are released.
    run           : in    std_ulogic;
    released      : in    std_ulogic;
    in_settings   : in    motion_settings_t;
    -- One clock: begin a move.
    in_move       : in    std_ulogic;
    in_fetch      : in    fetch_t;
    -- An inference begins on these counts.
    in_begins     : in    std_ulogic;
    in_count      : in    flat_t;
    -- One clock per result: the current asked for, uA; it holds until the next, as does what it comes from.
    in_valid      : in    std_ulogic;
    in_current    : in    flat_t;
    in_position   : in    flat_t;
    in_period     : in    flat_t;
    in_force      : in    flat_t;
    -- What gc_drive made of it, uA.
    in_command    : in    flat_t;
    -- Ticks so far; state, run and faults; level: a fault.
    in_tick       : in    unsigned(31 downto 0);
    in_status     : in    std_ulogic_vector(29 downto 0);
    in_fault      : in    std_ulogic;
    -- One clock per measured current of an axis; uA.
    sense_valid   : in    axes_t;
    sense_current : in    flat_t;
    -- The current asked for and its correction, uA; the axis is astray.
    out_valid     : out   std_ulogic;
    out_current   : out   flat_t;
    out_astray    : out   axes_t;
    -- A record is being taken.
    out_busy      : out   std_ulogic;
    out_state     : out   motion_state_t
  );
end entity gc_motion;

architecture rtl of gc_motion is

  -- Clocks from a result to its command, and for a record to be taken (gc_recorder).
  constant until_command_c : positive := drive_clocks_c;
  constant until_taken_c   : positive := 2 + 5 * axes_c + 4;

  constant most_before_c : natural := 2 ** record_bits_g - 1;

  constant off_c   : std_ulogic_vector(1 downto 0) := "00";
  constant fault_c : std_ulogic_vector(1 downto 0) := "11";

  subtype flat_words_t is unsigned(32 * axes_c - 1 downto 0);

  -- Settings, axes side by side.
  signal target           : flat_t;
  signal speed_max        : flat_words_t;
  signal acceleration_max : flat_words_t;
  signal proportional     : flat_words_t;
  signal integral         : flat_words_t;
  signal derivative       : flat_words_t;
  signal servo_limit      : flat_magnitudes_t;
  signal following_max    : flat_words_t;

  signal clocks_left : natural range 0 to until_command_c + until_taken_c := 0;
  signal records_now : std_ulogic;

  signal move_ready : std_ulogic;
  signal move_valid : std_ulogic;
  signal ready      : std_ulogic;
  signal too_narrow : std_ulogic;
  signal not_taken  : std_ulogic := '0';
  signal moves      : unsigned(7 downto 0) := (others => '0');
  signal setpoint   : flat_t;
  signal correction : flat_t;
  signal astray     : axes_t;

  signal asked_before : natural range 0 to 2 ** 16 - 1;
  signal before       : unsigned(record_bits_g - 1 downto 0);
  signal mode         : std_ulogic_vector(1 downto 0) := off_c;
  signal dropped      : unsigned(31 downto 0) := (others => '0');
  signal ahead        : unsigned(31 downto 0);
  signal drops        : std_ulogic;
  signal read_addr    : unsigned(record_bits_g - 1 downto 0);
  signal read_word    : word_t;
  signal records      : unsigned(record_bits_g - 1 downto 0);
  signal lost         : unsigned(31 downto 0);
  signal triggered    : std_ulogic;
  signal done         : std_ulogic;
  signal asked        : std_ulogic;
  signal asked_1      : std_ulogic := '0';
  signal asked_2      : std_ulogic := '0';
  signal answered     : std_ulogic := '0';
  signal word         : word_t := (others => '0');

begin

  target <= flat(in_settings.target);
  speed_max <= unsigned(flat(in_settings.speed_max));
  acceleration_max <= unsigned(flat(in_settings.acceleration_max));
  proportional <= unsigned(flat(in_settings.proportional));
  integral <= unsigned(flat(in_settings.integral));
  derivative <= unsigned(flat(in_settings.derivative));
  servo_limit <= flat(in_settings.servo_limit);
  following_max <= unsigned(flat(in_settings.following_max));

  i_setpoint : entity work.gc_setpoint
    generic map (
      axes_g => axes_c
    )
    port map (
      clk              => clk,
      rst              => rst,
      run              => run,
      in_count         => in_count,
      in_valid         => in_begins,
      move_valid       => move_valid,
      move_ready       => move_ready,
      move_target      => target,
      move_ticks       => unsigned(in_settings.move_ticks),
      cfg_speed        => speed_max,
      cfg_acceleration => acceleration_max,
      out_setpoint     => setpoint,
      sts_refused      => too_narrow,
      sts_rate         => open
    );

  ready <= move_ready and released;
  move_valid <= in_move and ready;

  p_moves : process (clk) is
  begin

    if rising_edge(clk) then
      if in_move = '1' then
        moves <= moves + 1;
        not_taken <= not ready;
      end if;
      if rst = '1' then
        moves <= (others => '0');
        not_taken <= '0';
      end if;
    end if;

  end process p_moves;

  i_servo : entity work.gc_servo
    generic map (
      axes_g => axes_c
    )
    port map (
      clk              => clk,
      rst              => rst,
      run              => run,
      in_valid         => in_begins,
      in_count         => in_count,
      in_setpoint      => setpoint,
      cfg_proportional => proportional,
      cfg_integral     => integral,
      cfg_derivative   => derivative,
      cfg_filter       => unsigned(in_settings.filter),
      cfg_speed_feed   => in_settings.speed_feed,
      cfg_limit        => servo_limit,
      cfg_astray       => following_max,
      feed_valid       => in_valid,
      feed_current     => in_current,
      out_valid        => out_valid,
      out_current      => out_current,
      out_astray       => astray,
      sts_correction   => correction
    );

  out_astray <= astray;

  -- From a result to its record

  p_busy : process (clk) is
  begin

    if rising_edge(clk) then
      if in_valid = '1' then
        clocks_left <= until_command_c + until_taken_c;
      elsif clocks_left /= 0 then
        clocks_left <= clocks_left - 1;
      end if;
      if rst = '1' then
        clocks_left <= 0;
      end if;
    end if;

  end process p_busy;

  records_now <= '1' when clocks_left = until_taken_c else '0';
  out_busy <= '1' when clocks_left /= 0 else '0';

  -- More than there is room for is as much as there is room for.
  asked_before <= to_integer(unsigned(in_settings.record_before));
  before <= to_unsigned(most_before_c, record_bits_g) when asked_before > most_before_c else
            to_unsigned(asked_before, record_bits_g);

  i_recorder : entity work.gc_recorder
    generic map (
      axes_g         => axes_c,
      address_bits_g => record_bits_g
    )
    port map (
      clk           => clk,
      rst           => rst,
      cfg_mode      => unsigned(in_settings.record_mode),
      cfg_ticks     => unsigned(in_settings.record_ticks),
      cfg_mean      => in_settings.record_mean,
      cfg_before    => before,
      in_valid      => records_now,
      in_tick       => in_tick,
      in_status     => in_status,
      in_count      => in_position,
      in_period     => in_period,
      in_command    => in_command,
      in_force      => in_force,
      in_trigger    => in_fault,
      sense_valid   => sense_valid,
      sense_current => sense_current,
      read_addr     => read_addr,
      read_word     => read_word,
      in_drop       => drops,
      sts_records   => records,
      sts_lost      => lost,
      sts_triggered => triggered,
      sts_done      => done
    );

  -- Records go as the host has them: a write that comes twice, or of an older recording, drops none.
  ahead <= unsigned(in_settings.record_taken) - dropped;
  drops <= '1' when ahead /= 0 and ahead(31) = '0' and records /= 0 and not (mode = fault_c and triggered = '0') else
           '0';
  read_addr <= resize(unsigned(in_fetch.address), record_bits_g);
  asked <= (in_fetch.turn xor answered) and not drops;

  p_fetch : process (clk) is
  begin

    if rising_edge(clk) then
      if drops = '1' then
        dropped <= dropped + 1;
      end if;
      mode <= in_settings.record_mode;
      if in_settings.record_mode /= mode and in_settings.record_mode /= off_c then
        dropped <= (others => '0');
      end if;
      -- The ring answers a clock behind the address.
      asked_1 <= asked;
      asked_2 <= asked_1 and asked;
      if asked_2 = '1' and asked = '1' then
        word <= read_word;
        if records = 0 then
          word <= (others => '0');
        end if;
        answered <= in_fetch.turn;
        asked_1 <= '0';
        asked_2 <= '0';
      end if;
      if rst = '1' then
        mode <= off_c;
        dropped <= (others => '0');
        asked_1 <= '0';
        asked_2 <= '0';
        answered <= '0';
      end if;
    end if;

  end process p_fetch;

  out_state.moves <= std_ulogic_vector(moves);
  out_state.ready <= ready;
  out_state.refused <= not_taken or too_narrow;
  out_state.following <= astray;
  out_state.setpoint <= by_axis(setpoint);
  out_state.correction <= by_axis(correction);
  out_state.record_mode <= mode;
  out_state.triggered <= triggered;
  out_state.done <= done;
  out_state.record_count <= std_ulogic_vector(dropped + records);
  out_state.record_lost <= std_ulogic_vector(lost);
  out_state.fetched <= answered;
  out_state.word <= word;

end architecture rtl;
