-- SPDX-License-Identifier: MIT
--
-- The records of gc_system_pkg to words and back, for the simulator. Every field has a value of its own.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_facts_pkg.all;
  use work.gc_network_pkg.all;
  use work.gc_system_pkg.all;

entity gc_words_bench is
  port (
    -- Bit of each word to invert; none when it is beyond the word.
    flip              : in    natural;
    settings_bits     : out   natural;
    state_bits        : out   natural;
    -- The record that comes back is the one that went.
    settings_equal    : out   std_ulogic;
    state_equal       : out   std_ulogic;
    -- So is the word, with its inverted bit.
    settings_reversed : out   std_ulogic;
    state_reversed    : out   std_ulogic
  );
end entity gc_words_bench;

architecture sim of gc_words_bench is

  -- A value of its own for every field, from a number of its own: the bits of a multiple of the golden ratio.

  function value (
    number : natural;
    bits   : positive
  ) return std_ulogic_vector is

    variable all_v : unsigned(63 downto 0);

  begin

    all_v := to_unsigned(number, 32) * x"9E3779B9";

    return std_ulogic_vector(all_v(bits - 1 downto 0));

  end function value;

  function axis_values (
    number : natural
  ) return axis_words_t is

    variable words_v : axis_words_t;

  begin

    for i in axis_words_t'range loop

      words_v(i) := value(number + 100 * i, 32);

    end loop;

    return words_v;

  end function axis_values;

  function axis_magnitudes (
    number : natural
  ) return axis_magnitudes_t is

    variable magnitudes_v : axis_magnitudes_t;

  begin

    for i in axis_magnitudes_t'range loop

      magnitudes_v(i) := value(number + 100 * i, 31);

    end loop;

    return magnitudes_v;

  end function axis_magnitudes;

  constant commands_c : commands_t :=
  (
    start         => '1',
    kick          => '0',
    clear_encoder => '1',
    clear_fault   => value(1, causes_c),
    move          => '1'
  );

  constant load_c : load_t :=
  (
    word        => value(40, 32),
    is_word     => '1',
    begin_image => '0',
    commit      => '1',
    use_rom     => '0'
  );

  constant motion_settings_c : motion_settings_t :=
  (
    move_ticks       => value(62, 32),
    filter           => value(63, 4),
    speed_feed       => '1',
    record_mode      => value(64, 2),
    record_mean      => '1',
    record_ticks     => value(65, 4),
    record_before    => value(66, 16),
    record_taken     => value(67, 32),
    target           => axis_values(68),
    speed_max        => axis_values(69),
    acceleration_max => axis_values(70),
    proportional     => axis_values(71),
    integral         => axis_values(72),
    derivative       => axis_values(73),
    servo_limit      => axis_magnitudes(74),
    following_max    => axis_values(75)
  );

  constant motion_state_c : motion_state_t :=
  (
    moves        => value(76, 8),
    ready        => '1',
    refused      => '0',
    following    => value(77, axes_c),
    setpoint     => axis_values(78),
    correction   => axis_values(79),
    record_mode  => value(80, 2),
    triggered    => '1',
    done         => '0',
    record_count => value(81, 32),
    record_lost  => value(82, 32),
    fetched      => '1',
    word         => value(83, 32)
  );

  constant settings_c : settings_t :=
  (
    enable            => '1',
    tick_enable       => '0',
    home              => value(51, axes_c),
    tick_clocks       => value(2, 32),
    weights           => value(3, 32),
    saturation_clocks => value(7, 32),
    watchdog_clocks   => value(8, 32),
    result_clocks     => value(9, 32),
    brake_clocks      => value(10, 32),
    command_clocks    => value(15, 32),
    hold_clocks       => value(16, 32),
    brake_test_clocks => value(17, 32),
    index_position    => axis_values(11),
    index_period      => axis_values(17),
    window_low        => axis_values(12),
    window_high       => axis_values(13),
    current_limit     => axis_magnitudes(4),
    current_slew      => axis_magnitudes(5),
    command_bound     => axis_magnitudes(6),
    period_min        => axis_magnitudes(14),
    motion            => motion_settings_c,
    commands          => commands_c,
    load              => load_c,
    parity            => value(18, held_words_c),
    once_parity       => '1',
    fetch             => ('1', value(84, 6))
  );

  constant state_c : state_t :=
  (
    number         => value(20, 32),
    missed         => value(21, 32),
    safety         => state_run_c,
    released       => value(52, axes_c),
    run            => '1',
    feedback       => value(53, axes_c),
    busy           => '0',
    clamped        => value(54, axes_c),
    saturated      => value(55, axes_c),
    limited        => value(56, axes_c),
    reached        => value(57, axes_c),
    deviates       => value(58, axes_c),
    referenced     => value(59, axes_c),
    illegal        => value(60, axes_c),
    glitch         => value(61, axes_c),
    speed_valid    => value(62, axes_c),
    speed_zero     => value(63, axes_c),
    position       => axis_values(22),
    period         => axis_values(23),
    force_mn       => axis_values(24),
    current        => axis_values(25),
    command        => axis_values(26),
    position_now   => axis_values(27),
    cause          => value(28, causes_c),
    fault          => value(29, causes_c),
    first_cause    => value(30, causes_c),
    fault_events   => value(33, 8),
    first_position => axis_values(31),
    enable         => '1',
    tick_enable    => '0',
    home           => value(64, axes_c),
    load_bad       => '1',
    load_waiting   => '0',
    bank           => "10",
    bank_crc       => value(32, 32),
    motion         => motion_state_c
  );

  function flipped (
    word : std_ulogic_vector;
    k    : natural
  ) return std_ulogic_vector is

    variable word_v : std_ulogic_vector(word'length - 1 downto 0);

  begin

    word_v := word;

    if k < word'length then
      word_v(k) := not word_v(k);
    end if;

    return word_v;

  end function flipped;

  signal settings : settings_word_t;
  signal state    : state_word_t;

begin

  settings <= flipped(to_word(settings_c), flip);
  state <= flipped(to_word(state_c), flip);

  settings_bits <= settings'length;
  state_bits <= state'length;

  settings_equal <= '1' when to_settings(settings) = settings_c else '0';
  state_equal <= '1' when to_state(state) = state_c else '0';

  settings_reversed <= '1' when to_word(to_settings(settings)) = settings else '0';
  state_reversed <= '1' when to_word(to_state(state)) = state else '0';

end architecture sim;
