// Claims of gc_tick about its period and its count of missed ticks, for every behaviour of its inputs.
module tick (
    input clk,
    input rst,
    input cfg_enable,
    input [31:0] cfg_clocks,
    input in_ready
);

  wire out_valid;
  wire [31:0] missed;

  gc_tick dut (
      .clk(clk), .rst(rst), .cfg_enable(cfg_enable), .cfg_clocks(cfg_clocks), .in_ready(in_ready),
      .out_valid(out_valid), .sts_missed(missed)
  );

  // Clocks since the last tick, since cfg_enable rose, or since reset; this one included.
  reg [31:0] elapsed = 1;
  // The clock before.
  reg rst_1 = 1, due_1 = 0, late_1 = 0, valid_1 = 0, ready_1 = 0;
  reg [31:0] missed_1 = 0;

  wire due = !rst && cfg_enable && elapsed >= cfg_clocks;

  always @(posedge clk) begin
    elapsed <= rst || !cfg_enable || due ? 1 : elapsed + 1;
    rst_1 <= rst;
    due_1 <= due;
    valid_1 <= out_valid;
    ready_1 <= in_ready;
    missed_1 <= missed;
  end

  always @* begin
    none_early_or_unasked : assert (!out_valid || due_1);
    none_left_out : assert (out_valid || !due_1);
    missed_ticks_are_counted : assert (rst_1 || missed == missed_1 + (valid_1 && !ready_1));
    reset_clears : assert (!rst_1 || !out_valid && missed == 0);
    time_never_wraps : assert (elapsed != 0);
  end

endmodule
