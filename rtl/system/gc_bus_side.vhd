-- SPDX-License-Identifier: MIT
--
-- The host's side of gc_system: registers behind AXI4-Lite; settings, commands and what is loaded out, state in,
-- interrupt.
--
-- A command bit that is written waits until out_ready and goes out once, with the settings written before it; the same
-- bit written twice before that is one command. The interrupt bits follow the numbers in the state: one event per word
-- of state that brings new results, a new fault or new missed ticks.
-- An address without a register, a write to a register that cannot be written and a read of one that cannot be read
-- get the response SLVERR and change nothing; so does a write to the loader while it is locked. What is to be loaded
-- counts only while it is unlocked: no wrong bit in the registers loads anything.
-- A write address is taken a clock after the write before it was answered and what that loads has gone out, in one word
-- with the settings: a write finds the lock as those before it have left it, none overtakes another on the way to the
-- core, and nothing is loaded faster than it is taken.
-- With motion_g the upper half of the addresses is that of gc_motion_registers, and one read may be under way. A read
-- of a word of a record waits until the core has sent it; while the core's clock stands it gets SLVERR.
-- Latency: 1 clock from in_valid to the interrupt status. AXI4-Lite: see generated/gc_registers.vhd; one write and two
-- reads may be under way.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_compensation_pkg.all;
  use work.gc_facts_pkg.all;
  use work.gc_network_pkg.all;
  use work.gc_registers_pkg.all;
  use work.gc_safety_pkg.all;
  use work.gc_system_pkg.all;

entity gc_bus_side is
  generic (
    -- What the registers say of the core: neurons per clock, Hz, clocks of the encoders' filter, whether it has banks.
    lanes_g          : positive := 4;
    clock_hz_g       : positive := 40_000_000;
    filter_samples_g : natural := 4;
    loadable_g       : boolean := true;
    -- Whether settings, and what waits to go out, are watched for wrong bits.
    guard_g          : boolean := false;
    -- Whether there is gc_motion, and words of its recorder's ring, as a power of two.
    motion_g         : boolean := false;
    record_bits_g    : positive := 10
  );
  port (
    clk           : in    std_ulogic;
    -- Synchronous, active high.
    rst           : in    std_ulogic;
    s_axi_awaddr  : in    std_ulogic_vector(11 downto 0);
    s_axi_awprot  : in    std_ulogic_vector(2 downto 0);
    s_axi_awvalid : in    std_ulogic;
    s_axi_awready : out   std_ulogic;
    s_axi_wdata   : in    std_ulogic_vector(31 downto 0);
    s_axi_wstrb   : in    std_ulogic_vector(3 downto 0);
    s_axi_wvalid  : in    std_ulogic;
    s_axi_wready  : out   std_ulogic;
    s_axi_bresp   : out   std_ulogic_vector(1 downto 0);
    s_axi_bvalid  : out   std_ulogic;
    s_axi_bready  : in    std_ulogic;
    s_axi_araddr  : in    std_ulogic_vector(11 downto 0);
    s_axi_arprot  : in    std_ulogic_vector(2 downto 0);
    s_axi_arvalid : in    std_ulogic;
    s_axi_arready : out   std_ulogic;
    s_axi_rdata   : out   std_ulogic_vector(31 downto 0);
    s_axi_rresp   : out   std_ulogic_vector(1 downto 0);
    s_axi_rvalid  : out   std_ulogic;
    s_axi_rready  : in    std_ulogic;
    -- An enabled interrupt bit is set; a level.
    irq           : out   std_ulogic;
    -- The settings of this clock, and the commands and the load that wait; taken in a clock with out_ready.
    out_settings  : out   settings_t;
    out_ready     : in    std_ulogic;
    -- The core's clock runs.
    in_alive      : in    std_ulogic;
    -- New state.
    in_valid      : in    std_ulogic;
    in_state      : in    state_t
  );
end entity gc_bus_side;

