// Claims of gc_recorder with one axis and room for two records about its ring, for every mode, tick, trigger and drop.
module recorder #(
    parameter CAPACITY = 2
) (
    input clk,
    input rst,
    input [1:0] cfg_mode,
    input [3:0] cfg_ticks,
    input cfg_mean,
    input [3:0] cfg_before,
    input in_valid,
    input [31:0] in_tick,
    input in_trigger,
    input sense_valid,
    input [3:0] read_addr,
    input in_drop
);

  wire [3:0] records;
  wire [31:0] lost, read_word;
  wire triggered, done;
  (* hierconn *) wire [3:0] \dut.valid ;
  (* hierconn *) wire [3:0] \dut.oldest , \dut.newest ;
  (* hierconn *) wire \dut.keep ;
  (* hierconn *) wire [2:0] \dut.index_3 ;
  (* hierconn *) wire [1:0] \dut.mode ;

  gc_recorder dut (
      .clk(clk), .rst(rst), .cfg_mode(cfg_mode), .cfg_ticks(cfg_ticks), .cfg_mean(cfg_mean), .cfg_before(cfg_before),
      .in_valid(in_valid), .in_tick(in_tick), .in_status(30'd0), .in_count(32'd0), .in_period(32'd0),
      .in_command(32'd0), .in_force(32'd0), .in_trigger(in_trigger), .sense_valid(sense_valid),
      .sense_current(32'd0), .read_addr(read_addr), .read_word(read_word), .in_drop(in_drop), .sts_records(records),
      .sts_lost(lost), .sts_triggered(triggered), .sts_done(done)
  );

  // Words of whole records (7 each; a product would be cut), and the place of a word that is written, from the oldest on.
  wire [3:0] kept = (records << 3) - records;
  wire [3:0] apart = \dut.newest - \dut.oldest ;
  wire [3:0] place = \dut.newest + \dut.index_3 - \dut.oldest ;
  // The clock before.
  reg rst_1 = 1, done_1 = 0, begins_1 = 0;
  reg [1:0] mode_1 = 0;
  reg [3:0] records_1 = 0;
  reg [31:0] lost_1 = 0;

  always @(posedge clk) begin
    rst_1 <= rst;
    done_1 <= done;
    mode_1 <= \dut.mode ;
    begins_1 <= cfg_mode != \dut.mode ;
    records_1 <= records;
    lost_1 <= lost;
  end

  always @* begin
    never_more_than_fit : assert (records <= CAPACITY);
    places_follow_the_records : assert (apart == kept);
    kept_words_are_never_overwritten : assert (!(\dut.valid [0] && \dut.keep ) || place >= kept);
    off_and_done_record_nothing : assert (!(mode_1 == 0 || done_1) || records <= records_1);
    one_at_a_time : assert (records <= records_1 + 1);
    only_free_running_loses : assert (rst_1 || begins_1 || lost == lost_1 || mode_1 == 1 && lost == lost_1 + 1);
  end

endmodule
