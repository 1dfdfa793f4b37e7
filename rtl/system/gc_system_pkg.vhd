-- SPDX-License-Identifier: MIT
--
-- What crosses between the clock of the registers and that of the core, as records: settings, commands and what is
-- loaded one way, state the other; and each record as one word and back. Nothing else knows where a field is in a word.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_facts_pkg.all;

package gc_system_pkg is

  subtype word_t is std_ulogic_vector(31 downto 0);

  -- Without a sign.

  subtype magnitude_t is std_ulogic_vector(30 downto 0);

  -- A bit per axis, axis 1 lowest; a word per axis, axis 1 first.

  subtype axes_t is std_ulogic_vector(axes_c - 1 downto 0);

  type axis_words_t is array (0 to axes_c - 1) of word_t;

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
  end record commands_t;

  constant no_commands_c : commands_t := ('0', '0', '0', no_causes_c);

  -- Bits of settings_t that stay as the host wrote them, in words with a bit of parity each.
  constant held_bits_c  : positive := 2 + axes_c + 9 * 32 + 4 * 31 + 4 * 32 * axes_c;
  constant held_words_c : positive := (held_bits_c + 31) / 32;

  subtype held_t is std_ulogic_vector(32 * held_words_c - 1 downto 0);

  subtype parity_t is std_ulogic_vector(held_words_c - 1 downto 0);

  -- Bits of commands_t and load_t.
  constant once_bits_c : positive := 3 + causes_c + 32 + 4;

  subtype once_t is std_ulogic_vector(once_bits_c - 1 downto 0);

  type settings_t is record
    enable            : std_ulogic;
    tick_enable       : std_ulogic;
    home              : axes_t;
    tick_clocks       : word_t;
    weights           : word_t;
    current_limit     : magnitude_t;
    current_slew      : magnitude_t;
    period_min        : magnitude_t;
    saturation_clocks : word_t;
    watchdog_clocks   : word_t;
    result_clocks     : word_t;
    brake_clocks      : word_t;
    command_bound     : magnitude_t;
    command_clocks    : word_t;
    hold_clocks       : word_t;
    brake_test_clocks : word_t;
    index_position    : axis_words_t;
    index_period      : axis_words_t;
    window_low        : axis_words_t;
    window_high       : axis_words_t;
    commands          : commands_t;
    load              : load_t;
    -- Of held(settings), word by word; of once(commands, load).
    parity            : parity_t;
    once_parity       : std_ulogic;
  end record settings_t;

  -- Fields as the registers of the same names.

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
  end record state_t;

  -- The sums of the bits of all fields.

  subtype settings_word_t is std_ulogic_vector(
    held_bits_c + once_bits_c + held_words_c + 1 - 1 downto 0
  );

  subtype state_word_t is std_ulogic_vector(
    3 * 32 + safety_state_t'length + 8 + 8 + 13 * axes_c + 7 * 32 * axes_c + 3 * causes_c - 1 downto 0
  );

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

end package gc_system_pkg;

