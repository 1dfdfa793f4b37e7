-- SPDX-License-Identifier: MIT
--
-- gc_system behind a serial port, for a board without a processor: gc_uart and gc_modbus write and read its registers.
--
-- Modbus RTU, see gc_modbus; the map is that of registers/gc_registers.rdl: the register at byte offset A is the Modbus
-- registers A/2 and A/2 + 1. The watchdog of gc_system is kicked through the line as any other register is
-- written: a line that is cut engages the brakes.
-- Latency: that of the line; a frame ends with the longer of 3.5 characters and gap_us_g of silence.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_crc_pkg.all;
  use work.gc_facts_pkg.all;
  use work.gc_network_pkg.all;

entity gc_serial_system is
  generic (
    -- Hz of bus_clk, at least eight times the baud rate.
    bus_clock_hz_g    : positive := 40_000_000;
    -- Bits per second, 1200 to 3 000 000.
    baud_g            : positive := 115_200;
    -- 0: no parity; 1: odd; 2: even.
    parity_g          : natural range 0 to 2 := 0;
    -- Address on the line.
    unit_g            : positive range 1 to 247 := 1;
    -- Silence that ends a frame, us, if 3.5 characters are shorter; the standard asks for 1750 above 19200 baud. Less
    -- answers sooner, but a sender that pauses within a frame is cut.
    gap_us_g          : natural range 0 to 20_000 := 1750;
    -- Those of gc_system.
    lanes_g           : positive := 4;
    clock_hz_g        : positive := 40_000_000;
    filter_samples_g  : natural := 4;
    speed_timeout_g   : positive := 10_000_000;
    reversal_clocks_g : positive := 250;
    dither_clocks_g   : positive := 40;
    loadable_g        : boolean := true;
    clock_watch_g     : natural := 256;
    two_paths_g       : boolean := true;
    brake_feedback_g  : boolean := false;
    brake_test_g      : boolean := false;
    guard_g           : boolean := true;
    twin_g            : boolean := false;
    motion_g          : boolean := false;
    record_bits_g     : positive := 10
  );
  port (
    -- Clock of the registers and of the line.
    bus_clk       : in    std_ulogic;
    -- Synchronous to bus_clk, active high, for 8 clocks of the slower clock; resets the core, too.
    bus_rst       : in    std_ulogic;
    -- Serial line, high at rest; pin_rx is asynchronous: pull it up.
    pin_rx        : in    std_ulogic;
    pin_tx        : out   std_ulogic;
    -- An answer is on its way: enables the driver of an RS-485 line.
    pin_tx_enable : out   std_ulogic;
    -- The interrupt of gc_system, a level, synchronous to bus_clk.
    irq           : out   std_ulogic;
    -- The rest is that of gc_system.
    clk           : in    std_ulogic;
    pin_a         : in    std_ulogic_vector(axes_c - 1 downto 0);
    pin_b         : in    std_ulogic_vector(axes_c - 1 downto 0);
    pin_z         : in    std_ulogic_vector(axes_c - 1 downto 0);
    pin_error     : in    std_ulogic_vector(axes_c - 1 downto 0) := (others => '0');
    estop_n       : in    std_ulogic;
    drive_valid   : out   std_ulogic;
    drive_current : out   signed(axes_c * current_bits_c - 1 downto 0);
    drive_enable  : out   std_ulogic;
    brake_release : out   std_ulogic_vector(axes_c - 1 downto 0);
    brake_engage  : out   std_ulogic_vector(axes_c - 1 downto 0);
    brake_fed     : in    std_ulogic_vector(axes_c - 1 downto 0) := (others => '0');
    sense_valid   : in    std_ulogic_vector(axes_c - 1 downto 0) := (others => '0');
    sense_current : in    signed(axes_c * current_bits_c - 1 downto 0) := (others => '0')
  );
end entity gc_serial_system;

architecture rtl of gc_serial_system is

  -- 3.5 characters, and half a bit: gc_uart gives a character in the middle of its stop bit.
  constant half_bits_c : positive := 7 * (10 + (parity_g + 1) / 2) + 1;

  -- In clocks, and without a product beyond the integers.
  constant characters_c : positive := (bus_clock_hz_g / baud_g * half_bits_c
                                       + (bus_clock_hz_g mod baud_g) * half_bits_c / baud_g) / 2 + 1;
  constant silence_c    : natural := bus_clock_hz_g / 1000 * gap_us_g / 1000;

  function larger (
    a : natural;
    b : natural
  ) return natural is
  begin

    if a > b then
      return a;
    end if;

    return b;

  end function larger;

  signal bus_rst_n    : std_ulogic;
  signal rx_valid     : std_ulogic;
  signal rx_data      : byte_t;
  signal rx_error     : std_ulogic;
  signal rx_receiving : std_ulogic;
  signal tx_valid     : std_ulogic;
  signal tx_ready     : std_ulogic;
  signal tx_data      : byte_t;

  -- AXI4-Lite
  signal awaddr  : std_ulogic_vector(11 downto 0);
  signal awprot  : std_ulogic_vector(2 downto 0);
  signal awvalid : std_ulogic;
  signal awready : std_ulogic;
  signal wdata   : std_ulogic_vector(31 downto 0);
  signal wstrb   : std_ulogic_vector(3 downto 0);
  signal wvalid  : std_ulogic;
  signal wready  : std_ulogic;
  signal bresp   : std_ulogic_vector(1 downto 0);
  signal bvalid  : std_ulogic;
  signal bready  : std_ulogic;
  signal araddr  : std_ulogic_vector(11 downto 0);
  signal arprot  : std_ulogic_vector(2 downto 0);
  signal arvalid : std_ulogic;
  signal arready : std_ulogic;
  signal rdata   : std_ulogic_vector(31 downto 0);
  signal rresp   : std_ulogic_vector(1 downto 0);
  signal rvalid  : std_ulogic;
  signal rready  : std_ulogic;

