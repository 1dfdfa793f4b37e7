// Claims of gc_timeout with its guard, for every restart and every limit that stays. BITS: bits_g.
module timeout #(
    parameter BITS = 4
) (
    input clk,
    input rst,
    input restart
);

  wire expired, upset;
  (* anyconst *) reg [BITS-1:0] limit;

  gc_timeout dut (.clk(clk), .rst(rst), .restart(restart), .cfg_clocks(limit), .expired(expired), .upset(upset));

  // Clocks in a row without a restart; stops one above the largest limit.
  reg [BITS:0] n_quiet = 0;

  always @(posedge clk) n_quiet <= rst || restart ? 0 : n_quiet[BITS] ? n_quiet : n_quiet + 1;

  always @* begin
    expires_after_the_limit : assert (n_quiet <= limit || expired);
    not_sooner : assert (n_quiet > limit || !expired);
    counts_what_it_counted : assert (!upset);
  end

endmodule
