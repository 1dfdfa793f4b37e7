-- SPDX-License-Identifier: MIT
--
-- What crosses between the clock of the registers and that of the core, as records: settings, commands and what is
-- loaded one way, state the other; and each record as one word and back. Nothing else knows where a field is in a word.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_facts_pkg.all;
  use work.gc_network_pkg.all;

package gc_system_pkg is

  subtype word_t is std_ulogic_vector(31 downto 0);

  -- Without a sign.

  subtype magnitude_t is std_ulogic_vector(30 downto 0);

  -- A bit per axis, axis 1 lowest; a word per axis, axis 1 first.

  subtype axes_t is std_ulogic_vector(axes_c - 1 downto 0);

  type axis_words_t is array (0 to axes_c - 1) of word_t;

  type axis_magnitudes_t is array (0 to axes_c - 1) of magnitude_t;

  -- What is loaded: a word of the image or, beside a command, its CRC; and which of these it is, if any.

  type load_t is record
    word        : word_t;
    is_word     : std_ulogic;
    begin_image : std_ulogic;
    commit      : std_ulogic;
    use_rom     : std_ulogic;
  end record load_t;

  constant no_load_c : load_t := ((others => '0'), '0', '0', '0', '0');

  -- One clock each in the core; clear_fault has a bit per cause.

  type commands_t is record
    start         : std_ulogic;
    kick          : std_ulogic;
    clear_encoder : std_ulogic;
    clear_fault   : causes_t;
    move          : std_ulogic;
  end record commands_t;

  constant no_commands_c : commands_t := ('0', '0', '0', no_causes_c, '0');

  -- What gc_motion has of the registers of the same names; all zero where it is not there.

  type motion_settings_t is record
    move_ticks       : word_t;
    filter           : std_ulogic_vector(3 downto 0);
    speed_feed       : std_ulogic;
    record_mode      : std_ulogic_vector(1 downto 0);
    record_mean      : std_ulogic;
    record_ticks     : std_ulogic_vector(3 downto 0);
    record_before    : std_ulogic_vector(15 downto 0);
    record_taken     : word_t;
    target           : axis_words_t;
    speed_max        : axis_words_t;
    acceleration_max : axis_words_t;
    proportional     : axis_words_t;
    integral         : axis_words_t;
    derivative       : axis_words_t;
    servo_limit      : axis_magnitudes_t;
    following_max    : axis_words_t;
  end record motion_settings_t;

  constant no_motion_settings_c : motion_settings_t :=
  (
    move_ticks       => (others => '0'),
    filter           => (others => '0'),
    speed_feed       => '0',
    record_mode      => (others => '0'),
    record_mean      => '0',
    record_ticks     => (others => '0'),
    record_before    => (others => '0'),
    record_taken     => (others => '0'),
    target           => (others => (others => '0')),
    speed_max        => (others => (others => '0')),
    acceleration_max => (others => (others => '0')),
    proportional     => (others => (others => '0')),
    integral         => (others => (others => '0')),
    derivative       => (others => (others => '0')),
    servo_limit      => (others => (others => '0')),
    following_max    => (others => (others => '0'))
  );

  -- A word of the oldest record that the host asks for, as often as turn changes.

  type fetch_t is record
    turn    : std_ulogic;
    address : std_ulogic_vector(5 downto 0);
  end record fetch_t;

  constant no_fetch_c : fetch_t := ('0', (others => '0'));

  -- Bits of settings_t that stay as the host wrote them, in words with a bit of parity each.
  constant core_held_bits_c  : positive := 2 + axes_c + 9 * 32 + (4 * 32 + 4 * 31) * axes_c;
  constant core_held_words_c : positive := (core_held_bits_c + 31) / 32;
  constant motion_bits_c     : positive := 2 * 32 + 28 + (7 * 32 + 31) * axes_c;
  constant held_bits_c       : positive := core_held_bits_c + motion_bits_c;
  constant held_words_c      : positive := (held_bits_c + 31) / 32;

  subtype held_t is std_ulogic_vector(32 * held_words_c - 1 downto 0);

  subtype parity_t is std_ulogic_vector(held_words_c - 1 downto 0);

  -- Bits of commands_t and load_t.
  constant once_bits_c : positive := 4 + causes_c + 32 + 4;

  subtype once_t is std_ulogic_vector(once_bits_c - 1 downto 0);

  type settings_t is record
    enable            : std_ulogic;
    tick_enable       : std_ulogic;
    home              : axes_t;
    tick_clocks       : word_t;
    weights           : word_t;
    saturation_clocks : word_t;
    watchdog_clocks   : word_t;
    result_clocks     : word_t;
    brake_clocks      : word_t;
    command_clocks    : word_t;
    hold_clocks       : word_t;
    brake_test_clocks : word_t;
    index_position    : axis_words_t;
    index_period      : axis_words_t;
    window_low        : axis_words_t;
    window_high       : axis_words_t;
    current_limit     : axis_magnitudes_t;
    current_slew      : axis_magnitudes_t;
    command_bound     : axis_magnitudes_t;
    period_min        : axis_magnitudes_t;
    motion            : motion_settings_t;
    commands          : commands_t;
    load              : load_t;
    -- Of held(settings), word by word; of once(commands, load).
    parity            : parity_t;
    once_parity       : std_ulogic;
    -- Nothing depends on it but what the host reads.
    fetch             : fetch_t;
  end record settings_t;

  -- Fields as the registers of the same names.

  type motion_state_t is record
    moves        : std_ulogic_vector(7 downto 0);
    ready        : std_ulogic;
    refused      : std_ulogic;
    following    : axes_t;
    setpoint     : axis_words_t;
    correction   : axis_words_t;
    record_mode  : std_ulogic_vector(1 downto 0);
    triggered    : std_ulogic;
    done         : std_ulogic;
    record_count : word_t;
    record_lost  : word_t;
    -- The turn of the fetch that word answers.
    fetched      : std_ulogic;
    word         : word_t;
  end record motion_state_t;

  constant no_motion_state_c : motion_state_t :=
  (
    moves        => (others => '0'),
    ready        => '0',
    refused      => '0',
    following    => (others => '0'),
    setpoint     => (others => (others => '0')),
    correction   => (others => (others => '0')),
    record_mode  => (others => '0'),
    triggered    => '0',
    done         => '0',
    record_count => (others => '0'),
    record_lost  => (others => '0'),
    fetched      => '0',
    word         => (others => '0')
  );

  type state_t is record
    number         : word_t;
    missed         : word_t;
    safety         : safety_state_t;
    released       : axes_t;
    run            : std_ulogic;
    feedback       : axes_t;
    busy           : std_ulogic;
    clamped        : axes_t;
    saturated      : axes_t;
    limited        : axes_t;
    reached        : axes_t;
    deviates       : axes_t;
    referenced     : axes_t;
    illegal        : axes_t;
    glitch         : axes_t;
    speed_valid    : axes_t;
    speed_zero     : axes_t;
    position       : axis_words_t;
    period         : axis_words_t;
    force_mn       : axis_words_t;
    current        : axis_words_t;
    command        : axis_words_t;
    position_now   : axis_words_t;
    cause          : causes_t;
    fault          : causes_t;
    first_cause    : causes_t;
    fault_events   : std_ulogic_vector(7 downto 0);
    first_position : axis_words_t;
    enable         : std_ulogic;
    tick_enable    : std_ulogic;
    home           : axes_t;
    load_bad       : std_ulogic;
    load_waiting   : std_ulogic;
    bank           : std_ulogic_vector(1 downto 0);
    bank_crc       : word_t;
    motion         : motion_state_t;
  end record state_t;

  -- The sums of the bits of all fields.

  subtype settings_word_t is std_ulogic_vector(
    held_bits_c + once_bits_c + held_words_c + 1 + 7 - 1 downto 0
  );

  -- That of motion stands above that of the core: turned by itself, a word costs less.
  constant core_state_bits_c   : positive := 3 * 32 + safety_state_t'length + 8 + 8 + 13 * axes_c + 7 * 32 * axes_c
                                             + 3 * causes_c;
  constant motion_state_bits_c : positive := 3 * 32 + 15 + (1 + 2 * 32) * axes_c;

  subtype core_state_word_t is std_ulogic_vector(core_state_bits_c - 1 downto 0);

  subtype motion_state_word_t is std_ulogic_vector(motion_state_bits_c - 1 downto 0);

  subtype state_word_t is std_ulogic_vector(core_state_bits_c + motion_state_bits_c - 1 downto 0);

  -- Whether it loads anything.

  function any_of (
    load : load_t
  ) return std_ulogic;

  function "or" (
    left  : commands_t;
    right : commands_t
  ) return commands_t;

  -- What is done once, side by side.

  function once (
    commands : commands_t;
    load     : load_t
  ) return once_t;

  function to_word (
    settings : settings_t
  ) return settings_word_t;

  -- The settings without commands and parity, and zeros.

  function held (
    settings : settings_t
  ) return held_t;

  function to_word (
    state : state_t
  ) return state_word_t;

  function to_settings (
    word : settings_word_t
  ) return settings_t;

  function to_state (
    word : state_word_t
  ) return state_t;

  -- Words of all axes side by side, axis 1 lowest, and back.

  subtype flat_t is signed(32 * axes_c - 1 downto 0);

  function flat (
    words : axis_words_t
  ) return flat_t;

  function by_axis (
    words : flat_t
  ) return axis_words_t;

  subtype flat_magnitudes_t is unsigned(31 * axes_c - 1 downto 0);

  function flat (
    magnitudes : axis_magnitudes_t
  ) return flat_magnitudes_t;

  -- A set of axes as a field of gc_registers, and back: there a field of one bit is no vector.

  function field_of (
    axes : axes_t
  ) return std_ulogic;

  function field_of (
    axes : axes_t
  ) return std_ulogic_vector;

  function axes_of (
    field : std_ulogic
  ) return axes_t;

  function axes_of (
    field : std_ulogic_vector
  ) return axes_t;

