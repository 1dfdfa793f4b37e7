-- SPDX-License-Identifier: MIT
--
-- gc_system with an encoder model on the pins of each axis: the test moves the axes, the bench makes the edges.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_network_pkg.all;
  use work.gc_system_pkg.all;

entity gc_system_bench is
  generic (
    -- See gc_system.
    lanes_g          : positive := 4;
    speed_timeout_g  : positive := 10_000_000;
    loadable_g       : boolean := true;
    clock_watch_g    : natural := 256;
    two_paths_g      : boolean := true;
    brake_feedback_g : boolean := false;
    brake_test_g     : boolean := false;
    guard_g          : boolean := true;
    twin_g           : boolean := false
  );
  port (
    s_axi_aclk      : in    std_ulogic;
    s_axi_aresetn   : in    std_ulogic;
    s_axi_awaddr    : in    std_ulogic_vector(11 downto 0);
    s_axi_awprot    : in    std_ulogic_vector(2 downto 0);
    s_axi_awvalid   : in    std_ulogic;
    s_axi_awready   : out   std_ulogic;
    s_axi_wdata     : in    std_ulogic_vector(31 downto 0);
    s_axi_wstrb     : in    std_ulogic_vector(3 downto 0);
    s_axi_wvalid    : in    std_ulogic;
    s_axi_wready    : out   std_ulogic;
    s_axi_bresp     : out   std_ulogic_vector(1 downto 0);
    s_axi_bvalid    : out   std_ulogic;
    s_axi_bready    : in    std_ulogic;
    s_axi_araddr    : in    std_ulogic_vector(11 downto 0);
    s_axi_arprot    : in    std_ulogic_vector(2 downto 0);
    s_axi_arvalid   : in    std_ulogic;
    s_axi_arready   : out   std_ulogic;
    s_axi_rdata     : out   std_ulogic_vector(31 downto 0);
    s_axi_rresp     : out   std_ulogic_vector(1 downto 0);
    s_axi_rvalid    : out   std_ulogic;
    s_axi_rready    : in    std_ulogic;
    irq             : out   std_ulogic;
    clk             : in    std_ulogic;
    -- Position of each axis to walk to and of its index, counts, axis 1 lowest; see gc_encoder_model.
    target          : in    signed(axes_c * 32 - 1 downto 0);
    index_count     : in    signed(axes_c * 32 - 1 downto 0);
    load            : in    std_ulogic;
    clocks_per_edge : in    unsigned(15 downto 0);
    busy            : out   std_ulogic_vector(axes_c - 1 downto 0);
    -- Encoder pins, for the test to watch.
    pin_a           : out   std_ulogic_vector(axes_c - 1 downto 0);
    pin_b           : out   std_ulogic_vector(axes_c - 1 downto 0);
    estop_n         : in    std_ulogic;
    drive_valid     : out   std_ulogic;
    drive_current   : out   signed(axes_c * current_bits_c - 1 downto 0);
    drive_enable    : out   std_ulogic;
    brake_release   : out   std_ulogic_vector(axes_c - 1 downto 0);
    brake_engage    : out   std_ulogic_vector(axes_c - 1 downto 0);
    -- Brakes that both paths release.
    brakes_open     : out   std_ulogic_vector(axes_c - 1 downto 0);
    -- Bits that cross to the core with a parity: settings, and behind them what is done once.
    watched_bits    : out   natural;
    -- The read-back of the axis is wrong; it follows at once otherwise.
    brake_fails     : in    std_ulogic_vector(axes_c - 1 downto 0) := (others => '0')
  );
end entity gc_system_bench;

architecture sim of gc_system_bench is

  signal a          : std_ulogic_vector(axes_c - 1 downto 0);
  signal b          : std_ulogic_vector(axes_c - 1 downto 0);
  signal z          : std_ulogic_vector(axes_c - 1 downto 0);
  signal fed        : std_ulogic_vector(axes_c - 1 downto 0);
  signal true_count : signed(axes_c * 32 - 1 downto 0);

  -- The test writes a word that crosses to *_bits, and reads its fields: cocotb sees no records.
  signal state_bits       : state_word_t;
  signal state            : state_t;
  signal state_number     : word_t;
  signal state_position   : flat_t;
  signal state_period     : flat_t;
  signal state_force      : flat_t;
  signal state_current    : flat_t;
  signal settings_bits    : settings_word_t;
  signal settings         : settings_t;
  signal settings_weights : word_t;
  signal settings_home    : axes_t;
  signal load_kinds       : std_ulogic_vector(3 downto 0);
  signal load_word        : word_t;

begin

  g_encoder : for i in 0 to axes_c - 1 generate

    i_encoder : entity work.gc_encoder_model
      port map (
        clk             => clk,
        target          => target((i + 1) * 32 - 1 downto i * 32),
        clocks_per_edge => clocks_per_edge,
        load            => load,
        load_count      => index_count((i + 1) * 32 - 1 downto i * 32),
        index_count     => index_count((i + 1) * 32 - 1 downto i * 32),
        a               => a(i),
        b               => b(i),
        z               => z(i),
        count           => true_count((i + 1) * 32 - 1 downto i * 32),
        busy            => busy(i)
      );

  end generate g_encoder;

  brakes_open <= brake_release and not brake_engage;
  fed <= brakes_open xor brake_fails;
  watched_bits <= held_bits_c + once_bits_c;

  pin_a <= a;
  pin_b <= b;

  i_system : entity work.gc_system
    generic map (
      lanes_g          => lanes_g,
      speed_timeout_g  => speed_timeout_g,
      loadable_g       => loadable_g,
      clock_watch_g    => clock_watch_g,
      two_paths_g      => two_paths_g,
      brake_feedback_g => brake_feedback_g,
      brake_test_g     => brake_test_g,
      guard_g          => guard_g,
      twin_g           => twin_g
    )
    port map (
      s_axi_aclk    => s_axi_aclk,
      s_axi_aresetn => s_axi_aresetn,
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
      clk           => clk,
      pin_a         => a,
      pin_b         => b,
      pin_z         => z,
      estop_n       => estop_n,
      drive_valid   => drive_valid,
      drive_current => drive_current,
      drive_enable  => drive_enable,
      brake_release => brake_release,
      brake_engage  => brake_engage,
      brake_fed     => fed
    );

  state <= to_state(state_bits);
  state_number <= state.number;
  state_position <= flat(state.position);
  state_period <= flat(state.period);
  state_force <= flat(state.force_mn);
  state_current <= flat(state.current);

  settings <= to_settings(settings_bits);
  settings_home <= settings.home;
  settings_weights <= settings.weights;

  load_kinds <= settings.load.use_rom & settings.load.commit & settings.load.begin_image & settings.load.is_word;
  load_word <= settings.load.word;

end architecture sim;
