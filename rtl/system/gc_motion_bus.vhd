-- SPDX-License-Identifier: MIT
--
-- The host's side of gc_motion: its registers beside those of gc_system, and the words of records that it sends.
--
-- AXI4-Lite comes from the host and goes on to gc_registers where the address is in the lower half; addresses, data and
-- strobes are wired past this. One write and one read may be under way.
-- A read of a word of a record asks the core for it and waits for the answer; while the core's clock stands it gets
-- SLVERR. Latency of such a read: one round trip of gc_crossing_bus, at most two; of others: see gc_register_split.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_facts_pkg.all;
  use work.gc_motion_registers_pkg.all;
  use work.gc_network_pkg.all;
  use work.gc_system_pkg.all;

entity gc_motion_bus is
  generic (
    -- Words of the recorder's ring, as a power of two.
    record_bits_g : positive
  );
  port (
    clk           : in    std_ulogic;
    -- Synchronous, active high.
    rst           : in    std_ulogic;
    -- The host, one write at a time.
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
    -- gc_registers.
    m_axi_awvalid : out   std_ulogic;
    m_axi_awready : in    std_ulogic;
    m_axi_wvalid  : out   std_ulogic;
    m_axi_wready  : in    std_ulogic;
    m_axi_bresp   : in    std_ulogic_vector(1 downto 0);
    m_axi_bvalid  : in    std_ulogic;
    m_axi_bready  : out   std_ulogic;
    m_axi_arvalid : out   std_ulogic;
    m_axi_arready : in    std_ulogic;
    m_axi_rdata   : in    std_ulogic_vector(31 downto 0);
    m_axi_rresp   : in    std_ulogic_vector(1 downto 0);
    m_axi_rvalid  : in    std_ulogic;
    m_axi_rready  : out   std_ulogic;
    -- The settings of this clock; one clock: move; the word of a record that is wanted.
    out_settings  : out   motion_settings_t;
    out_move      : out   std_ulogic;
    out_fetch     : out   fetch_t;
    -- The core's clock runs; its state.
    in_alive      : in    std_ulogic;
    in_state      : in    motion_state_t
  );
end entity gc_motion_bus;

architecture rtl of gc_motion_bus is

  -- Upper part of the addresses of the words of a record; the first of them; an address without a register.
  constant window_block_c : std_ulogic_vector(11 downto 8) := x"B";
  constant window_c       : std_ulogic_vector(11 downto 0) := window_block_c & x"00";
  constant no_register_c  : std_ulogic_vector(11 downto 0) := x"FFC";

  signal regs_in  : gc_motion_registers_in_t;
  signal regs_out : gc_motion_registers_out_t;

  signal awvalid    : std_ulogic_vector(1 downto 0);
  signal awready    : std_ulogic;
  signal wvalid     : std_ulogic_vector(1 downto 0);
  signal wready     : std_ulogic;
  signal bvalid     : std_ulogic;
  signal bready     : std_ulogic_vector(1 downto 0);
  signal bresp      : std_ulogic_vector(1 downto 0);
  signal arvalid    : std_ulogic_vector(1 downto 0);
  signal arready    : std_ulogic;
  signal araddr     : std_ulogic_vector(11 downto 0);
  signal rvalid     : std_ulogic;
  signal rready     : std_ulogic_vector(1 downto 0);
  signal rdata      : word_t;
  signal rresp      : std_ulogic_vector(1 downto 0);
  signal write_high : std_ulogic;
  signal read_high  : std_ulogic;

  -- A read of a word is to come, was asked for, is over: with its answer, or without.
  signal is_word     : std_ulogic;
  signal asking      : std_ulogic := '0';
  signal told        : std_ulogic := '0';
  signal failed      : std_ulogic := '0';
  signal fetch       : fetch_t := no_fetch_c;
  signal own_arvalid : std_ulogic;
  signal own_arready : std_ulogic;