end package gc_system_pkg;

package body gc_system_pkg is

  -- A field changes places with the lowest bits of a word, which turns by as many: once round, word and record have
  -- changed places. One list of fields for both ways.

  procedure exchange (
    variable word  : inout std_ulogic_vector;
    variable field : inout std_ulogic_vector
  ) is

    constant low_c : std_ulogic_vector(field'length - 1 downto 0) := word(field'length - 1 downto 0);

  begin

    word := field & word(word'high downto field'length);
    field := low_c;

  end procedure exchange;

  procedure exchange (
    variable word  : inout std_ulogic_vector;
    variable field : inout std_ulogic
  ) is

    constant low_c : std_ulogic := word(0);

  begin

    word := field & word(word'high downto 1);
    field := low_c;

  end procedure exchange;

  procedure exchange (
    variable word  : inout std_ulogic_vector;
    variable field : inout axis_words_t
  ) is
  begin

    for i in axis_words_t'range loop

      exchange(word, field(i));

    end loop;

  end procedure exchange;

  procedure exchange (
    variable word  : inout std_ulogic_vector;
    variable field : inout axis_magnitudes_t
  ) is
  begin

    for i in axis_magnitudes_t'range loop

      exchange(word, field(i));

    end loop;

  end procedure exchange;

  procedure exchange (
    variable word     : inout std_ulogic_vector;
    variable commands : inout commands_t;
    variable load     : inout load_t
  ) is
  begin

    exchange(word, commands.start);
    exchange(word, commands.kick);
    exchange(word, commands.clear_encoder);
    exchange(word, commands.clear_fault);
    exchange(word, commands.move);
    exchange(word, load.word);
    exchange(word, load.is_word);
    exchange(word, load.begin_image);
    exchange(word, load.commit);
    exchange(word, load.use_rom);

  end procedure exchange;

  procedure exchange (
    variable word   : inout std_ulogic_vector;
    variable motion : inout motion_settings_t
  ) is
  begin

    exchange(word, motion.move_ticks);
    exchange(word, motion.filter);
    exchange(word, motion.speed_feed);
    exchange(word, motion.record_mode);
    exchange(word, motion.record_mean);
    exchange(word, motion.record_ticks);
    exchange(word, motion.record_before);
    exchange(word, motion.record_taken);
    exchange(word, motion.target);
    exchange(word, motion.speed_max);
    exchange(word, motion.acceleration_max);
    exchange(word, motion.proportional);
    exchange(word, motion.integral);
    exchange(word, motion.derivative);
    exchange(word, motion.servo_limit);
    exchange(word, motion.following_max);

  end procedure exchange;

  procedure exchange (
    variable word   : inout std_ulogic_vector;
    variable motion : inout motion_state_t
  ) is
  begin

    exchange(word, motion.moves);
    exchange(word, motion.ready);
    exchange(word, motion.refused);
    exchange(word, motion.following);
    exchange(word, motion.setpoint);
    exchange(word, motion.correction);
    exchange(word, motion.record_mode);
    exchange(word, motion.triggered);
    exchange(word, motion.done);
    exchange(word, motion.record_count);
    exchange(word, motion.record_lost);
    exchange(word, motion.fetched);
    exchange(word, motion.word);

  end procedure exchange;

  procedure exchange (
    variable word     : inout std_ulogic_vector;
    variable settings : inout settings_t
  ) is
  begin

    exchange(word, settings.enable);
    exchange(word, settings.tick_enable);
    exchange(word, settings.home);
    exchange(word, settings.tick_clocks);
    exchange(word, settings.weights);
    exchange(word, settings.saturation_clocks);
    exchange(word, settings.watchdog_clocks);
    exchange(word, settings.result_clocks);
    exchange(word, settings.brake_clocks);
    exchange(word, settings.command_clocks);
    exchange(word, settings.hold_clocks);
    exchange(word, settings.brake_test_clocks);
    exchange(word, settings.index_position);
    exchange(word, settings.index_period);
    exchange(word, settings.window_low);
    exchange(word, settings.window_high);
    exchange(word, settings.current_limit);
    exchange(word, settings.current_slew);
    exchange(word, settings.command_bound);
    exchange(word, settings.period_min);
    exchange(word, settings.motion);
    exchange(word, settings.commands, settings.load);
    exchange(word, settings.parity);
    exchange(word, settings.once_parity);
    exchange(word, settings.fetch.turn);
    exchange(word, settings.fetch.address);

  end procedure exchange;

  procedure exchange (
    variable word  : inout std_ulogic_vector;
    variable state : inout state_t
  ) is
  begin

    exchange(word, state.number);
    exchange(word, state.missed);
    exchange(word, state.safety);
    exchange(word, state.released);
    exchange(word, state.run);
    exchange(word, state.feedback);
    exchange(word, state.busy);
    exchange(word, state.clamped);
    exchange(word, state.saturated);
    exchange(word, state.limited);
    exchange(word, state.reached);
    exchange(word, state.deviates);
    exchange(word, state.referenced);
    exchange(word, state.illegal);
    exchange(word, state.glitch);
    exchange(word, state.speed_valid);
    exchange(word, state.speed_zero);
    exchange(word, state.position);
    exchange(word, state.period);
    exchange(word, state.force_mn);
    exchange(word, state.current);
    exchange(word, state.command);
    exchange(word, state.position_now);
    exchange(word, state.cause);
    exchange(word, state.fault);
    exchange(word, state.first_cause);
    exchange(word, state.fault_events);
    exchange(word, state.first_position);
    exchange(word, state.enable);
    exchange(word, state.tick_enable);
    exchange(word, state.home);
    exchange(word, state.load_bad);
    exchange(word, state.load_waiting);
    exchange(word, state.bank);
    exchange(word, state.bank_crc);

  end procedure exchange;

  function any_of (
    load : load_t
  ) return std_ulogic is
  begin

    return load.is_word or load.begin_image or load.commit or load.use_rom;

  end function any_of;

  function "or" (
    left  : commands_t;
    right : commands_t
  ) return commands_t is

    variable either_v : commands_t;

  begin

    either_v.start := left.start or right.start;
    either_v.kick := left.kick or right.kick;
    either_v.clear_encoder := left.clear_encoder or right.clear_encoder;
    either_v.clear_fault := left.clear_fault or right.clear_fault;
    either_v.move := left.move or right.move;

    return either_v;

  end function "or";

  function once (
    commands : commands_t;
    load     : load_t
  ) return once_t is

    variable commands_v : commands_t := commands;
    variable load_v     : load_t     := load;
    variable word_v     : once_t     := (others => '0');

  begin

    exchange(word_v, commands_v, load_v);

    return word_v;

  end function once;

  function to_word (
    settings : settings_t
  ) return settings_word_t is

    variable settings_v : settings_t      := settings;
    variable word_v     : settings_word_t := (others => '0');

  begin

    exchange(word_v, settings_v);

    return word_v;

  end function to_word;

  function held (
    settings : settings_t
  ) return held_t is

    constant word_c : settings_word_t := to_word(settings);
    variable held_v : held_t          := (others => '0');

  begin

    held_v(held_bits_c - 1 downto 0) := word_c(held_bits_c - 1 downto 0);

    return held_v;

  end function held;

  function to_word (
    state : state_t
  ) return state_word_t is

    variable state_v  : state_t             := state;
    variable word_v   : core_state_word_t   := (others => '0');
    variable motion_v : motion_state_t      := state.motion;
    variable moving_v : motion_state_word_t := (others => '0');

  begin

    exchange(word_v, state_v);
    exchange(moving_v, motion_v);

    return moving_v & word_v;

  end function to_word;

  function to_settings (
    word : settings_word_t
  ) return settings_t is

    variable settings_v : settings_t;
    variable word_v     : settings_word_t := word;

  begin

    exchange(word_v, settings_v);

    return settings_v;

  end function to_settings;

  function to_state (
    word : state_word_t
  ) return state_t is

    variable state_v  : state_t;
    variable word_v   : core_state_word_t   := word(core_state_bits_c - 1 downto 0);
    variable motion_v : motion_state_t;
    variable moving_v : motion_state_word_t := (others => '0');

  begin

    -- Bit by bit: as an initial value GHDL 2.0.0 takes a slice with its own indices.
    for i in moving_v'range loop

      moving_v(i) := word(core_state_bits_c + i);

    end loop;

    exchange(word_v, state_v);
    exchange(moving_v, motion_v);
    state_v.motion := motion_v;

    return state_v;

  end function to_state;

  function flat (
    words : axis_words_t
  ) return flat_t is

    variable flat_v : flat_t;

  begin

    for i in axis_words_t'range loop

      flat_v(32 * i + 31 downto 32 * i) := signed(words(i));

    end loop;

    return flat_v;

  end function flat;

  function by_axis (
    words : flat_t
  ) return axis_words_t is

    variable words_v : axis_words_t;

  begin

    for i in axis_words_t'range loop

      words_v(i) := std_ulogic_vector(words(32 * i + 31 downto 32 * i));

    end loop;

    return words_v;

  end function by_axis;

  function flat (
    magnitudes : axis_magnitudes_t
  ) return flat_magnitudes_t is

    variable flat_v : flat_magnitudes_t;

  begin

    for i in axis_magnitudes_t'range loop

      flat_v(31 * i + 30 downto 31 * i) := unsigned(magnitudes(i));

    end loop;

    return flat_v;

  end function flat;

  function field_of (
    axes : axes_t
  ) return std_ulogic is
  begin

    return axes(0);

  end function field_of;

  function field_of (
    axes : axes_t
  ) return std_ulogic_vector is
  begin

    return axes;

  end function field_of;

  function axes_of (
    field : std_ulogic
  ) return axes_t is
  begin

    return (0 => field, others => '0');

  end function axes_of;

  function axes_of (
    field : std_ulogic_vector
  ) return axes_t is
  begin

    return field;

  end function axes_of;

end package body gc_system_pkg;