package body gc_system_pkg is

  -- A field into a word from above, and out of it from below: whole fields, in the same order, find their places again.

  procedure put (
    variable word : inout std_ulogic_vector;
    field         : std_ulogic
  ) is
  begin

    word := field & word(word'high downto 1);

  end procedure put;

  procedure put (
    variable word : inout std_ulogic_vector;
    field         : std_ulogic_vector
  ) is
  begin

    word := field & word(word'high downto field'length);

  end procedure put;

  procedure put (
    variable word : inout std_ulogic_vector;
    field         : axis_words_t
  ) is
  begin

    for i in axis_words_t'range loop

      put(word, field(i));

    end loop;

  end procedure put;

  procedure take (
    variable word  : inout std_ulogic_vector;
    variable field : out std_ulogic
  ) is
  begin

    field := word(0);
    word := '0' & word(word'high downto 1);

  end procedure take;

  procedure take (
    variable word  : inout std_ulogic_vector;
    variable field : out std_ulogic_vector
  ) is

    constant none_c : std_ulogic_vector(field'length - 1 downto 0) := (others => '0');

  begin

    field := word(field'length - 1 downto 0);
    word := none_c & word(word'high downto field'length);

  end procedure take;

  procedure take (
    variable word  : inout std_ulogic_vector;
    variable field : out axis_words_t
  ) is
  begin

    for i in axis_words_t'range loop

      take(word, field(i));

    end loop;

  end procedure take;

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

    return either_v;

  end function "or";

  function once (
    commands : commands_t;
    load     : load_t
  ) return once_t is

    variable word_v : once_t := (others => '0');

  begin

    put(word_v, commands.start);
    put(word_v, commands.kick);
    put(word_v, commands.clear_encoder);
    put(word_v, commands.clear_fault);
    put(word_v, load.word);
    put(word_v, load.is_word);
    put(word_v, load.begin_image);
    put(word_v, load.commit);
    put(word_v, load.use_rom);

    return word_v;

  end function once;

  function to_word (
    settings : settings_t
  ) return settings_word_t is

    variable word_v : settings_word_t := (others => '0');

  begin

    put(word_v, settings.enable);
    put(word_v, settings.tick_enable);
    put(word_v, settings.home);
    put(word_v, settings.tick_clocks);
    put(word_v, settings.weights);
    put(word_v, settings.current_limit);
    put(word_v, settings.current_slew);
    put(word_v, settings.period_min);
    put(word_v, settings.saturation_clocks);
    put(word_v, settings.watchdog_clocks);
    put(word_v, settings.result_clocks);
    put(word_v, settings.brake_clocks);
    put(word_v, settings.command_bound);
    put(word_v, settings.command_clocks);
    put(word_v, settings.hold_clocks);
    put(word_v, settings.brake_test_clocks);
    put(word_v, settings.index_position);
    put(word_v, settings.index_period);
    put(word_v, settings.window_low);
    put(word_v, settings.window_high);
    put(word_v, once(settings.commands, settings.load));
    put(word_v, settings.parity);
    put(word_v, settings.once_parity);

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

    variable word_v : state_word_t := (others => '0');

  begin

    put(word_v, state.number);
    put(word_v, state.missed);
    put(word_v, state.safety);
    put(word_v, state.released);
    put(word_v, state.run);
    put(word_v, state.feedback);
    put(word_v, state.busy);
    put(word_v, state.clamped);
    put(word_v, state.saturated);
    put(word_v, state.limited);
    put(word_v, state.reached);
    put(word_v, state.deviates);
    put(word_v, state.referenced);
    put(word_v, state.illegal);
    put(word_v, state.glitch);
    put(word_v, state.speed_valid);
    put(word_v, state.speed_zero);
    put(word_v, state.position);
    put(word_v, state.period);
    put(word_v, state.force_mn);
    put(word_v, state.current);
    put(word_v, state.command);
    put(word_v, state.position_now);
    put(word_v, state.cause);
    put(word_v, state.fault);
    put(word_v, state.first_cause);
    put(word_v, state.fault_events);
    put(word_v, state.first_position);
    put(word_v, state.enable);
    put(word_v, state.tick_enable);
    put(word_v, state.home);
    put(word_v, state.load_bad);
    put(word_v, state.load_waiting);
    put(word_v, state.bank);
    put(word_v, state.bank_crc);

    return word_v;

  end function to_word;

  function to_settings (
    word : settings_word_t
  ) return settings_t is

    variable left_v   : settings_word_t;
    variable fields_v : settings_t;

  begin

    left_v := word;
    take(left_v, fields_v.enable);
    take(left_v, fields_v.tick_enable);
    take(left_v, fields_v.home);
    take(left_v, fields_v.tick_clocks);
    take(left_v, fields_v.weights);
    take(left_v, fields_v.current_limit);
    take(left_v, fields_v.current_slew);
    take(left_v, fields_v.period_min);
    take(left_v, fields_v.saturation_clocks);
    take(left_v, fields_v.watchdog_clocks);
    take(left_v, fields_v.result_clocks);
    take(left_v, fields_v.brake_clocks);
    take(left_v, fields_v.command_bound);
    take(left_v, fields_v.command_clocks);
    take(left_v, fields_v.hold_clocks);
    take(left_v, fields_v.brake_test_clocks);
    take(left_v, fields_v.index_position);
    take(left_v, fields_v.index_period);
    take(left_v, fields_v.window_low);
    take(left_v, fields_v.window_high);
    take(left_v, fields_v.commands.start);
    take(left_v, fields_v.commands.kick);
    take(left_v, fields_v.commands.clear_encoder);
    take(left_v, fields_v.commands.clear_fault);
    take(left_v, fields_v.load.word);
    take(left_v, fields_v.load.is_word);
    take(left_v, fields_v.load.begin_image);
    take(left_v, fields_v.load.commit);
    take(left_v, fields_v.load.use_rom);
    take(left_v, fields_v.parity);
    take(left_v, fields_v.once_parity);

    return fields_v;

  end function to_settings;

  function to_state (
    word : state_word_t
  ) return state_t is

    variable left_v   : state_word_t;
    variable fields_v : state_t;

  begin

    left_v := word;
    take(left_v, fields_v.number);
    take(left_v, fields_v.missed);
    take(left_v, fields_v.safety);
    take(left_v, fields_v.released);
    take(left_v, fields_v.run);
    take(left_v, fields_v.feedback);
    take(left_v, fields_v.busy);
    take(left_v, fields_v.clamped);
    take(left_v, fields_v.saturated);
    take(left_v, fields_v.limited);
    take(left_v, fields_v.reached);
    take(left_v, fields_v.deviates);
    take(left_v, fields_v.referenced);
    take(left_v, fields_v.illegal);
    take(left_v, fields_v.glitch);
    take(left_v, fields_v.speed_valid);
    take(left_v, fields_v.speed_zero);
    take(left_v, fields_v.position);
    take(left_v, fields_v.period);
    take(left_v, fields_v.force_mn);
    take(left_v, fields_v.current);
    take(left_v, fields_v.command);
    take(left_v, fields_v.position_now);
    take(left_v, fields_v.cause);
    take(left_v, fields_v.fault);
    take(left_v, fields_v.first_cause);
    take(left_v, fields_v.fault_events);
    take(left_v, fields_v.first_position);
    take(left_v, fields_v.enable);
    take(left_v, fields_v.tick_enable);
    take(left_v, fields_v.home);
    take(left_v, fields_v.load_bad);
    take(left_v, fields_v.load_waiting);
    take(left_v, fields_v.bank);
    take(left_v, fields_v.bank_crc);

    return fields_v;

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

end package body gc_system_pkg;