begin

  assert 2 ** (window_block_c'low - 2) = record_window_c
    report "gc_motion_bus: the words of a record are not all of their block"
    severity failure;

  i_split : entity work.gc_register_split
    port map (
      clk            => clk,
      rst            => rst,
      in_aw_high     => s_axi_awaddr(11),
      in_awvalid     => s_axi_awvalid,
      in_awready     => s_axi_awready,
      in_wvalid      => s_axi_wvalid,
      in_wready      => s_axi_wready,
      in_bvalid      => s_axi_bvalid,
      in_bready      => s_axi_bready,
      in_ar_high     => s_axi_araddr(11),
      in_arvalid     => s_axi_arvalid,
      in_arready     => s_axi_arready,
      in_rvalid      => s_axi_rvalid,
      in_rready      => s_axi_rready,
      write_high     => write_high,
      read_high      => read_high,
      out_awvalid    => awvalid,
      out_awready(1) => awready,
      out_awready(0) => m_axi_awready,
      out_wvalid     => wvalid,
      out_wready(1)  => wready,
      out_wready(0)  => m_axi_wready,
      out_bvalid(1)  => bvalid,
      out_bvalid(0)  => m_axi_bvalid,
      out_bready     => bready,
      out_arvalid    => arvalid,
      out_arready(1) => own_arready,
      out_arready(0) => m_axi_arready,
      out_rvalid(1)  => rvalid,
      out_rvalid(0)  => m_axi_rvalid,
      out_rready     => rready
    );

  m_axi_awvalid <= awvalid(0);
  m_axi_wvalid <= wvalid(0);
  m_axi_bready <= bready(0);
  m_axi_arvalid <= arvalid(0);
  m_axi_rready <= rready(0);
  s_axi_bresp <= bresp when write_high = '1' else m_axi_bresp;
  s_axi_rdata <= rdata when read_high = '1' else m_axi_rdata;
  s_axi_rresp <= rresp when read_high = '1' else m_axi_rresp;

  -- Words of records

  is_word <= '1' when s_axi_araddr(window_block_c'range) = window_block_c else '0';
  own_arvalid <= arvalid(1) and (told or not is_word);
  own_arready <= arready and (told or not is_word);
  araddr <= s_axi_araddr when is_word = '0' else
            window_c when failed = '0' else
            no_register_c;

  p_fetch : process (clk) is
  begin

    if rising_edge(clk) then
      if arvalid(1) = '1' and is_word = '1' and told = '0' then
        -- One question at a time: the answer to one that was given up is not that to the next.
        if in_alive = '0' then
          asking <= '0';
          told <= '1';
          failed <= '1';
        elsif asking = '0' and in_state.fetched = fetch.turn then
          asking <= '1';
          fetch.turn <= not fetch.turn;
          fetch.address <= s_axi_araddr(7 downto 2);
        elsif asking = '1' and in_state.fetched = fetch.turn then
          asking <= '0';
          told <= '1';
          failed <= '0';
        end if;
      end if;
      if told = '1' and own_arvalid = '1' and arready = '1' then
        told <= '0';
      end if;
      if rst = '1' then
        asking <= '0';
        told <= '0';
        fetch <= no_fetch_c;
      end if;
    end if;

  end process p_fetch;

  out_fetch <= fetch;

  i_registers : entity work.gc_motion_registers
    port map (
      clk            => clk,
      rst            => rst,
      s_axil_awready => awready,
      s_axil_awvalid => awvalid(1),
      s_axil_awaddr  => s_axi_awaddr,
      s_axil_awprot  => s_axi_awprot,
      s_axil_wready  => wready,
      s_axil_wvalid  => wvalid(1),
      s_axil_wdata   => s_axi_wdata,
      s_axil_wstrb   => s_axi_wstrb,
      s_axil_bready  => bready(1),
      s_axil_bvalid  => bvalid,
      s_axil_bresp   => bresp,
      s_axil_arready => arready,
      s_axil_arvalid => own_arvalid,
      s_axil_araddr  => araddr,
      s_axil_arprot  => s_axi_arprot,
      s_axil_rready  => rready(1),
      s_axil_rvalid  => rvalid,
      s_axil_rdata   => rdata,
      s_axil_rresp   => rresp,
      hwif_in        => regs_in,
      hwif_out       => regs_out
    );

  -- Settings and the command

  out_move <= regs_out.motion_command.move.value;
  out_settings.move_ticks <= regs_out.move_ticks.value.value;
  out_settings.filter <= regs_out.servo_filter.ticks.value;
  out_settings.speed_feed <= regs_out.servo_filter.speed_feed.value;
  out_settings.record_mode <= regs_out.record_control.mode.value;
  out_settings.record_mean <= regs_out.record_control.mean.value;
  out_settings.record_ticks <= regs_out.record_control.ticks.value;
  out_settings.record_before <= regs_out.record_before.value.value;
  out_settings.record_taken <= regs_out.record_taken.value.value;

  -- State

  regs_in.motion_status.moves.next_q <= in_state.moves;
  regs_in.motion_status.ready.next_q <= in_state.ready;
  regs_in.motion_status.refused.next_q <= in_state.refused;
  regs_in.motion_status.following.next_q <= field_of(in_state.following);
  regs_in.record_status.mode.next_q <= in_state.record_mode;
  regs_in.record_status.triggered.next_q <= in_state.triggered;
  regs_in.record_status.done.next_q <= in_state.done;
  regs_in.record_status.address_bits.next_q <= std_ulogic_vector(to_unsigned(record_bits_g, 5));
  regs_in.record_count.value.next_q <= in_state.record_count;
  regs_in.record_lost.value.next_q <= in_state.record_lost;
  regs_in.record_word.value.next_q <= in_state.word;

  g_axis : for i in 0 to axes_c - 1 generate
    out_settings.target(i) <= regs_out.move_target(i).value.value;
    out_settings.speed_max(i) <= regs_out.speed_max(i).value.value;
    out_settings.acceleration_max(i) <= regs_out.acceleration_max(i).value.value;
    out_settings.proportional(i) <= regs_out.servo_proportional(i).value.value;
    out_settings.integral(i) <= regs_out.servo_integral(i).value.value;
    out_settings.derivative(i) <= regs_out.servo_derivative(i).value.value;
    out_settings.servo_limit(i) <= regs_out.servo_limit_ua(i).value.value;
    out_settings.following_max(i) <= regs_out.following_max(i).value.value;
    regs_in.setpoint(i).value.next_q <= in_state.setpoint(i);
    regs_in.correction_ua(i).value.next_q <= in_state.correction(i);
  end generate g_axis;

end architecture rtl;
