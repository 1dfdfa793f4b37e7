-- SPDX-License-Identifier: MIT
--
-- Everything around the robot: encoders, network, drives, brakes and emergency stop on one side, a host on the other.
--
-- Two unrelated clocks: clk for the core, s_axi_aclk for the registers (registers/gc_registers.rdl). They meet in two
-- gc_crossing_bus, all that the host writes there, state back, and in the reset; nothing else crosses. Settings and
-- state cross all the time: they are a round trip old, at most two.
-- Reset: s_axi_aresetn, low for 8 clocks of the slower clock; it also resets the core: brakes engaged, commands zero.
-- Latency: see docs/guide/system.md.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_network_pkg.all;
  use work.gc_system_pkg.all;

entity gc_system is
  generic (
    -- Neurons per clock.
    lanes_g           : positive := 4;
    -- Hz of clk: that of the ROM, whose friction holds for it.
    clock_hz_g        : positive := 40_000_000;
    -- Clocks that an encoder level must last, 0 = no filter.
    filter_samples_g  : natural := 4;
    -- Clocks without an edge that count as standstill.
    speed_timeout_g   : positive := 10_000_000;
    -- What the axes cannot do, and what they may do for ever, clocks: see gc_edge_watch.
    reversal_clocks_g : positive := 250;
    dither_clocks_g   : positive := 40;
    -- Whether weights, scaling and compensation can be replaced at run time: two banks of memory for all of them.
    loadable_g        : boolean := true;
    -- Clocks without a sign of the other clock that count as standstill of it, on each side; 0: not watched.
    clock_watch_g     : natural := 256;
    -- Whether brake_engage has a path of its own, and the two are compared.
    two_paths_g       : boolean := true;
    -- Whether brake_fed is wired, and compared with what the brakes were told.
    brake_feedback_g  : boolean := false;
    -- Whether each brake is tested before all are released; takes the other two.
    brake_test_g      : boolean := false;
    -- Whether settings, time-outs and remembered faults are watched for wrong bits.
    guard_g           : boolean := true;
    -- Whether there is a second core, see gc_core_twin, without which nothing moves; it takes twice the area. Pins then
    -- come two clocks later.
    twin_g            : boolean := false;
    -- Whether setpoints, servo and recorder are there (gc_motion), with their registers, and words of the recorder's
    -- ring, as a power of two.
    motion_g          : boolean := false;
    record_bits_g     : positive := 10
  );
  port (
    s_axi_aclk    : in    std_ulogic;
    s_axi_aresetn : in    std_ulogic;
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
    -- Interrupt, a level, synchronous to s_axi_aclk.
    irq           : out   std_ulogic;
    -- Clock of everything below.
    clk           : in    std_ulogic;
    -- Encoder pins and emergency stop, asynchronous; axis 1 lowest. pin_error, of a fail-safe receiver: '1' means that
    -- the axis' other pins cannot be trusted. estop_n = '0' stops. Pull pin_z and estop_n down.
    pin_a         : in    std_ulogic_vector(axes_c - 1 downto 0);
    pin_b         : in    std_ulogic_vector(axes_c - 1 downto 0);
    pin_z         : in    std_ulogic_vector(axes_c - 1 downto 0);
    pin_error     : in    std_ulogic_vector(axes_c - 1 downto 0) := (others => '0');
    estop_n       : in    std_ulogic;
    -- Current commands, uA, axis 1 lowest: hold, one clock of drive_valid per new command.
    drive_valid   : out   std_ulogic;
    drive_current : out   signed(axes_c * current_bits_c - 1 downto 0);
    -- '0': commands are zero, or clk stands: switch the drives off.
    drive_enable  : out   std_ulogic;
    -- '1' releases the brake of the axis, if brake_engage is '0'.
    brake_release : out   std_ulogic_vector(axes_c - 1 downto 0);
    -- '1' engages the brake of the axis: the other path.
    brake_engage  : out   std_ulogic_vector(axes_c - 1 downto 0);
    -- Read-back per brake, asynchronous; '1': the brake is fed, it is released. Only with brake_feedback_g.
    brake_fed     : in    std_ulogic_vector(axes_c - 1 downto 0) := (others => '0');
    -- Measured currents, uA, axis 1 lowest, with one clock of sense_valid per new one of the axis. Only with motion_g.
    sense_valid   : in    std_ulogic_vector(axes_c - 1 downto 0) := (others => '0');
    sense_current : in    signed(axes_c * current_bits_c - 1 downto 0) := (others => '0')
  );
end entity gc_system;