architecture rtl of gc_bus_side is

  -- An address without a register.
  constant no_register_c : std_ulogic_vector(11 downto 0) := x"FFC";

  -- Upper part of the addresses of the settings, and the one among them that keeps nothing.
  constant settings_block_c   : std_ulogic_vector(11 downto 9) := "001";
  constant motion_block_c     : std_ulogic_vector(11 downto 9) := "100";
  constant command_register_c : std_ulogic_vector(11 downto 0) := x"204";

  constant following_only_c : causes_t := (cause_following_c => '1', others => '0');

  signal regs_in  : gc_registers_in_t;
  signal regs_out : gc_registers_out_t;

  signal unlocked      : std_ulogic := '0';
  signal writing       : std_ulogic := '0';
  signal write_ready   : std_ulogic := '0';
  signal write_address : std_ulogic_vector(11 downto 0);
  signal write_valid   : std_ulogic;
  signal awready       : std_ulogic;
  signal bvalid        : std_ulogic;

  -- The handshakes, as gc_registers has them.
  signal core_awvalid : std_ulogic;
  signal core_awready : std_ulogic;
  signal core_wvalid  : std_ulogic;
  signal core_wready  : std_ulogic;
  signal core_bvalid  : std_ulogic;
  signal core_bready  : std_ulogic;
  signal core_bresp   : std_ulogic_vector(1 downto 0);
  signal core_arvalid : std_ulogic;
  signal core_arready : std_ulogic;
  signal core_rvalid  : std_ulogic;
  signal core_rready  : std_ulogic;
  signal core_rdata   : word_t;
  signal core_rresp   : std_ulogic_vector(1 downto 0);
  signal loaded       : std_ulogic := '0';

  signal fetch         : fetch_t;
  signal settings      : settings_t;
  signal settings_held : held_t;
  signal parity        : parity_t;
  signal once_parity   : std_ulogic := '0';

  signal command       : commands_t;
  signal waiting       : commands_t := no_commands_c;
  signal next_waiting  : commands_t;
  signal loads         : load_t;
  signal loads_waiting : load_t := no_load_c;
  signal next_loads    : load_t;

  signal number     : word_t   := (others => '0');
  signal missed     : word_t   := (others => '0');
  signal events     : std_ulogic_vector(7 downto 0) := (others => '0');
  signal new_result : std_ulogic := '0';
  signal new_fault  : std_ulogic := '0';
  signal new_missed : std_ulogic := '0';
  signal alive_1    : std_ulogic := '0';
  signal stopped    : std_ulogic := '0';

