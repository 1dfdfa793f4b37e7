// Claims of gc_register_split, for every host and every two blocks that answer a write once its data have come. They are
// inductive as they stand.
module register_split (
    input clk,
    input rst,
    input aw_high,
    input awvalid,
    input wvalid,
    input bready,
    input ar_high,
    input arvalid,
    input rready,
    input [1:0] block_awready,
    input [1:0] block_wready,
    input [1:0] answers,
    input [1:0] block_arready,
    input [1:0] block_rvalid
);

  wire awready, wready, bvalid, arready, rvalid, write_high, read_high;
  wire [1:0] block_awvalid, block_wvalid, block_bready, block_arvalid, block_rready;

  // An access whose address was taken and whose response has not gone, and its block; a write whose data have not come.
  reg writing = 0, due = 0, w_high = 0, reading = 0, r_high = 0;
  wire [1:0] block_bvalid = due ? 0 : answers;

  gc_register_split dut (
      .clk(clk), .rst(rst), .in_aw_high(aw_high), .in_awvalid(awvalid), .in_awready(awready), .in_wvalid(wvalid),
      .in_wready(wready), .in_bvalid(bvalid), .in_bready(bready), .in_ar_high(ar_high), .in_arvalid(arvalid),
      .in_arready(arready), .in_rvalid(rvalid), .in_rready(rready), .write_high(write_high), .read_high(read_high),
      .out_awvalid(block_awvalid), .out_awready(block_awready), .out_wvalid(block_wvalid), .out_wready(block_wready),
      .out_bvalid(block_bvalid), .out_bready(block_bready), .out_arvalid(block_arvalid),
      .out_arready(block_arready), .out_rvalid(block_rvalid), .out_rready(block_rready)
  );

  (* hierconn *) wire \dut.writing , \dut.data_due , \dut.reading ;

  always @(posedge clk) begin
    if (bvalid && bready) writing <= 0;
    if (wvalid && wready) due <= 0;
    if (awvalid && awready) {writing, due, w_high} <= {2'b11, aw_high};
    if (rvalid && rready) reading <= 0;
    if (arvalid && arready) {reading, r_high} <= {1'b1, ar_high};
    if (rst) {writing, due, reading} <= 0;
  end

  // A handshake as the block that it belongs to sees it, and no other.
  function [1:0] only(input high, input valid);
    only = valid << high;
  endfunction

  always @* begin
    one_access_of_a_kind_at_a_time :
    assert (\dut.writing == writing && \dut.data_due == due && \dut.reading == reading && (!due || writing));
    response_is_told_apart : assert ((!writing || write_high == w_high) && (!reading || read_high == r_high));
    address_of_a_write_goes_to_its_block : assert (block_awvalid == only(aw_high, awvalid && !writing));
    address_of_a_write_is_taken_by_its_block : assert (awready == (block_awready[aw_high] && !writing));
    data_follow_their_address : assert (block_wvalid == only(w_high, wvalid && due));
    data_are_taken_by_their_block : assert (wready == (block_wready[w_high] && due));
    write_is_answered_by_its_block : assert (bvalid == (block_bvalid[w_high] && writing));
    answer_to_a_write_is_taken_from_its_block : assert (block_bready == only(w_high, bready && writing));
    address_of_a_read_goes_to_its_block : assert (block_arvalid == only(ar_high, arvalid && !reading));
    address_of_a_read_is_taken_by_its_block : assert (arready == (block_arready[ar_high] && !reading));
    read_is_answered_by_its_block : assert (rvalid == (block_rvalid[r_high] && reading));
    answer_to_a_read_is_taken_from_its_block : assert (block_rready == only(r_high, rready && reading));
  end

endmodule
