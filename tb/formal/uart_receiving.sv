// Claims of gc_uart about when it receives, for every level of its line in every clock.
module uart_receiving (
    input clk,
    input rst,
    input pin_rx
);

  wire out_valid, receiving;

  gc_uart dut (.clk(clk), .rst(rst), .pin_rx(pin_rx), .out_valid(out_valid), .sts_receiving(receiving));

  // The clocks before: levels of the line, and whether a character was being received.
  reg [2:0] levels = 0;
  reg receiving_1 = 0, rst_1 = 1;

  always @(posedge clk) begin
    levels <= {levels, pin_rx};
    {receiving_1, rst_1} <= {receiving, rst};
  end

  always @* begin
    reception_begins_as_the_line_falls : assert (!receiving || receiving_1 || !levels[2]);
    character_comes_as_its_reception_ends : assert (!out_valid || receiving_1 && !receiving);
    reset_ends_a_reception : assert (!rst_1 || !receiving && !out_valid);
  end

endmodule
