// Claims of gc_modbus with gap_clocks_g = 2, for every sequence of characters and every bus that answers only what it was
// asked. The bytes that it keeps are free: no claim is about what they are. They are inductive as they stand.
module modbus #(
    parameter UNIT = 1,
    parameter GAP = 2
) (
    input clk,
    input rst,
    input rx_valid,
    input [7:0] rx_data,
    input rx_error,
    input rx_receiving,
    input tx_ready,
    input awready,
    input wready,
    input [1:0] bresp,
    input b,
    input arready,
    input [31:0] rdata,
    input [1:0] rresp,
    input r
);

  wire tx_valid, tx_enable, awvalid, wvalid, bready, arvalid, rready;
  wire [7:0] tx_data;
  wire [11:0] awaddr, araddr;
  wire [31:0] wdata;
  wire [3:0] wstrb;
  wire [2:0] awprot, arprot;

  // A write whose address and data were taken, a read whose address was.
  reg addressed = 0, filled = 0, asked = 0;
  wire bvalid = b && addressed && filled, rvalid = r && asked;

  gc_modbus dut (
      .clk(clk), .rst(rst), .rx_valid(rx_valid), .rx_data(rx_data), .rx_error(rx_error), .rx_receiving(rx_receiving),
      .tx_valid(tx_valid), .tx_ready(tx_ready), .tx_data(tx_data), .tx_enable(tx_enable), .m_axi_awaddr(awaddr),
      .m_axi_awprot(awprot), .m_axi_awvalid(awvalid), .m_axi_awready(awready), .m_axi_wdata(wdata),
      .m_axi_wstrb(wstrb), .m_axi_wvalid(wvalid), .m_axi_wready(wready), .m_axi_bresp(bresp), .m_axi_bvalid(bvalid),
      .m_axi_bready(bready), .m_axi_araddr(araddr), .m_axi_arprot(arprot), .m_axi_arvalid(arvalid),
      .m_axi_arready(arready), .m_axi_rdata(rdata), .m_axi_rresp(rresp), .m_axi_rvalid(rvalid), .m_axi_rready(rready)
  );

  (* hierconn *) wire [15:0] \dut.crc ;
  (* hierconn *) wire \dut.bad ;
  (* hierconn *) wire [8:0] \dut.length ;
  (* hierconn *) wire \dut.silence ;
  (* hierconn *) wire [87:0] \dut.head ;
  (* hierconn *) wire [3:0] \dut.state ;
  (* hierconn *) wire \dut.writing , \dut.reading ;

  // Its states, in their order.
  localparam IDLE = 0, RECEIVE = 1, CHECK = 2, WRITE = 6, ANSWER = 11, DRAIN = 15;

  // What is heard: a frame (HEAR), whether it is right (JUDGE), nothing until it is answered (DEAF), nothing for a clock
  // before the next one (PASS).
  localparam HEAR = 0, JUDGE = 1, DEAF = 2, PASS = 3;
  reg [1:0] ear = PASS;
  reg [15:0] crc = 16'hFFFF;
  reg [8:0] length = 0;
  reg silence = 0;
  reg bad = 0, mine = 0;

  function [15:0] step(input [15:0] before, input [7:0] data);
    integer k;
    begin
      step = before ^ data;
      for (k = 0; k < 8; k = k + 1) step = step[0] ? step >> 1 ^ 16'hA001 : step >> 1;
    end
  endfunction

  // The clock before.
  reg aw_waits = 0, w_waits = 0, ar_waits = 0, tx_waits = 0;
  reg [11:0] awaddr_1 = 0, araddr_1 = 0;
  reg [31:0] wdata_1 = 0;
  // A write was refused in this frame.
  reg refused = 0, write_1 = 0, read_1 = 0;

  always @(posedge clk) begin
    if (ear == HEAR && rx_valid) begin
      crc <= step(crc, rx_data);
      bad <= bad || rx_error || length == 256;
      if (length == 0) mine <= rx_data == UNIT;
      if (length != 256) length <= length + 1;
      silence <= 0;
    end else if (ear == HEAR && length != 0 && !rx_receiving) begin
      silence <= silence + 1;
      if (silence == GAP - 1) ear <= JUDGE;
    end
    if (ear == JUDGE) ear <= crc == 0 && !bad && length >= 4 && mine ? DEAF : PASS;
    if (\dut.state == DRAIN && tx_ready) ear <= PASS;
    if (ear == PASS) ear <= HEAR;
    if (ear == PASS) begin
      crc <= 16'hFFFF;
      length <= 0;
      silence <= 0;
      bad <= 0;
    end
    if (\dut.state == WRITE && bvalid && bresp != 0) refused <= 1;
    if (ear == PASS) refused <= 0;
    addressed <= addressed && !bvalid || awvalid && awready;
    filled <= filled && !bvalid || wvalid && wready;
    asked <= asked && !rvalid || arvalid && arready;
    aw_waits <= awvalid && !awready;
    w_waits <= wvalid && !wready;
    ar_waits <= arvalid && !arready;
    tx_waits <= tx_valid && !tx_ready;
    write_1 <= awvalid;
    read_1 <= arvalid;
    {awaddr_1, wdata_1, araddr_1} <= {awaddr, wdata, araddr};
    if (rst) begin
      ear <= PASS;
      {addressed, filled, asked, aw_waits, w_waits, ar_waits, tx_waits, refused, write_1, read_1} <= 0;
    end
  end

  wire hears = ear == HEAR || ear == JUDGE;

  always @* begin
    only_a_right_frame_is_carried_out :
    assert ((ear == HEAR) == (\dut.state == RECEIVE) && (ear == JUDGE) == (\dut.state == CHECK)
            && (ear == PASS) == (\dut.state == IDLE));
    crc_is_that_of_the_frame : assert (!hears || crc == \dut.crc && bad == \dut.bad );
    length_is_that_of_the_frame : assert (!hears || length == \dut.length && length <= 256);
    silence_is_that_of_the_line : assert (ear != HEAR || silence == \dut.silence );
    unit_is_that_of_the_frame : assert (!hears || length == 0 || mine == (\dut.head [87:80] == UNIT));
    no_write_but_of_a_right_frame : assert (!awvalid || write_1 || ear == DEAF);
    no_read_but_for_a_right_frame : assert (!arvalid || read_1 || ear == DEAF);
    no_answer_but_to_a_right_frame : assert (!tx_enable || ear == DEAF);
    accesses_are_of_whole_words : assert (awaddr[1:0] == 0 && araddr[1:0] == 0);
    no_access_has_a_protection : assert (awprot == 0 && arprot == 0);
    address_waits_for_the_bus : assert (!aw_waits || awvalid && awaddr == awaddr_1);
    data_waits_for_the_bus : assert (!w_waits || wvalid && wdata == wdata_1);
    read_waits_for_the_bus : assert (!ar_waits || arvalid && araddr == araddr_1);
    one_write_at_a_time :
    assert (\dut.writing == (awvalid || addressed) && \dut.writing == (wvalid || filled) && !(awvalid && addressed)
            && !(wvalid && filled));
    one_read_at_a_time : assert (\dut.reading == (arvalid || asked) && !(arvalid && asked));
    no_write_follows_a_refused_one :
    assert (!refused || !\dut.writing && (\dut.state >= ANSWER || \dut.state == IDLE));
    character_waits_for_the_line : assert (!tx_waits || tx_valid);
  end

endmodule
