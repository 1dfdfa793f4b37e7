-- SPDX-License-Identifier: MIT
--
-- The core's side of gc_system, all in one clock: tick, gc_force_path, drive and safety.
--
-- One inference at a time: a tick or a start that finds one under way is not taken; a tick is then counted as missed.
-- Settings and state are words of gc_system_pkg. State tells of results only whole ones: position and speed are those
-- of the clock that started the inference, shown together with its forces.
-- Latency from start to drive_current: those of gc_force_path and gc_drive; to the state 1 clock after gc_force_path.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_network_pkg.all;
  use work.gc_safety_pkg.all;
  use work.gc_system_pkg.all;

entity gc_core_side is
  generic (
    -- See gc_force_path.
    lanes_g          : positive := 4;
    filter_samples_g : natural := 4;
    speed_timeout_g  : positive := 10_000_000;
    loadable_g       : boolean := false
  );
  port (
    clk           : in    std_ulogic;
    -- Synchronous, active high.
    rst           : in    std_ulogic;
    -- Encoder pins and emergency stop, asynchronous; axis 1 lowest. estop_n = '0' stops.
    pin_a         : in    std_ulogic_vector(inputs_c - 1 downto 0);
    pin_b         : in    std_ulogic_vector(inputs_c - 1 downto 0);
    pin_z         : in    std_ulogic_vector(inputs_c - 1 downto 0);
    estop_n       : in    std_ulogic;
    -- Settings; their command bits count only with in_valid.
    in_valid      : in    std_ulogic;
    in_settings   : in    settings_t;
    -- What is loaded, one clock each.
    in_load_valid : in    std_ulogic;
    in_load       : in    load_t;
    -- Current commands, uA, axis 1 lowest: one clock per new command.
    drive_valid   : out   std_ulogic;
    drive_current : out   signed(outputs_c * current_bits_c - 1 downto 0);
    -- '0': commands are zero.
    drive_enable  : out   std_ulogic;
    -- '1' releases the brake of the axis.
    brake_release : out   std_ulogic_vector(inputs_c - 1 downto 0);
    -- State is whole, and taken if wanted.
    out_valid     : out   std_ulogic;
    out_state     : out   state_t
  );
end entity gc_core_side;

architecture rtl of gc_core_side is

  subtype axes_t is std_ulogic_vector(axes_c - 1 downto 0);

  signal pulses        : word_t;
  signal load          : load_t;
  signal start         : std_ulogic;
  signal kick          : std_ulogic;
  signal clear_fault   : causes_t;
  signal clear_encoder : std_ulogic;

  signal tick      : std_ulogic;
  signal missed    : unsigned(31 downto 0);
  signal top_ready : std_ulogic;
  signal idle      : std_ulogic;
  signal begins    : std_ulogic;
  signal busy      : std_ulogic := '0';

  signal path_valid    : std_ulogic;
  signal force_mn      : signed(outputs_c * force_bits_c - 1 downto 0);
  signal current       : signed(outputs_c * current_bits_c - 1 downto 0);
  signal clamped       : axes_t;
  signal saturated     : axes_t;
  signal count         : signed(inputs_c * count_bits_c - 1 downto 0);
  signal period        : signed(inputs_c * 32 - 1 downto 0);
  signal speed_valid   : axes_t;
  signal speed_zero    : axes_t;
  signal referenced    : axes_t;
  signal illegal       : axes_t;
  signal glitch        : axes_t;
  signal start_count   : signed(inputs_c * count_bits_c - 1 downto 0);
  signal start_period  : signed(inputs_c * 32 - 1 downto 0);
  signal result_count  : signed(inputs_c * count_bits_c - 1 downto 0) := (others => '0');
  signal result_period : signed(inputs_c * 32 - 1 downto 0) := (others => '0');
  signal result_force  : signed(outputs_c * 32 - 1 downto 0);
  signal number        : unsigned(31 downto 0) := (others => '0');

  signal run          : std_ulogic;
  signal released     : axes_t;
  signal command      : signed(outputs_c * current_bits_c - 1 downto 0);
  signal limited      : axes_t;
  signal settled      : axes_t;
  signal load_bad     : std_ulogic;
  signal load_waiting : std_ulogic;
  signal bank         : std_ulogic_vector(1 downto 0);
  signal bank_crc     : word_t;
  signal rom_bad      : std_ulogic := '0';
  signal safety_state : safety_state_t;
  signal cause        : causes_t;
  signal fault        : causes_t;
  signal first_cause  : causes_t;
  signal first_count  : signed(inputs_c * count_bits_c - 1 downto 0);
  signal status       : word_t;
  signal load_status  : word_t;
  signal control_4    : std_ulogic_vector(7 downto 0);

