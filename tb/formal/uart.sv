// Claims of gc_uart about what it sends, for every sequence of characters and resets, at BITS bits per character (start and
// stop included, a parity bit if 11) and 8 clocks per bit. They are inductive as they stand.
module uart #(
    parameter BITS = 10,
    parameter ODD = 0
) (
    input clk,
    input rst,
    input rx,
    input in_valid,
    input [7:0] in_data
);

  localparam CLOCKS = 8 * BITS;

  wire tx, out_valid, out_error, receiving, in_ready;
  wire [7:0] out_data;
  (* hierconn *) wire [2:0] \dut.tx_phase ;
  (* hierconn *) wire [3:0] \dut.tx_left ;
  (* hierconn *) wire [8:0] \dut.tx_bits ;

  gc_uart dut (
      .clk(clk), .rst(rst), .pin_rx(rx), .pin_tx(tx), .out_valid(out_valid), .out_data(out_data),
      .out_error(out_error), .sts_receiving(receiving), .in_valid(in_valid), .in_ready(in_ready), .in_data(in_data)
  );

  // The character on its way, and clocks since it was taken; CLOCKS: it is sent.
  reg [7:0] data = 0;
  reg [6:0] sent = CLOCKS;
  wire [3:0] place = sent[6:3];
  wire parity = ^data ^ (ODD != 0);
  // From the start bit on, ones behind it.
  wire [15:0] bits = {6'b111111, BITS == 11 ? parity : 1'b1, data, 1'b0};
  // What is behind the bit on the line.
  wire [17:0] left = {9'h1FF, parity, data} >> place;

  always @(posedge clk) begin
    sent <= sent == CLOCKS ? sent : sent + 1;
    if (in_valid && in_ready) begin
      data <= in_data;
      sent <= 0;
    end
    if (rst) sent <= CLOCKS;
  end

  always @* begin
    line_is_that_of_the_character : assert (tx == (sent == CLOCKS || bits[place]));
    next_one_is_taken_when_all_is_sent : assert (in_ready == (sent == CLOCKS));
    time_goes_along : assert (sent <= CLOCKS && \dut.tx_left == (sent == CLOCKS ? 0 : BITS - place));
    phase_goes_along : assert (sent == CLOCKS || \dut.tx_phase == sent[2:0]);
    bits_go_along : assert (sent == CLOCKS || place > 8 || \dut.tx_bits == left[8:0]);
  end

endmodule
