// Claim of gc_recorder about its trigger, for every mode and every level.
module recorder_trigger (
    input clk,
    input rst,
    input [1:0] cfg_mode,
    input in_trigger
);

  localparam OFF = 0, FAULT = 3;

  wire triggered;

  gc_recorder dut (
      .clk(clk), .rst(rst), .cfg_mode(cfg_mode), .in_trigger(in_trigger), .sts_triggered(triggered)
  );

  // The mode that is recorded in, and whether its trigger came.
  reg [1:0] mode = OFF;
  reg came = 0;

  always @(posedge clk) begin
    mode <= rst ? OFF : cfg_mode;
    came <= !rst && !(cfg_mode != mode && cfg_mode != OFF) && (came || in_trigger && mode == FAULT);
  end

  always @* trigger_is_kept_till_recording_begins_anew : assert (triggered == came);

endmodule
