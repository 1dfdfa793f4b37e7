-- SPDX-License-Identifier: MIT
--
-- The core's side of gc_system, all in one clock: tick, gc_force_path, gc_motion if wanted, drive and safety.
--
-- One inference at a time: a tick or a start that finds one under way is not taken; a tick is then counted as missed.
-- State tells of results only whole ones: position and speed are those
-- of the clock that started the inference, shown together with its forces.
-- Latency from start to drive_current: those of gc_force_path, gc_motion and gc_drive; to the state 1 clock after
-- gc_force_path.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_encoder_pkg.all;
  use work.gc_facts_pkg.all;
  use work.gc_network_pkg.all;
  use work.gc_safety_pkg.all;
  use work.gc_system_pkg.all;

entity gc_core_side is
  generic (
    -- See gc_force_path. None has a default here: what is not handed on does not compile.
    lanes_g           : positive;
    filter_samples_g  : natural;
    speed_timeout_g   : positive;
    reversal_clocks_g : positive;
    dither_clocks_g   : positive;
    loadable_g        : boolean;
    -- See gc_safety; guard_g also: whether the parity of the settings is checked.
    two_paths_g       : boolean;
    brake_feedback_g  : boolean;
    brake_test_g      : boolean;
    guard_g           : boolean;
    -- Whether there is gc_motion, and words of its recorder's ring, as a power of two.
    motion_g          : boolean;
    record_bits_g     : positive
  );
  port (
    clk           : in    std_ulogic;
    -- Synchronous, active high.
    rst           : in    std_ulogic;
    -- Encoder pins and emergency stop, asynchronous; axis 1 lowest. pin_error = '1': the others cannot be trusted.
    -- estop_n = '0' stops.
    pin_a         : in    std_ulogic_vector(axes_c - 1 downto 0);
    pin_b         : in    std_ulogic_vector(axes_c - 1 downto 0);
    pin_z         : in    std_ulogic_vector(axes_c - 1 downto 0);
    pin_error     : in    std_ulogic_vector(axes_c - 1 downto 0) := (others => '0');
    estop_n       : in    std_ulogic;
    -- Read-back of the brakes, asynchronous; '1': fed, released. Only with brake_feedback_g.
    brake_fed     : in    std_ulogic_vector(axes_c - 1 downto 0);
    -- One clock per measured current, and the currents, uA, axis 1 lowest. Only with motion_g.
    sense_valid   : in    std_ulogic_vector(axes_c - 1 downto 0);
    sense_current : in    signed(axes_c * current_bits_c - 1 downto 0);
    -- The host's clock stands, or this one stood.
    in_clock_bad  : in    std_ulogic;
    -- What this puts out is not what its copy does.
    in_core_bad   : in    std_ulogic;
    -- Settings; their commands and loads count only with in_valid.
    in_valid      : in    std_ulogic;
    in_settings   : in    settings_t;
    -- Current commands, uA, axis 1 lowest: one clock per new command.
    drive_valid   : out   std_ulogic;
    drive_current : out   signed(axes_c * current_bits_c - 1 downto 0);
    -- '0': commands are zero.
    drive_enable  : out   std_ulogic;
    -- '1' releases the brake of the axis.
    brake_release : out   std_ulogic_vector(axes_c - 1 downto 0);
    -- '1' engages it.
    brake_engage  : out   std_ulogic_vector(axes_c - 1 downto 0);
    -- State is whole, and taken if wanted.
    out_valid     : out   std_ulogic;
    out_state     : out   state_t
  );
end entity gc_core_side;

