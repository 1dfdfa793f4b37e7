// Claims of gc_motion_bus about what passes between a host and its two blocks of registers, for every host, every core
// and every block behind it that answers a write once its data have come: nothing is asked or answered twice, nothing is
// lost, and what there is none of is refused.
//
// Registers have no value before the first reset: claims start there. ANSWER: clocks with rready and bready, not
// necessarily in succession, within which a write to its own block is answered.
module motion_bus_access #(
    parameter ANSWER = 1
) (
    input clk,
    input rst,
    input [11:0] awaddr,
    input awvalid,
    input [31:0] wdata,
    input [3:0] wstrb,
    input wvalid,
    input bready,
    input [11:0] araddr,
    input arvalid,
    input rready,
    input block_awready,
    input block_wready,
    input [1:0] block_bresp,
    input block_bvalid,
    input block_arready,
    input [31:0] block_rdata,
    input [1:0] block_rresp,
    input block_rvalid
);

  // Words of its own block: of a setting, of the command, which cannot be read, and of the state, which cannot be
  // written. From FREE on there is none.
  localparam [9:0] SETTING = 12'h800 >> 2, STATE = 12'hA00 >> 2, COMMAND = 12'hA04 >> 2, FREE = 12'hC00 >> 2;
  localparam [1:0] OKAY = 0, SLVERR = 2;

  wire awready, wready, bvalid, arready, rvalid;
  wire [1:0] bresp, rresp;
  wire [31:0] rdata, setting;
  wire to_block_aw, to_block_w, to_block_b, to_block_ar, to_block_r, move;

  // The write and the read under way, and the words they are of; a write whose data have not come.
  reg known = 0, writing = 0, due = 0, reading = 0;
  reg [9:0] written = 0, read = 0;
  wire w_own = written[9], r_own = read[9];
  wire block_answers = block_bvalid && !due;
  // What the setting was given; a write that asks for a move, and whether that has come.
  reg [31:0] given = 0;
  reg asks = 0, moved = 0;
  // Clocks that a write to the own block has waited; responses of that block which were not taken.
  reg [3:0] waited = 0;
  reg b_waits = 0, r_waits = 0;
  reg [1:0] bresp_1 = 0, rresp_1 = 0;
  reg [31:0] rdata_1 = 0;
  integer i;

  gc_motion_bus dut (
      .clk(clk), .rst(rst), .s_axi_awaddr(awaddr), .s_axi_awprot(3'b0), .s_axi_awvalid(awvalid),
      .s_axi_awready(awready), .s_axi_wdata(wdata), .s_axi_wstrb(wstrb), .s_axi_wvalid(wvalid),
      .s_axi_wready(wready), .s_axi_bresp(bresp), .s_axi_bvalid(bvalid), .s_axi_bready(bready),
      .s_axi_araddr(araddr), .s_axi_arprot(3'b0), .s_axi_arvalid(arvalid), .s_axi_arready(arready),
      .s_axi_rdata(rdata), .s_axi_rresp(rresp), .s_axi_rvalid(rvalid), .s_axi_rready(rready),
      .m_axi_awvalid(to_block_aw), .m_axi_awready(block_awready), .m_axi_wvalid(to_block_w),
      .m_axi_wready(block_wready), .m_axi_bresp(block_bresp), .m_axi_bvalid(block_answers),
      .m_axi_bready(to_block_b), .m_axi_arvalid(to_block_ar), .m_axi_arready(block_arready),
      .m_axi_rdata(block_rdata), .m_axi_rresp(block_rresp), .m_axi_rvalid(block_rvalid), .m_axi_rready(to_block_r),
      .out_settings_move_ticks(setting), .out_move(move)
  );

  always @(posedge clk) begin
    known <= known || rst;
    if (move) moved <= 1;
    if (bvalid && bready) {writing, asks, moved} <= 0;
    if (wvalid && wready) begin
      due <= 0;
      asks <= written == COMMAND && wstrb[0] && wdata[0];
      if (written == SETTING) for (i = 0; i < 4; i = i + 1) if (wstrb[i]) given[8*i+:8] <= wdata[8*i+:8];
    end
    if (awvalid && awready) {writing, due, written} <= {2'b11, awaddr[11:2]};
    if (rvalid && rready) reading <= 0;
    if (arvalid && arready) {reading, read} <= {1'b1, araddr[11:2]};
    waited <= writing && !due && w_own && !bvalid ? waited + (rready && bready) : 0;
    b_waits <= w_own && bvalid && !bready;
    r_waits <= r_own && rvalid && !rready;
    {bresp_1, rresp_1, rdata_1} <= {bresp, rresp, rdata};
    if (rst || !known) {writing, due, reading, given, asks, moved, waited, b_waits, r_waits} <= 0;
  end

  always @* if (known) begin
    write_to_the_block_is_passed_on :
    assert (to_block_aw == (awvalid && !awaddr[11] && !writing) && to_block_w == (wvalid && due && !w_own));
    write_waits_for_the_block :
    assert ((awaddr[11] || awready == (block_awready && !writing)) && (w_own || wready == (block_wready && due)));
    data_are_taken_once : assert (!wready || due);
    write_is_answered_once : assert (!bvalid || writing && !due);
    block_answers_its_writes :
    assert (!(writing && !w_own) || bvalid == block_answers && (!bvalid || bresp == block_bresp));
    answer_to_a_write_is_passed_on : assert (to_block_b == (bready && writing && !w_own));
    own_writes_are_answered : assert (waited < ANSWER);
    own_answer_to_a_write_holds : assert (!b_waits || bvalid && bresp == bresp_1);
    write_to_no_register_is_refused : assert (!(bvalid && (written >= FREE || written == STATE)) || bresp == SLVERR);
    write_to_a_register_is_not : assert (!(bvalid && (written == SETTING || written == COMMAND)) || bresp == OKAY);
    setting_is_as_it_was_written : assert (writing && !bvalid || setting == given);
    moves_as_it_was_commanded : assert (!move || asks && !moved);
    no_command_is_lost : assert (!(bvalid && asks) || move || moved);
    read_of_the_block_is_passed_on : assert (to_block_ar == (arvalid && !araddr[11] && !reading));
    read_waits_for_the_block : assert (araddr[11] || arready == (block_arready && !reading));
    read_is_answered_once : assert (!rvalid || reading);
    block_answers_its_reads :
    assert (!(reading && !r_own) || rvalid == block_rvalid && (!rvalid || {rresp, rdata} == {block_rresp, block_rdata}));
    answer_to_a_read_is_passed_on : assert (to_block_r == (rready && reading && !r_own));
    own_answer_to_a_read_holds : assert (!r_waits || rvalid && {rresp, rdata} == {rresp_1, rdata_1});
    read_of_no_register_is_refused : assert (!(rvalid && (read >= FREE || read == COMMAND)) || rresp == SLVERR);
    read_of_a_register_is_not : assert (!(rvalid && (read == SETTING || read == STATE)) || rresp == OKAY);
  end

endmodule