begin

  i_registers : entity work.gc_registers
    port map (
      clk            => clk,
      rst            => rst,
      s_axil_awready => core_awready,
      s_axil_awvalid => core_awvalid,
      s_axil_awaddr  => write_address,
      s_axil_awprot  => s_axi_awprot,
      s_axil_wready  => core_wready,
      s_axil_wvalid  => core_wvalid,
      s_axil_wdata   => s_axi_wdata,
      s_axil_wstrb   => s_axi_wstrb,
      s_axil_bready  => core_bready,
      s_axil_bvalid  => core_bvalid,
      s_axil_bresp   => core_bresp,
      s_axil_arready => core_arready,
      s_axil_arvalid => core_arvalid,
      s_axil_araddr  => s_axi_araddr,
      s_axil_arprot  => s_axi_arprot,
      s_axil_rready  => core_rready,
      s_axil_rvalid  => core_rvalid,
      s_axil_rdata   => core_rdata,
      s_axil_rresp   => core_rresp,
      hwif_in        => regs_in,
      hwif_out       => regs_out
    );

  irq <= regs_out.interrupt_status.intr;

  -- Motion

  g_motion : if motion_g generate

    i_motion : entity work.gc_motion_bus
      generic map (
        record_bits_g => record_bits_g
      )
      port map (
        clk           => clk,
        rst           => rst,
        s_axi_awaddr  => write_address,
        s_axi_awprot  => s_axi_awprot,
        s_axi_awvalid => write_valid,
        s_axi_awready => awready,
        s_axi_wdata   => s_axi_wdata,
        s_axi_wstrb   => s_axi_wstrb,
        s_axi_wvalid  => s_axi_wvalid,
        s_axi_wready  => s_axi_wready,
        s_axi_bresp   => s_axi_bresp,
        s_axi_bvalid  => bvalid,
        s_axi_bready  => s_axi_bready,
        s_axi_araddr  => s_axi_araddr,
        s_axi_arprot  => s_axi_arprot,
        s_axi_arvalid => s_axi_arvalid,
        s_axi_arready => s_axi_arready,
        s_axi_rdata   => s_axi_rdata,
        s_axi_rresp   => s_axi_rresp,
        s_axi_rvalid  => s_axi_rvalid,
        s_axi_rready  => s_axi_rready,
        m_axi_awvalid => core_awvalid,
        m_axi_awready => core_awready,
        m_axi_wvalid  => core_wvalid,
        m_axi_wready  => core_wready,
        m_axi_bresp   => core_bresp,
        m_axi_bvalid  => core_bvalid,
        m_axi_bready  => core_bready,
        m_axi_arvalid => core_arvalid,
        m_axi_arready => core_arready,
        m_axi_rdata   => core_rdata,
        m_axi_rresp   => core_rresp,
        m_axi_rvalid  => core_rvalid,
        m_axi_rready  => core_rready,
        out_settings  => settings.motion,
        out_move      => command.move,
        out_fetch     => fetch,
        in_alive      => in_alive,
        in_state      => in_state.motion
      );

    command.clear_fault <= regs_out.fault.clear.value;
  else generate
    core_awvalid <= write_valid;
    awready <= core_awready;
    core_wvalid <= s_axi_wvalid;
    s_axi_wready <= core_wready;
    s_axi_bresp <= core_bresp;
    bvalid <= core_bvalid;
    core_bready <= s_axi_bready;
    core_arvalid <= s_axi_arvalid;
    s_axi_arready <= core_arready;
    s_axi_rdata <= core_rdata;
    s_axi_rresp <= core_rresp;
    s_axi_rvalid <= core_rvalid;
    core_rready <= s_axi_rready;
    settings.motion <= no_motion_settings_c;
    command.move <= '0';
    fetch <= no_fetch_c;
    -- Of a fault that cannot come nothing is kept.
    command.clear_fault <= regs_out.fault.clear.value and not following_only_c;
  end generate g_motion;

  -- Writes, one at a time

  write_valid <= s_axi_awvalid and write_ready;
  s_axi_awready <= awready and write_ready;
  s_axi_bvalid <= bvalid;

  p_writing : process (clk) is
  begin

    if rising_edge(clk) then
      write_ready <= not (writing or any_of(loads) or any_of(loads_waiting));
      if write_valid = '1' and awready = '1' then
        write_ready <= '0';
        writing <= '1';
      elsif bvalid = '1' and s_axi_bready = '1' then
        writing <= '0';
      end if;
      if rst = '1' then
        write_ready <= '0';
        writing <= '0';
      end if;
    end if;

  end process p_writing;

  -- Loading

  regs_in.load_unlock.key.hwclr <= regs_out.load_command.commit.value;

  write_address <= no_register_c when unlocked = '0' and s_axi_awaddr(load_block_c'range) = load_block_c else
                   s_axi_awaddr;

  -- The key counts a clock after it was written, before the next write is taken. The word itself is there one clock
  -- after its swmod.
  p_loaded : process (clk) is
  begin

    if rising_edge(clk) then
      unlocked <= '0';
      if regs_out.load_unlock.key.value = load_key_c then
        unlocked <= '1';
      end if;
      loaded <= regs_out.load_word.value.swmod;
      if rst = '1' then
        unlocked <= '0';
        loaded <= '0';
      end if;
    end if;

  end process p_loaded;

  loads.word <= regs_out.load_word.value.value when loaded = '1' else regs_out.load_crc.value.value;
  loads.is_word <= loaded and unlocked;
  loads.begin_image <= regs_out.load_command.begin_image.value and unlocked;
  -- It locks, two clocks later, before the next write is taken.
  loads.commit <= regs_out.load_command.commit.value and unlocked;
  loads.use_rom <= regs_out.load_command.use_rom.value and unlocked;

  -- Identity

  regs_in.encoder_geometry.motion.next_q <= '1' when motion_g else '0';
  regs_in.geometry.inputs.next_q <= std_ulogic_vector(to_unsigned(inputs_c, 8));
  regs_in.geometry.hidden.next_q <= std_ulogic_vector(to_unsigned(hidden_c, 8));
  regs_in.geometry.outputs.next_q <= std_ulogic_vector(to_unsigned(axes_c, 7));
  regs_in.geometry.lean.next_q <= '1' when lean_c else '0';
  regs_in.geometry.lanes.next_q <= std_ulogic_vector(to_unsigned(lanes_g, 8));
  regs_in.clock_hz.value.next_q <= std_ulogic_vector(to_unsigned(clock_hz_g, 32));
  regs_in.encoder_geometry.filter_samples.next_q <= std_ulogic_vector(to_unsigned(filter_samples_g, 16));

  g_hash : for i in 0 to 7 generate
    regs_in.weights_hash(i).value.next_q <= weights_hash_c(32 * (7 - i) + 31 downto 32 * (7 - i));
    regs_in.compensation_hash(i).value.next_q <= compensation_hash_c(32 * (7 - i) + 31 downto 32 * (7 - i));
  end generate g_hash;

  -- Settings and commands

  command.start <= regs_out.command.start.value;
  command.kick <= regs_out.command.kick.value;
  command.clear_encoder <= regs_out.command.clear_encoder.value;

  -- What is written to fault is one pulse, too.
  regs_in.fault.clear.hwclr <= '1';

  next_waiting <= no_commands_c when rst = '1' else
                  command when out_ready = '1' else
                  waiting or command;

  -- Nothing waits when something is to be loaded: a write behind one to the loader is not taken before that has gone.
  next_loads <= no_load_c when rst = '1' else
                loads when any_of(loads) = '1' else
                no_load_c when out_ready = '1' else
                loads_waiting;

  p_commands : process (clk) is
  begin

    if rising_edge(clk) then
      waiting <= next_waiting;
      loads_waiting <= next_loads;
    end if;

  end process p_commands;

  settings.commands <= no_commands_c;
  settings.load <= no_load_c;
  settings.parity <= (others => '0');
  settings.once_parity <= '0';
  settings.fetch <= fetch;
  settings.enable <= regs_out.control.enable.value;
  settings.tick_enable <= regs_out.control.tick_enable.value;
  settings.home <= axes_of(regs_out.control.home_enable.value);
  settings.tick_clocks <= regs_out.tick_clocks.value.value;
  settings.weights <= regs_out.expected_weights.value.value;
  settings.saturation_clocks <= regs_out.saturation_clocks.value.value;
  settings.watchdog_clocks <= regs_out.watchdog_clocks.value.value;
  settings.result_clocks <= regs_out.result_clocks.value.value;
  settings.brake_clocks <= regs_out.brake_clocks.value.value;
  settings.command_clocks <= regs_out.command_clocks.value.value;
  settings.hold_clocks <= regs_out.hold_clocks.value.value;
  settings.brake_test_clocks <= regs_out.brake_test_clocks.value.value;

  settings_held <= held(settings);

  p_out : process (all) is
  begin

    out_settings <= settings;
    out_settings.commands <= waiting;
    out_settings.load <= loads_waiting;
    out_settings.parity <= parity;
    out_settings.once_parity <= once_parity;

  end process p_out;

  -- Parity goes along with the settings, and with what waits; it is that of what was written. Settings change only in a
  -- write to one, and in reset.

  g_guard : if guard_g generate
    signal writing_setting : std_ulogic := '0';
    signal may_change      : std_ulogic;
    signal once_wrong      : std_ulogic;
  begin

    p_setting : process (clk) is
    begin

      if rising_edge(clk) then
        if write_valid = '1' and awready = '1' then
          writing_setting <= '0';
          if s_axi_awaddr(settings_block_c'range) = settings_block_c and s_axi_awaddr /= command_register_c then
            writing_setting <= '1';
          end if;
          if motion_g and s_axi_awaddr(motion_block_c'range) = motion_block_c then
            writing_setting <= '1';
          end if;
        end if;
      end if;

    end process p_setting;

    may_change <= rst or (writing and writing_setting);

    g_word : for i in parity'range generate

      -- Words that hold nothing but what motion has are zero without.

      g_there : if motion_g or i < core_held_words_c generate

        i_guard : entity work.gc_parity_guard
          port map (
            clk        => clk,
            rst        => rst,
            in_load    => may_change,
            in_next    => settings_held(32 * i + 31 downto 32 * i),
            in_word    => settings_held(32 * i + 31 downto 32 * i),
            out_parity => parity(i),
            out_upset  => open
          );

      else generate
        parity(i) <= '0';
      end generate g_there;

    end generate g_word;

    -- What is kept stays wrong, with whatever joins it, until it has gone.
    once_wrong <= once_parity xor parity_of(once(waiting, loads_waiting));

    p_once : process (clk) is
    begin

      if rising_edge(clk) then
        once_parity <= parity_of(once(next_waiting, next_loads)) xor (once_wrong and not (out_ready or rst));
      end if;

    end process p_once;

  else generate
    parity <= (others => '0');
    once_parity <= '0';
  end generate g_guard;

  -- State

  regs_in.load_status.loadable.next_q <= '1' when loadable_g else '0';
  regs_in.load_status.unlocked.next_q <= unlocked;
  regs_in.load_status.bad.next_q <= in_state.load_bad;
  regs_in.load_status.waiting.next_q <= in_state.load_waiting;
  regs_in.load_status.bank.next_q <= in_state.bank;
  regs_in.bank_crc.value.next_q <= in_state.bank_crc;

  regs_in.control_now.enable.next_q <= in_state.enable;
  regs_in.control_now.tick_enable.next_q <= in_state.tick_enable;
  regs_in.control_now.home_enable.next_q <= field_of(in_state.home);

  regs_in.result_number.value.next_q <= in_state.number;
  regs_in.missed_ticks.value.next_q <= in_state.missed;

  regs_in.status.state.next_q <= in_state.safety;
  regs_in.status.released.next_q <= field_of(in_state.released);
  regs_in.status.run.next_q <= in_state.run;
  regs_in.status.busy.next_q <= in_state.busy;

  regs_in.result_flags.clamped.next_q <= field_of(in_state.clamped);
  regs_in.result_flags.saturated.next_q <= field_of(in_state.saturated);
  regs_in.command_flags.limited.next_q <= field_of(in_state.limited);
  regs_in.command_flags.reached.next_q <= field_of(in_state.reached);
  regs_in.command_flags.deviates.next_q <= field_of(in_state.deviates);
  regs_in.encoder_flags.referenced.next_q <= field_of(in_state.referenced);
  regs_in.encoder_flags.illegal.next_q <= field_of(in_state.illegal);
  regs_in.encoder_flags.glitch.next_q <= field_of(in_state.glitch);
  regs_in.speed_flags.speed_valid.next_q <= field_of(in_state.speed_valid);
  regs_in.speed_flags.speed_zero.next_q <= field_of(in_state.speed_zero);

  regs_in.cause.value.next_q <= in_state.cause;
  regs_in.first_cause.value.next_q <= in_state.first_cause;
  regs_in.fault.estop.next_q <= in_state.fault(cause_estop_c);
  regs_in.fault.encoder.next_q <= in_state.fault(cause_encoder_c);
  regs_in.fault.crc.next_q <= in_state.fault(cause_crc_c);
  regs_in.fault.rom.next_q <= in_state.fault(cause_rom_c);
  regs_in.fault.speed.next_q <= in_state.fault(cause_speed_c);
  regs_in.fault.position.next_q <= in_state.fault(cause_position_c);
  regs_in.fault.saturation.next_q <= in_state.fault(cause_saturation_c);
  regs_in.fault.watchdog.next_q <= in_state.fault(cause_watchdog_c);
  regs_in.fault.result.next_q <= in_state.fault(cause_result_c);
  regs_in.fault.unreferenced.next_q <= in_state.fault(cause_unreferenced_c);
  regs_in.fault.command.next_q <= in_state.fault(cause_command_c);
  regs_in.fault.hold.next_q <= in_state.fault(cause_hold_c);
  regs_in.fault.brake.next_q <= in_state.fault(cause_brake_c);
  regs_in.fault.clock.next_q <= in_state.fault(cause_clock_c);
  regs_in.fault.core.next_q <= in_state.fault(cause_core_c);
  regs_in.fault.upset.next_q <= in_state.fault(cause_upset_c);
  regs_in.fault.following.next_q <= in_state.fault(cause_following_c);

  regs_in.guards.feedback.next_q <= field_of(in_state.feedback);
  regs_in.guards.core_clock.next_q <= in_alive;

  -- One word per axis.

  g_axis : for i in 0 to axes_c - 1 generate
    regs_in.trained_low(i).value.next_q <= std_ulogic_vector(to_signed(count_low_c(i), 32));
    regs_in.trained_high(i).value.next_q <= std_ulogic_vector(to_signed(count_high_c(i), 32));

    settings.index_position(i) <= regs_out.index_position(i).value.value;
    settings.index_period(i) <= regs_out.index_period(i).value.value;
    settings.window_low(i) <= regs_out.window_low(i).value.value;
    settings.window_high(i) <= regs_out.window_high(i).value.value;
    settings.current_limit(i) <= regs_out.current_limit_ua(i).value.value;
    settings.current_slew(i) <= regs_out.current_slew_ua(i).value.value;
    settings.command_bound(i) <= regs_out.command_bound_ua(i).value.value;
    settings.period_min(i) <= regs_out.period_min_clocks(i).value.value;

    regs_in.position(i).value.next_q <= in_state.position(i);
    regs_in.speed_period(i).value.next_q <= in_state.period(i);
    regs_in.force_mn(i).value.next_q <= in_state.force_mn(i);
    regs_in.current_ua(i).value.next_q <= in_state.current(i);
    regs_in.command_ua(i).value.next_q <= in_state.command(i);
    regs_in.position_now(i).value.next_q <= in_state.position_now(i);
    regs_in.first_position(i).value.next_q <= in_state.first_position(i);
  end generate g_axis;

  -- Interrupt

  p_events : process (clk) is
  begin

    if rising_edge(clk) then
      new_result <= '0';
      new_missed <= '0';
      new_fault <= '0';
      alive_1 <= in_alive;
      stopped <= alive_1 and not in_alive;
      if in_valid = '1' then
        number <= in_state.number;
        missed <= in_state.missed;
        events <= in_state.fault_events;
        if number /= in_state.number then
          new_result <= '1';
        end if;
        if missed /= in_state.missed then
          new_missed <= '1';
        end if;
        if events /= in_state.fault_events then
          new_fault <= '1';
        end if;
      end if;
      if rst = '1' then
        number <= (others => '0');
        missed <= (others => '0');
        events <= (others => '0');
        new_result <= '0';
        new_missed <= '0';
        new_fault <= '0';
        alive_1 <= '0';
        stopped <= '0';
      end if;
    end if;

  end process p_events;

  regs_in.interrupt_status.result.next_q <= new_result;
  regs_in.interrupt_status.missed_tick.next_q <= new_missed;
  regs_in.interrupt_status.fault.next_q <= new_fault;
  regs_in.interrupt_status.core_stopped.next_q <= stopped;

end architecture rtl;
