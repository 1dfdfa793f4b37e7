// Claims of gc_bus_side about its AXI4-Lite port, for every behaviour of the bus master and of the core, whose ports are
// left open.
//
// Registers have no value before the first reset: claims start there. ANSWER: clocks with rready and bready, not
// necessarily in succession, within which the oldest request of a kind is answered.
module axi #(
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
    input rready
);

  wire awready, wready, bvalid, arready, rvalid;
  wire [1:0] bresp, rresp;
  wire [31:0] rdata;

  gc_bus_side dut (
      .clk(clk), .rst(rst), .s_axi_awaddr(awaddr), .s_axi_awprot(3'b0), .s_axi_awvalid(awvalid),
      .s_axi_awready(awready), .s_axi_wdata(wdata), .s_axi_wstrb(wstrb), .s_axi_wvalid(wvalid),
      .s_axi_wready(wready), .s_axi_bresp(bresp), .s_axi_bvalid(bvalid), .s_axi_bready(bready),
      .s_axi_araddr(araddr), .s_axi_arprot(3'b0), .s_axi_arvalid(arvalid), .s_axi_arready(arready),
      .s_axi_rdata(rdata), .s_axi_rresp(rresp), .s_axi_rvalid(rvalid), .s_axi_rready(rready)
  );

  // Requests taken and not yet answered. A write is one when both its address and its data are.
  reg known = 0;
  reg [2:0] reads = 0, addresses = 0, data = 0;
  wire write = addresses != 0 && data != 0;

  // Clocks that the oldest request has waited while the master would have taken any response.
  reg [5:0] read_waited = 0, write_waited = 0;
  wire takes = rready && bready;

  // Responses that the master has not taken in the clock before.
  reg b_waits = 0, r_waits = 0;
  reg [1:0] bresp_1, rresp_1;
  reg [31:0] rdata_1;

  always @(posedge clk) begin
    known <= known || rst;
    reads <= reads + (arvalid && arready) - (rvalid && rready);
    addresses <= addresses + (awvalid && awready) - (bvalid && bready);
    data <= data + (wvalid && wready) - (bvalid && bready);
    read_waited <= rvalid || reads == 0 ? 0 : read_waited + takes;
    write_waited <= bvalid || !write ? 0 : write_waited + takes;
    b_waits <= bvalid && !bready;
    r_waits <= rvalid && !rready;
    {bresp_1, rresp_1, rdata_1} <= {bresp, rresp, rdata};
    if (rst || !known) begin
      {reads, addresses, data, read_waited, write_waited, b_waits, r_waits} <= 0;
    end
  end

  always @* if (known) begin
    no_read_response_without_request : assert (!rvalid || reads != 0);
    no_write_response_without_request : assert (!bvalid || write);
    reads_are_answered : assert (read_waited < ANSWER);
    writes_are_answered : assert (write_waited < ANSWER);
    three_requests_of_a_kind_at_most : assert (reads <= 3 && addresses <= 3 && data <= 3);
    write_response_holds : assert (!b_waits || bvalid && bresp == bresp_1);
    read_response_holds : assert (!r_waits || rvalid && {rresp, rdata} == {rresp_1, rdata_1});
  end

endmodule