begin

  pulses <= words(in_settings, 0) when in_valid = '1' else (others => '0');
  start <= pulses(cfg_start_c);
  kick <= pulses(cfg_kick_c);
  clear_encoder <= pulses(cfg_clear_encoder_c);
  clear_fault <= pulses(cfg_clear_fault_c + causes_c - 1 downto cfg_clear_fault_c);

  load <= in_load when in_load_valid = '1' else (others => '0');

  i_tick : entity work.gc_tick
    port map (
      clk        => clk,
      rst        => rst,
      cfg_enable => in_settings(cfg_tick_enable_c),
      cfg_clocks => unsigned(words(in_settings, cfg_tick_clocks_c)),
      in_ready   => idle,
      out_valid  => tick,
      sts_missed => missed
    );

  idle <= top_ready and not busy;
  begins <= (tick or start) and idle;

  i_force_path : entity work.gc_force_path
    generic map (
      lanes_g          => lanes_g,
      filter_samples_g => filter_samples_g,
      speed_timeout_g  => speed_timeout_g,
      loadable_g       => loadable_g
    )
    port map (
      clk                => clk,
      rst                => rst,
      pin_a              => pin_a,
      pin_b              => pin_b,
      pin_z              => pin_z,
      cfg_home_enable    => in_settings(cfg_home_c + axes_c - 1 downto cfg_home_c),
      cfg_index_position => signed(words(in_settings, cfg_index_c, axes_c)),
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
      load_begin         => load(load_begin_c),
      load_valid         => load(load_word_c),
      load_word          => load(31 downto 0),
      load_commit        => load(load_commit_c),
      load_crc           => load(31 downto 0),
      load_rom           => load(load_rom_c),
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
      if bank = "00" and words(in_settings, cfg_weights_c) /= words(weights_hash_c, 7) then
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

  i_drive : entity work.gc_drive
    port map (
      clk         => clk,
      rst         => rst,
      run         => run,
      in_valid    => path_valid,
      in_current  => current,
      cfg_limit   => resize(unsigned(words(in_settings, cfg_limit_c)), 31),
      cfg_slew    => resize(unsigned(words(in_settings, cfg_slew_c)), 31),
      out_valid   => drive_valid,
      out_current => command,
      out_limited => limited,
      out_settled => settled
    );

  i_safety : entity work.gc_safety
    port map (
      clk                   => clk,
      rst                   => rst,
      estop_n               => estop_n,
      enable                => in_settings(cfg_enable_c),
      clear                 => clear_fault,
      kick                  => kick,
      in_count              => count,
      in_period             => period,
      in_referenced         => referenced,
      in_illegal            => illegal,
      in_result             => path_valid,
      in_clamped            => clamped,
      in_saturated          => saturated,
      in_settled            => settled,
      in_crc_bad            => load_bad,
      in_rom_bad            => rom_bad,
      cfg_count_low         => signed(words(in_settings, cfg_low_c, axes_c)),
      cfg_count_high        => signed(words(in_settings, cfg_high_c, axes_c)),
      cfg_period_min        => resize(unsigned(words(in_settings, cfg_period_min_c)), 31),
      cfg_saturation_clocks => unsigned(words(in_settings, cfg_saturation_c)),
      cfg_watchdog_clocks   => unsigned(words(in_settings, cfg_watchdog_c)),
      cfg_result_clocks     => unsigned(words(in_settings, cfg_result_c)),
      cfg_brake_clocks      => unsigned(words(in_settings, cfg_brake_c)),
      run                   => run,
      brake_release         => released,
      sts_state             => safety_state,
      sts_present           => cause,
      sts_fault             => fault,
      sts_first_cause       => first_cause,
      sts_first_count       => first_count
    );

  drive_current <= command;
  drive_enable <= run;
  brake_release <= released;

  g_force : for i in 0 to axes_c - 1 generate
    result_force(32 * i + 31 downto 32 * i) <= resize(force_mn((i + 1) * force_bits_c - 1 downto i * force_bits_c), 32);
  end generate g_force;

  status <= x"00000" & "00" & busy & run & '0' & released & '0' & safety_state;

  -- Late enough that the rest of the state shows what it did.
  i_control : entity work.gc_delay
    generic map (
      bits_g   => control_4'length,
      clocks_g => 4
    )
    port map (
      clk      => clk,
      in_data  => in_settings(control_4'range),
      out_data => control_4
    );

  load_status <= x"000000" & "00" & bank & load_waiting & load_bad & "00";

  -- from sts_bank_crc_c down to sts_number_c
  out_state <= bank_crc
               & load_status
               & x"000000" & control_4
               & std_ulogic_vector(first_count)
               & std_ulogic_vector(count)
               & std_ulogic_vector(command)
               & std_ulogic_vector(current)
               & std_ulogic_vector(result_force)
               & std_ulogic_vector(result_period)
               & std_ulogic_vector(result_count)
               & std_ulogic_vector(resize(unsigned(first_cause), 32))
               & std_ulogic_vector(resize(unsigned(fault), 32))
               & std_ulogic_vector(resize(unsigned(cause), 32))
               & "00000" & speed_zero & speed_valid & glitch & illegal & referenced & settled & limited & saturated
               & clamped
               & status
               & std_ulogic_vector(missed)
               & std_ulogic_vector(number);

  -- In the clock of path_valid the forces are already those of the next number.
  out_valid <= not path_valid;

end architecture rtl;