architecture rtl of gc_system is

  signal axi_rst : std_ulogic;
  signal running : std_ulogic;
  signal rst     : std_ulogic;

  signal axi_settings       : settings_t;
  signal axi_settings_word  : settings_word_t;
  signal axi_ready          : std_ulogic;
  signal axi_state          : state_t;
  signal axi_state_word     : state_word_t;
  signal axi_valid          : std_ulogic;
  signal core_settings      : settings_t;
  signal core_settings_word : settings_word_t;
  signal settings_valid     : std_ulogic;
  signal core_state         : state_t;
  signal core_state_word    : state_word_t;
  signal state_valid        : std_ulogic;
  signal core_alive         : std_ulogic;
  signal bus_lost           : std_ulogic;
  signal core_valid         : std_ulogic;
  signal core_current       : signed(axes_c * current_bits_c - 1 downto 0);
  signal core_enable        : std_ulogic;
  signal core_release       : axes_t;
  signal core_engage        : axes_t;
  signal core_differs       : std_ulogic;
  -- What the cores agree on.
  signal agreed_enable      : std_ulogic;
  signal agreed_release     : axes_t;
  signal agreed_engage      : axes_t;
  signal pins               : std_ulogic_vector(5 * axes_c downto 0);
  signal core_pins          : std_ulogic_vector(5 * axes_c downto 0);
  signal core_a             : axes_t;
  signal core_b             : axes_t;
  signal core_z             : axes_t;
  signal core_error         : axes_t;
  signal core_fed           : axes_t;
  signal core_estop_n       : std_ulogic;