architecture rtl of gc_core_side is

  signal index_position : flat_t;
  signal index_period   : flat_t;
  signal window_low     : flat_t;
  signal window_high    : flat_t;
  signal current_limit  : flat_magnitudes_t;
  signal current_slew   : flat_magnitudes_t;
  signal command_bound  : flat_magnitudes_t;
  signal period_min     : flat_magnitudes_t;
  signal start          : std_ulogic;
  signal kick           : std_ulogic;
  signal clear_encoder  : std_ulogic;
  signal clear_fault    : causes_t;
  signal load_begin     : std_ulogic;
  signal load_valid     : std_ulogic;
  signal load_commit    : std_ulogic;
  signal load_rom       : std_ulogic;

  signal tick      : std_ulogic;
  signal missed    : unsigned(31 downto 0);
  signal top_ready : std_ulogic;
  signal idle      : std_ulogic;
  signal begins    : std_ulogic;
  signal busy      : std_ulogic := '0';

  signal path_valid    : std_ulogic;
  signal force_mn      : signed(axes_c * force_bits_c - 1 downto 0);
  signal current       : signed(axes_c * current_bits_c - 1 downto 0);
  signal clamped       : axes_t;
  signal saturated     : axes_t;
  signal clipped       : axes_t;
  signal count         : signed(axes_c * count_bits_c - 1 downto 0);
  signal period        : signed(axes_c * 32 - 1 downto 0);
  signal speed_valid   : axes_t;
  signal speed_zero    : axes_t;
  signal referenced    : axes_t;
  signal illegal       : axes_t;
  signal glitch        : axes_t;
  signal start_count   : signed(axes_c * count_bits_c - 1 downto 0);
  signal start_period  : signed(axes_c * 32 - 1 downto 0);
  signal result_count  : signed(axes_c * count_bits_c - 1 downto 0) := (others => '0');
  signal result_period : signed(axes_c * 32 - 1 downto 0) := (others => '0');
  signal result_force  : signed(axes_c * 32 - 1 downto 0);
  signal number        : unsigned(31 downto 0) := (others => '0');

  signal asked_valid   : std_ulogic;
  signal asked_current : signed(axes_c * current_bits_c - 1 downto 0);
  signal astray        : axes_t;
  signal motion_busy   : std_ulogic;

  signal run          : std_ulogic;
  signal released     : axes_t;
  signal engaged      : axes_t;
  signal feedback     : axes_t;
  signal held_words   : held_t;
  signal setting_bad  : std_ulogic;
  signal command      : signed(axes_c * current_bits_c - 1 downto 0);
  signal limited      : axes_t;
  signal reached      : axes_t;
  signal deviates     : axes_t;
  signal load_bad     : std_ulogic;
  signal load_waiting : std_ulogic;
  signal bank         : std_ulogic_vector(1 downto 0);
  signal bank_crc     : word_t;
  signal rom_bad      : std_ulogic := '0';
  signal safety_state : safety_state_t;
  signal cause        : causes_t;
  signal fault        : causes_t;
  signal first_cause  : causes_t;
  signal fault_events : unsigned(7 downto 0);
  signal first_count  : signed(axes_c * count_bits_c - 1 downto 0);
  signal control      : std_ulogic_vector(axes_c + 1 downto 0);
  signal control_4    : std_ulogic_vector(axes_c + 1 downto 0);

