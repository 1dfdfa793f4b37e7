// Claims of gc_uart about what it receives from a sender of its own rate, itself: every character, whole, once. For every
// sequence of characters and resets, at 8 clocks per bit and BITS bits per character.
module uart_received #(
    parameter BITS = 10
) (
    input clk,
    input rst,
    input in_valid,
    input [7:0] in_data
);

  wire line, out_valid, out_error, receiving, in_ready;
  wire [7:0] out_data;

  gc_uart dut (
      .clk(clk), .rst(rst), .pin_rx(line), .pin_tx(line), .out_valid(out_valid), .out_data(out_data),
      .out_error(out_error), .sts_receiving(receiving), .in_valid(in_valid), .in_ready(in_ready), .in_data(in_data)
  );

  // The character on its way, whether it has come, and clocks since the line was high after a reset.
  reg [7:0] data = 0;
  reg waits = 0;
  reg [2:0] high = 0;
  wire rested = high == 7;

  always @(posedge clk) begin
    high <= rst ? 0 : rested ? high : high + 1;
    if (in_valid && in_ready) begin
      data <= in_data;
      waits <= rested;
    end else if (out_valid) waits <= 0;
    if (rst) waits <= 0;
  end

  always @* begin
    what_comes_is_what_was_sent : assert (!out_valid || !waits || out_data == data && !out_error);
    one_has_come_before_the_next_is_taken : assert (!(in_ready && in_valid) || !waits);
  end

endmodule