begin

  assert baud_g >= 1200 and baud_g <= 3_000_000
    report "gc_serial_system: need baud_g from 1200 to 3000000, got " & integer'image(baud_g)
    severity failure;

  bus_rst_n <= not bus_rst;

  i_uart : entity work.gc_uart
    generic map (
      clock_hz_g => bus_clock_hz_g,
      baud_g     => baud_g,
      parity_g   => parity_g
    )
    port map (
      clk           => bus_clk,
      rst           => bus_rst,
      pin_rx        => pin_rx,
      pin_tx        => pin_tx,
      out_valid     => rx_valid,
      out_data      => rx_data,
      out_error     => rx_error,
      sts_receiving => rx_receiving,
      in_valid      => tx_valid,
      in_ready      => tx_ready,
      in_data       => tx_data
    );

  i_modbus : entity work.gc_modbus
    generic map (
      unit_g       => unit_g,
      gap_clocks_g => larger(characters_c, silence_c)
    )
    port map (
      clk           => bus_clk,
      rst           => bus_rst,
      rx_valid      => rx_valid,
      rx_data       => rx_data,
      rx_error      => rx_error,
      rx_receiving  => rx_receiving,
      tx_valid      => tx_valid,
      tx_ready      => tx_ready,
      tx_data       => tx_data,
      tx_enable     => pin_tx_enable,
      m_axi_awaddr  => awaddr,
      m_axi_awprot  => awprot,
      m_axi_awvalid => awvalid,
      m_axi_awready => awready,
      m_axi_wdata   => wdata,
      m_axi_wstrb   => wstrb,
      m_axi_wvalid  => wvalid,
      m_axi_wready  => wready,
      m_axi_bresp   => bresp,
      m_axi_bvalid  => bvalid,
      m_axi_bready  => bready,
      m_axi_araddr  => araddr,
      m_axi_arprot  => arprot,
      m_axi_arvalid => arvalid,
      m_axi_arready => arready,
      m_axi_rdata   => rdata,
      m_axi_rresp   => rresp,
      m_axi_rvalid  => rvalid,
      m_axi_rready  => rready
    );

  i_system : entity work.gc_system
    generic map (
      lanes_g           => lanes_g,
      clock_hz_g        => clock_hz_g,
      filter_samples_g  => filter_samples_g,
      speed_timeout_g   => speed_timeout_g,
      reversal_clocks_g => reversal_clocks_g,
      dither_clocks_g   => dither_clocks_g,
      loadable_g        => loadable_g,
      clock_watch_g     => clock_watch_g,
      two_paths_g       => two_paths_g,
      brake_feedback_g  => brake_feedback_g,
      brake_test_g      => brake_test_g,
      guard_g           => guard_g,
      twin_g            => twin_g,
      motion_g          => motion_g,
      record_bits_g     => record_bits_g
    )
    port map (
      s_axi_aclk    => bus_clk,
      s_axi_aresetn => bus_rst_n,
      s_axi_awaddr  => awaddr,
      s_axi_awprot  => awprot,
      s_axi_awvalid => awvalid,
      s_axi_awready => awready,
      s_axi_wdata   => wdata,
      s_axi_wstrb   => wstrb,
      s_axi_wvalid  => wvalid,
      s_axi_wready  => wready,
      s_axi_bresp   => bresp,
      s_axi_bvalid  => bvalid,
      s_axi_bready  => bready,
      s_axi_araddr  => araddr,
      s_axi_arprot  => arprot,
      s_axi_arvalid => arvalid,
      s_axi_arready => arready,
      s_axi_rdata   => rdata,
      s_axi_rresp   => rresp,
      s_axi_rvalid  => rvalid,
      s_axi_rready  => rready,
      irq           => irq,
      clk           => clk,
      pin_a         => pin_a,
      pin_b         => pin_b,
      pin_z         => pin_z,
      pin_error     => pin_error,
      estop_n       => estop_n,
      drive_valid   => drive_valid,
      drive_current => drive_current,
      drive_enable  => drive_enable,
      brake_release => brake_release,
      brake_engage  => brake_engage,
      brake_fed     => brake_fed,
      sense_valid   => sense_valid,
      sense_current => sense_current
    );

end architecture rtl;
