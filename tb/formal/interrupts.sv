// Claims of gc_bus_side about its interrupt: the first event after reset is not lost, whatever the master writes when,
// unless to the bit of the event.
//
// Of the three events one is watched, any of them. Until `go` the master can only enable its interrupt, and does; from
// then on it reads and writes anything, but leaves that bit alone in both registers.
module interrupts (
    input clk,
    input rst,
    input [1:0] which,
    input start,
    input [11:0] awaddr,
    input awvalid,
    input [31:0] wdata,
    input [3:0] wstrb,
    input wvalid,
    input bready,
    input [11:0] araddr,
    input arvalid,
    input rready,
    input in_valid,
    input [31:0] number,
    input [7:0] fault_events,
    input [31:0] missed,
    input out_ready
);

  localparam [11:0] ENABLE = 12'h600, STATUS = 12'h604;

  wire awready, wready, bvalid, irq;
  reg known = 0, go = 0, enabled = 0;
  reg [31:0] watched;
  reg [2:0] addresses = 0, data = 0;

  // Addresses are of words: the lowest two bits count for nothing.
  wire [11:0] address = !go ? ENABLE : awaddr[11:2] == ENABLE[11:2] ? STATUS : awaddr;
  wire idle = addresses == 0 && data == 0 && !awvalid && !wvalid;

  gc_bus_side dut (
      .clk(clk), .rst(rst), .s_axi_awaddr(address), .s_axi_awprot(3'b0), .s_axi_awvalid(awvalid),
      .s_axi_awready(awready), .s_axi_wdata(go ? wdata & ~watched : watched), .s_axi_wstrb(go ? wstrb : 4'hF),
      .s_axi_wvalid(wvalid), .s_axi_wready(wready), .s_axi_bvalid(bvalid), .s_axi_bready(bready),
      .s_axi_araddr(araddr), .s_axi_arprot(3'b0), .s_axi_arvalid(arvalid), .s_axi_rready(rready), .irq(irq),
      .out_ready(out_ready), .in_valid(in_valid), .in_state_number(number),
      .in_state_fault_events(fault_events), .in_state_missed(missed)
  );

  // What the last word of state said; an event, two clocks on its way to irq; whether one came.
  reg [31:0] number_1 = 0, missed_1 = 0;
  reg [7:0] fault_events_1 = 0;
  reg event_1 = 0, came = 0;
  wire [2:0] news = {missed != missed_1, fault_events != fault_events_1, number != number_1};

  always @(posedge clk) begin
    known <= known || rst;
    if (!known) watched <= which == 0 ? 1 : which == 1 ? 2 : 4;
    addresses <= addresses + (awvalid && awready) - (bvalid && bready);
    data <= data + (wvalid && wready) - (bvalid && bready);
    enabled <= enabled || bvalid && bready;
    go <= go || start && enabled && idle;
    if (in_valid) {number_1, missed_1, fault_events_1} <= {number, missed, fault_events};
    event_1 <= go && in_valid && (news & watched[2:0]) != 0;
    came <= came || event_1;
    if (rst || !known) {addresses, data, enabled, go, number_1, missed_1, fault_events_1, event_1, came} <= 0;
  end

  always @* if (known) begin
    no_event_is_lost : assert (!came || irq);
  end

endmodule
