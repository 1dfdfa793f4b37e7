// Claims of gc_motion_bus about words of records, for every host that keeps to AXI4-Lite, every block behind it, and every
// core that answers what it was asked once, in any time, and whose clock may stand.
//
// Registers have no value before the first reset: claims start there.
module motion_bus (
    input clk,
    input rst,
    input [11:0] any_araddr,
    input any_arvalid,
    input rready,
    input block_arready,
    input [31:0] block_rdata,
    input block_rvalid,
    input alive,
    input answers,
    input [31:0] answer
);

  wire arready, rvalid, block_arvalid, turn;
  wire [1:0] rresp;
  wire [31:0] rdata;
  wire [5:0] address;

  // A request that waits stays.
  reg ar_waits = 0;
  reg [11:0] araddr_1 = 0;
  wire arvalid = ar_waits || any_arvalid;
  wire [11:0] araddr = ar_waits ? araddr_1 : any_araddr;

  // The core: its last answer, and of which question.
  reg fetched = 0;
  reg [31:0] word = 0;
  reg [5:0] of = 0;

  gc_motion_bus dut (
      .clk(clk), .rst(rst), .s_axi_awvalid(1'b0), .s_axi_wvalid(1'b0), .s_axi_bready(1'b0), .s_axi_araddr(araddr),
      .s_axi_arprot(3'b0), .s_axi_arvalid(arvalid), .s_axi_arready(arready), .s_axi_rdata(rdata),
      .s_axi_rresp(rresp), .s_axi_rvalid(rvalid), .s_axi_rready(rready), .m_axi_arvalid(block_arvalid),
      .m_axi_arready(block_arready), .m_axi_rdata(block_rdata), .m_axi_rvalid(block_rvalid), .in_alive(alive),
      .in_state_fetched(fetched), .in_state_word(word), .out_fetch_turn(turn), .out_fetch_address(address)
  );

  (* hierconn *) wire \dut.failed , \dut.told , \dut.i_split.reading ;

  reg known = 0;
  // A read of a word was taken: its word, and whether the core had answered it. The clock before.
  reg reads = 0, good = 0, stood = 0;
  reg [31:0] right = 0;
  reg turn_1 = 0, rst_1 = 0, r_waits = 0;
  reg [5:0] address_1 = 0;
  reg [31:0] rdata_1 = 0;
  reg [2:0] waited = 0;
  wire is_word = araddr[11:8] == 4'hB;
  wire wants = arvalid && is_word;
  wire settled = fetched == turn && of == address;

  always @(posedge clk) begin
    known <= known || rst;
    ar_waits <= arvalid && !arready;
    araddr_1 <= araddr;
    if (fetched != turn && answers) {fetched, word, of} <= {turn, answer, address};
    {turn_1, address_1, rst_1} <= {turn, address, rst};
    stood <= wants && !arready && (stood || !alive);
    if (arvalid && arready) begin
      reads <= is_word;
      good <= settled && of == araddr[7:2];
      right <= word;
    end else if (rvalid && rready) reads <= 0;
    r_waits <= reads && rvalid && !rready;
    rdata_1 <= rdata;
    // Clocks that a read of a word waits with nothing to wait for.
    waited <= wants && !arready && !\dut.i_split.reading && (fetched == turn || !alive) ? waited + 1 : 0;
    if (rst) {ar_waits, reads, r_waits, waited, stood} <= 0;
  end

  always @* if (known) begin
    word_is_that_of_the_read : assert (!(reads && rvalid && rresp == 0) || good && rdata == right);
    error_only_where_the_clock_stood : assert (!(wants && !stood) || !\dut.failed  || !\dut.told );
    one_question_at_a_time : assert (turn == turn_1 || rst_1 || fetched == turn_1 );
    question_holds : assert (turn != turn_1 || rst_1 || address == address_1);
    nothing_is_asked_but_for_a_word : assert (block_arvalid == (arvalid && !araddr[11] && !\dut.i_split.reading ));
    word_is_told_in_time : assert (waited < 5);
    response_holds : assert (!r_waits || rvalid && rdata == rdata_1);
  end

endmodule