begin

  index_position <= flat(in_settings.index_position);
  index_period <= flat(in_settings.index_period);
  window_low <= flat(in_settings.window_low);
  window_high <= flat(in_settings.window_high);
  current_limit <= flat(in_settings.current_limit);
  current_slew <= flat(in_settings.current_slew);
  command_bound <= flat(in_settings.command_bound);
  period_min <= flat(in_settings.period_min);

  -- A command counts once, in the clock in which it comes.
  start <= in_settings.commands.start and in_valid;
  kick <= in_settings.commands.kick and in_valid;
  clear_encoder <= in_settings.commands.clear_encoder and in_valid;
  clear_fault <= in_settings.commands.clear_fault when in_valid = '1' else no_causes_c;
  load_begin <= in_settings.load.begin_image and in_valid;
  load_valid <= in_settings.load.is_word and in_valid;
  load_commit <= in_settings.load.commit and in_valid;
  load_rom <= in_settings.load.use_rom and in_valid;

  i_tick : entity work.gc_tick
    port map (
      clk        => clk,
      rst        => rst,
      cfg_enable => in_settings.tick_enable,
      cfg_clocks => unsigned(in_settings.tick_clocks),
      in_ready   => idle,
      out_valid  => tick,
      sts_missed => missed
    );

  idle <= top_ready and not busy and not motion_busy;
  begins <= (tick or start) and idle;

  i_force_path : entity work.gc_force_path
    generic map (
      lanes_g           => lanes_g,
      filter_samples_g  => filter_samples_g,
      speed_timeout_g   => speed_timeout_g,
      reversal_clocks_g => reversal_clocks_g,
      dither_clocks_g   => dither_clocks_g,
      loadable_g        => loadable_g
    )
    port map (
      clk                => clk,
      rst                => rst,
      pin_a              => pin_a,
      pin_b              => pin_b,
      pin_z              => pin_z,
      pin_error          => pin_error,
      cfg_home_enable    => in_settings.home,
      cfg_index_position => index_position,
      cfg_index_period   => unsigned(index_period),
      cfg_clear          => clear_encoder,
      in_valid           => begins,
      in_ready           => top_ready,
      out_valid          => path_valid,
      out_force          => force_mn,
      out_current        => current,
      out_clamped        => clamped,
      out_saturated      => saturated,
      sts_count          => count,
      sts_direction      => open,
      sts_speed_period   => period,
      sts_speed_valid    => speed_valid,
      sts_speed_zero     => speed_zero,
      sts_referenced     => referenced,
      sts_illegal        => illegal,
      sts_glitch         => glitch,
      load_begin         => load_begin,
      load_valid         => load_valid,
      load_word          => in_settings.load.word,
      load_commit        => load_commit,
      load_crc           => in_settings.load.word,
      load_rom           => load_rom,
      sts_load_bad       => load_bad,
      sts_load_waiting   => load_waiting,
      sts_bank           => bank,
      sts_bank_crc       => bank_crc
    );

  p_results : process (clk) is
  begin

    if rising_edge(clk) then
      if begins = '1' then
        busy <= '1';
        start_count <= count;
        start_period <= period;
      end if;
      -- one clock after gc_force_path, whose outputs hold
      if path_valid = '1' then
        busy <= '0';
        number <= number + 1;
        result_count <= start_count;
        result_period <= start_period;
      end if;
      rom_bad <= '0';
      if bank = "00" and in_settings.weights /= weights_hash_c(weights_hash_c'high downto weights_hash_c'high - 31) then
        rom_bad <= '1';
      end if;
      if rst = '1' then
        busy <= '0';
        number <= (others => '0');
        result_count <= (others => '0');
        result_period <= (others => '0');
      end if;
    end if;

  end process p_results;

  -- Every force comes from all counts.
  clipped <= (others => '1') when clamped /= (clamped'range => '0') else saturated;

  g_motion : if motion_g generate
    signal released_all : std_ulogic;
    signal any_fault    : std_ulogic;
    signal ticks        : unsigned(31 downto 0);
    signal status       : std_ulogic_vector(29 downto 0);
    signal move         : std_ulogic;
  begin
    released_all <= '1' when safety_state = state_run_c else '0';
    any_fault <= '1' when fault /= no_causes_c else '0';
    ticks <= number + missed;
    status <= std_ulogic_vector(resize(unsigned(fault), 26)) & run & safety_state;
    move <= in_settings.commands.move and in_valid;

    i_motion : entity work.gc_motion
      generic map (
        record_bits_g => record_bits_g
      )
      port map (
        clk           => clk,
        rst           => rst,
        run           => run,
        released      => released_all,
        in_settings   => in_settings.motion,
        in_move       => move,
        in_fetch      => in_settings.fetch,
        in_begins     => begins,
        in_count      => count,
        in_valid      => path_valid,
        in_current    => current,
        in_position   => result_count,
        in_period     => result_period,
        in_force      => result_force,
        in_command    => command,
        in_tick       => ticks,
        in_status     => status,
        in_fault      => any_fault,
        sense_valid   => sense_valid,
        sense_current => sense_current,
        out_valid     => asked_valid,
        out_current   => asked_current,
        out_astray    => astray,
        out_busy      => motion_busy,
        out_state     => out_state.motion
      );

  else generate
    asked_valid <= path_valid;
    asked_current <= current;
    astray <= (others => '0');
    motion_busy <= '0';
    out_state.motion <= no_motion_state_c;
  end generate g_motion;

  i_drive : entity work.gc_drive
    port map (
      clk          => clk,
      rst          => rst,
      run          => run,
      in_valid     => asked_valid,
      in_current   => asked_current,
      in_clipped   => clipped,
      cfg_limit    => current_limit,
      cfg_slew     => current_slew,
      cfg_bound    => command_bound,
      out_valid    => drive_valid,
      out_current  => command,
      out_limited  => limited,
      out_reached  => reached,
      out_deviates => deviates
    );

  held_words <= held(in_settings);

  g_guard : if guard_g generate
    signal bad      : parity_t;
    signal once_bad : std_ulogic;
  begin

    g_word : for i in bad'range generate
      bad(i) <= in_settings.parity(i) xor parity_of(held_words(32 * i + 31 downto 32 * i));
    end generate g_word;

    once_bad <= in_settings.once_parity xor parity_of(once(in_settings.commands, in_settings.load));

    setting_bad <= '1' when unsigned(bad) /= 0 or once_bad = '1' else '0';
  else generate
    setting_bad <= '0';
  end generate g_guard;

  i_safety : entity work.gc_safety
    generic map (
      period_shortest_g => shortest_period(filter_samples_g),
      two_paths_g       => two_paths_g,
      brake_feedback_g  => brake_feedback_g,
      brake_test_g      => brake_test_g,
      guard_g           => guard_g
    )
    port map (
      clk                   => clk,
      rst                   => rst,
      estop_n               => estop_n,
      enable                => in_settings.enable,
      clear                 => clear_fault,
      kick                  => kick,
      in_count              => count,
      in_period             => period,
      in_referenced         => referenced,
      in_illegal            => illegal,
      in_result             => path_valid,
      in_clamped            => clamped,
      in_saturated          => saturated,
      in_reached            => reached,
      in_deviates           => deviates,
      in_crc_bad            => load_bad,
      in_rom_bad            => rom_bad,
      in_clock_bad          => in_clock_bad,
      in_core_bad           => in_core_bad,
      in_upset              => setting_bad,
      in_astray             => astray,
      brake_fed             => brake_fed,
      cfg_count_low         => window_low,
      cfg_count_high        => window_high,
      cfg_period_min        => period_min,
      cfg_saturation_clocks => unsigned(in_settings.saturation_clocks),
      cfg_watchdog_clocks   => unsigned(in_settings.watchdog_clocks),
      cfg_result_clocks     => unsigned(in_settings.result_clocks),
      cfg_command_clocks    => unsigned(in_settings.command_clocks),
      cfg_hold_clocks       => unsigned(in_settings.hold_clocks),
      cfg_brake_clocks      => unsigned(in_settings.brake_clocks),
      cfg_test_clocks       => unsigned(in_settings.brake_test_clocks),
      run                   => run,
      brake_release         => released,
      brake_engage          => engaged,
      sts_feedback          => feedback,
      sts_state             => safety_state,
      sts_present           => cause,
      sts_fault             => fault,
      sts_first_cause       => first_cause,
      sts_first_count       => first_count,
      sts_events            => fault_events
    );

  drive_current <= command;
  drive_enable <= run;
  brake_release <= released;
  brake_engage <= engaged;

  -- Late enough that the rest of the state shows what it did.
  control <= in_settings.home & in_settings.tick_enable & in_settings.enable;

  i_control : entity work.gc_delay
    generic map (
      bits_g   => control'length,
      clocks_g => 4
    )
    port map (
      clk      => clk,
      in_data  => control,
      out_data => control_4
    );

  g_force : for i in 0 to axes_c - 1 generate
    result_force(32 * i + 31 downto 32 * i) <= resize(force_mn((i + 1) * force_bits_c - 1 downto i * force_bits_c), 32);
  end generate g_force;

  out_state.number <= std_ulogic_vector(number);
  out_state.missed <= std_ulogic_vector(missed);
  out_state.safety <= safety_state;
  out_state.released <= released and not engaged;
  out_state.run <= run;
  out_state.feedback <= feedback;
  out_state.busy <= busy;
  out_state.clamped <= clamped;
  out_state.saturated <= saturated;
  out_state.limited <= limited;
  out_state.reached <= reached;
  out_state.deviates <= deviates;
  out_state.referenced <= referenced;
  out_state.illegal <= illegal;
  out_state.glitch <= glitch;
  out_state.speed_valid <= speed_valid;
  out_state.speed_zero <= speed_zero;
  out_state.position <= by_axis(result_count);
  out_state.period <= by_axis(result_period);
  out_state.force_mn <= by_axis(result_force);
  out_state.current <= by_axis(current);
  out_state.command <= by_axis(command);
  out_state.position_now <= by_axis(count);
  out_state.cause <= cause;
  out_state.fault <= fault;
  out_state.first_cause <= first_cause;
  out_state.fault_events <= std_ulogic_vector(fault_events);
  out_state.first_position <= by_axis(first_count);
  out_state.enable <= control_4(0);
  out_state.tick_enable <= control_4(1);
  out_state.home <= control_4(control_4'high downto 2);
  out_state.load_bad <= load_bad;
  out_state.load_waiting <= load_waiting;
  out_state.bank <= bank;
  out_state.bank_crc <= bank_crc;

  -- In the clock of path_valid the forces are already those of the next number.
  out_valid <= not path_valid;

end architecture rtl;