begin

  assert clock_hz_g = clock_hz_c
    report "gc_system: need the clock of the ROM, " & integer'image(clock_hz_c) & " Hz, got "
           & integer'image(clock_hz_g)
    severity failure;

  axi_rst <= not s_axi_aresetn;

  i_reset : entity work.gc_synchronizer
    port map (
      clk           => clk,
      rst           => '0',
      async_data(0) => s_axi_aresetn,
      out_valid     => open,
      out_data(0)   => running
    );

  rst <= not running;

  i_bus_side : entity work.gc_bus_side
    generic map (
      lanes_g          => lanes_g,
      clock_hz_g       => clock_hz_g,
      filter_samples_g => filter_samples_g,
      loadable_g       => loadable_g,
      guard_g          => guard_g,
      motion_g         => motion_g,
      record_bits_g    => record_bits_g
    )
    port map (
      clk           => s_axi_aclk,
      rst           => axi_rst,
      s_axi_awaddr  => s_axi_awaddr,
      s_axi_awprot  => s_axi_awprot,
      s_axi_awvalid => s_axi_awvalid,
      s_axi_awready => s_axi_awready,
      s_axi_wdata   => s_axi_wdata,
      s_axi_wstrb   => s_axi_wstrb,
      s_axi_wvalid  => s_axi_wvalid,
      s_axi_wready  => s_axi_wready,
      s_axi_bresp   => s_axi_bresp,
      s_axi_bvalid  => s_axi_bvalid,
      s_axi_bready  => s_axi_bready,
      s_axi_araddr  => s_axi_araddr,
      s_axi_arprot  => s_axi_arprot,
      s_axi_arvalid => s_axi_arvalid,
      s_axi_arready => s_axi_arready,
      s_axi_rdata   => s_axi_rdata,
      s_axi_rresp   => s_axi_rresp,
      s_axi_rvalid  => s_axi_rvalid,
      s_axi_rready  => s_axi_rready,
      irq           => irq,
      out_settings  => axi_settings,
      out_ready     => axi_ready,
      in_alive      => core_alive,
      in_valid      => axi_valid,
      in_state      => axi_state
    );

  axi_settings_word <= to_word(axi_settings);
  core_settings <= to_settings(core_settings_word);

  i_settings : entity work.gc_crossing_bus
    generic map (
      width_g => settings_word_t'length
    )
    port map (
      in_clk    => s_axi_aclk,
      in_valid  => '1',
      in_ready  => axi_ready,
      in_data   => axi_settings_word,
      out_clk   => clk,
      out_rst   => rst,
      out_valid => settings_valid,
      out_data  => core_settings_word
    );

  pins <= estop_n & brake_fed & pin_error & pin_z & pin_b & pin_a;
  core_estop_n <= core_pins(5 * axes_c);
  core_fed <= core_pins(5 * axes_c - 1 downto 4 * axes_c);
  core_error <= core_pins(4 * axes_c - 1 downto 3 * axes_c);
  core_z <= core_pins(3 * axes_c - 1 downto 2 * axes_c);
  core_b <= core_pins(2 * axes_c - 1 downto axes_c);
  core_a <= core_pins(axes_c - 1 downto 0);

  i_core_side : entity work.gc_core_side
    generic map (
      lanes_g           => lanes_g,
      filter_samples_g  => filter_samples_g,
      speed_timeout_g   => speed_timeout_g,
      reversal_clocks_g => reversal_clocks_g,
      dither_clocks_g   => dither_clocks_g,
      loadable_g        => loadable_g,
      two_paths_g       => two_paths_g,
      brake_feedback_g  => brake_feedback_g,
      brake_test_g      => brake_test_g,
      guard_g           => guard_g,
      motion_g          => motion_g,
      record_bits_g     => record_bits_g
    )
    port map (
      clk           => clk,
      rst           => rst,
      pin_a         => core_a,
      pin_b         => core_b,
      pin_z         => core_z,
      pin_error     => core_error,
      estop_n       => core_estop_n,
      brake_fed     => core_fed,
      sense_valid   => sense_valid,
      sense_current => sense_current,
      in_clock_bad  => bus_lost,
      in_core_bad   => core_differs,
      in_valid      => settings_valid,
      in_settings   => core_settings,
      drive_valid   => core_valid,
      drive_current => core_current,
      drive_enable  => core_enable,
      brake_release => core_release,
      brake_engage  => core_engage,
      out_valid     => state_valid,
      out_state     => core_state
    );

  g_twin : if twin_g generate
    signal twin_enable  : std_ulogic;
    signal twin_release : axes_t;
    signal twin_engage  : axes_t;
  begin

    i_pins : entity work.gc_synchronizer
      generic map (
        width_g => pins'length
      )
      port map (
        clk        => clk,
        rst        => '0',
        async_data => pins,
        out_valid  => open,
        out_data   => core_pins
      );

    i_core_twin : entity work.gc_core_twin
      generic map (
        lanes_g           => lanes_g,
        filter_samples_g  => filter_samples_g,
        speed_timeout_g   => speed_timeout_g,
        reversal_clocks_g => reversal_clocks_g,
        dither_clocks_g   => dither_clocks_g,
        loadable_g        => loadable_g,
        two_paths_g       => two_paths_g,
        brake_feedback_g  => brake_feedback_g,
        brake_test_g      => brake_test_g,
        guard_g           => guard_g,
        motion_g          => motion_g,
        record_bits_g     => record_bits_g
      )
      port map (
        clk           => clk,
        rst           => rst,
        pin_a         => core_a,
        pin_b         => core_b,
        pin_z         => core_z,
        pin_error     => core_error,
        estop_n       => core_estop_n,
        brake_fed     => core_fed,
        in_clock_bad  => bus_lost,
        in_core_bad   => core_differs,
        in_valid      => settings_valid,
        in_settings   => core_settings,
        main_valid    => core_valid,
        main_current  => core_current,
        main_enable   => core_enable,
        main_release  => core_release,
        main_engage   => core_engage,
        drive_enable  => twin_enable,
        brake_release => twin_release,
        brake_engage  => twin_engage,
        out_differ    => core_differs
      );

    agreed_enable <= core_enable and twin_enable;
    agreed_release <= core_release and twin_release;
    agreed_engage <= core_engage or twin_engage;
  else generate
    core_pins <= pins;
    core_differs <= '0';
    agreed_enable <= core_enable;
    agreed_release <= core_release;
    agreed_engage <= core_engage;
  end generate g_twin;

  drive_valid <= core_valid;
  drive_current <= core_current;

  g_clock_watch : if clock_watch_g > 0 generate

    i_clock_monitor : entity work.gc_clock_monitor
      generic map (
        bus_limit_g  => clock_watch_g,
        core_limit_g => clock_watch_g
      )
      port map (
        bus_clk    => s_axi_aclk,
        bus_rst    => axi_rst,
        core_alive => core_alive,
        core_clk   => clk,
        core_rst   => rst,
        bus_lost   => bus_lost
      );

  else generate
    core_alive <= '1';
    bus_lost <= '0';
  end generate g_clock_watch;

  -- A core whose clock stands keeps what it said last: registers of the other clock have the last word. Each output is
  -- one gate behind registers of which no two change against each other, so nothing comes out that none says.
  drive_enable <= agreed_enable and core_alive;
  brake_release <= agreed_release when core_alive = '1' else (others => '0');
  brake_engage <= agreed_engage when core_alive = '1' else (others => '1');

  core_state_word <= to_word(core_state);
  axi_state <= to_state(axi_state_word);

  i_state : entity work.gc_crossing_bus
    generic map (
      width_g => state_word_t'length
    )
    port map (
      in_clk    => clk,
      in_valid  => state_valid,
      in_ready  => open,
      in_data   => core_state_word,
      out_clk   => s_axi_aclk,
      out_rst   => axi_rst,
      out_valid => axi_valid,
      out_data  => axi_state_word
    );

end architecture rtl;
