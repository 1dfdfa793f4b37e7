// SPDX-License-Identifier: MIT
//
// What Verilator compiles: the core, the module `CORE, and beside it the master of its AXI4-Lite bus; or, with `SERIAL, a core
// whose registers are behind a serial line.
//
// At every eval Verilator goes through all logic that hangs on an input of its top, changed or not. What hangs on the bus is
// a third of the core: behind registers only the clock of the bus has it evaluated.

module cosim #(
    parameter AXES = 1
) (
    input clk,
    input bus_clk,
    input bus_rst_n,
    // An access begins when host_turn changes; word, address and data are then not to change until it has ended.
    input host_turn,
    input host_writes,
    input [31:0] host_address,
    input [31:0] host_word,
    output host_busy,
    output reg [31:0] host_data,
    output reg [1:0] host_error,
    // The line, high at rest.
    input pin_rx,
    output pin_tx,
    // Those of gc_system.
    input [AXES-1:0] pin_a,
    input [AXES-1:0] pin_b,
    input [AXES-1:0] pin_z,
    input estop_n,
    input [AXES-1:0] sense_valid,
    input [32*AXES-1:0] sense_current,
    output [32*AXES-1:0] drive_current,
    output drive_enable,
    output [AXES-1:0] brake_release,
    output [AXES-1:0] brake_engage
);

`define PINS .clk(clk), .pin_a(pin_a), .pin_b(pin_b), .pin_z(pin_z), .pin_error({AXES{1'b0}}), .estop_n(estop_n), \
      .brake_fed({AXES{1'b0}}), .sense_valid(sense_valid), .sense_current(sense_current), \
      .drive_valid(), .drive_current(drive_current), .drive_enable(drive_enable), \
      .brake_release(brake_release), .brake_engage(brake_engage)

`ifdef SERIAL

  reg rst = 1;

  always @(posedge bus_clk) rst <= !bus_rst_n;

  assign host_busy = 0;

  `CORE core (
      .bus_clk(bus_clk), .bus_rst(rst), .pin_rx(pin_rx), .pin_tx(pin_tx), .pin_tx_enable(), .irq(), `PINS
  );

`else

  // Valid of the requests and ready of the answers: what is still to come of the access.
  reg aw = 0, w = 0, b = 0, ar = 0, r = 0, turn = 0, rst_n = 0;
  reg [31:0] address;
  reg [31:0] word;

  wire awready, wready, bvalid, arready, rvalid;
  wire [1:0] bresp, rresp;
  wire [31:0] rdata;

  assign pin_tx = 1;
  assign host_busy = aw || w || b || ar || r || turn != host_turn;

  always @(posedge bus_clk) begin
    rst_n <= bus_rst_n;
    if (awready) aw <= 0;
    if (wready) w <= 0;
    if (arready) ar <= 0;
    if (b && bvalid) {b, host_error} <= {1'b0, bresp};
    if (r && rvalid) {r, host_error, host_data} <= {1'b0, rresp, rdata};
    if (turn != host_turn) begin
      {turn, address, word} <= {host_turn, host_address, host_word};
      {aw, w, b} <= {3{host_writes}};
      {ar, r} <= {2{!host_writes}};
    end
  end

  `CORE core (
      .s_axi_aclk(bus_clk), .s_axi_aresetn(rst_n),
      .s_axi_awvalid(aw), .s_axi_awready(awready), .s_axi_awaddr(address), .s_axi_awprot(3'd0),
      .s_axi_wvalid(w), .s_axi_wready(wready), .s_axi_wdata(word), .s_axi_wstrb(4'hF),
      .s_axi_bvalid(bvalid), .s_axi_bready(b), .s_axi_bresp(bresp),
      .s_axi_arvalid(ar), .s_axi_arready(arready), .s_axi_araddr(address), .s_axi_arprot(3'd0),
      .s_axi_rvalid(rvalid), .s_axi_rready(r), .s_axi_rdata(rdata), .s_axi_rresp(rresp), .irq(), `PINS
  );

`endif

endmodule
