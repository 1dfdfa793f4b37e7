// Claims of gc_loader, for every sequence of words and commands.
// RECORDS, WORDS: records of each section of the image and words of a record, 16 bits each, section 0 lowest.
// BIAS_BITS, PHASE_BITS: see bank_switch.
module loader #(
    parameter SECTIONS = 6,
    parameter [16*SECTIONS-1:0] RECORDS = 0,
    parameter [16*SECTIONS-1:0] WORDS = 0,
    parameter BIAS_BITS = 38,
    parameter PHASE_BITS = 25,
    parameter SCALAR_BITS = 3 * (2 * 32 + 5 * 18 + BIAS_BITS + PHASE_BITS)
) (
    input clk,
    input rst,
    input load_begin,
    input load_valid,
    input [31:0] load_word,
    input load_commit,
    input [31:0] load_crc,
    input [1:0] in_bank
);

  localparam KEPT = (SCALAR_BITS + 31) / 32 * 32;
  // A number for each value of section.
  localparam [127:0] RECORDS_OF = RECORDS, WORDS_OF = WORDS;

  wire [1:0] memory_bank, bank;
  wire [5:0] write;
  wire write_bank, accept, bad;
  wire [15:0] index;
  wire [95:0] data;
  wire [31:0] crc;
  wire [95:0] count_low, count_high;
  wire [53:0] x_low, x_high, input_scale, output_scale;
  wire [3*BIAS_BITS-1:0] output_bias;
  wire [53:0] current_scale;
  wire [3*PHASE_BITS-1:0] phase_step;
  (* hierconn *) wire [SECTIONS:0] \dut.section ;
  (* hierconn *) wire [15:0] \dut.index , \dut.word ;
  (* hierconn *) wire \dut.is_loading ;
  wire [SCALAR_BITS-1:0] scalars = {phase_step, current_scale, output_scale, output_bias, x_high, x_low, input_scale,
                                    count_high, count_low};

  gc_loader dut (
      .clk(clk), .rst(rst), .load_begin(load_begin), .load_valid(load_valid), .load_word(load_word),
      .load_commit(load_commit), .load_crc(load_crc), .in_bank(in_bank), .memory_bank(memory_bank),
      .memory_write(write), .memory_write_bank(write_bank), .memory_index(index), .memory_data(data),
      .out_accept(accept), .out_bank(bank), .out_scalars_count_low(count_low), .out_scalars_count_high(count_high),
      .out_scalars_x_low(x_low), .out_scalars_x_high(x_high), .out_scalars_input_scale(input_scale),
      .out_scalars_output_bias(output_bias), .out_scalars_output_scale(output_scale),
      .out_scalars_current_scale(current_scale), .out_scalars_phase_step(phase_step), .out_crc(crc), .sts_bad(bad)
  );

  // Place of the next word of the image: section (SECTIONS: past the end; one more: beyond), record, word.
  reg [2:0] section = SECTIONS + 1;
  reg [15:0] record = 0, word = 0;
  reg loading = 0, other_bank = 0;
  // The clock before: a record ended, where; a commit; whether its image was whole.
  reg ended_1 = 0, commit_1 = 0, whole_1 = 0, begin_1 = 0, rst_1 = 1, taken_1 = 0, begun = 0;
  reg [2:0] section_1 = 0;
  reg [15:0] record_1 = 0;
  reg [31:0] crc_1, crc_given_1, word_1;
  reg [KEPT-1:0] kept_1;
  reg bad_1 = 0, seen = 0;

  // The last words, newest highest: those of a record and of the scalars, which overlap.
  wire [KEPT-1:0] kept = {data, scalars[KEPT-97:0]};

  wire [15:0] n_words = WORDS_OF >> {section, 4'b0};
  wire [15:0] n_records = RECORDS_OF >> {section, 4'b0};
  wire taken = load_valid && loading;
  wire last_word = section < SECTIONS && word == n_words - 1;
  wire last_record = record == n_records - 1;

  always @(posedge clk) begin
    loading <= !rst && (load_begin || loading && !load_commit);
    if (load_begin) begin
      {section, record, word} <= 0;
      other_bank <= in_bank[0];
      begun <= 1;
    end else if (taken) begin
      word <= last_word || section >= SECTIONS ? 0 : word + 1;
      if (last_word) record <= last_record ? 0 : record + 1;
      if (last_word && last_record || section == SECTIONS) section <= section + 1;
    end
    word_1 <= load_word;
    kept_1 <= kept;
    seen <= 1;
    ended_1 <= taken && last_word;
    {section_1, record_1} <= {section, record};
    commit_1 <= load_commit;
    whole_1 <= loading && section == SECTIONS;
    begin_1 <= load_begin;
    taken_1 <= taken;
    rst_1 <= rst;
    crc_1 <= crc;
    crc_given_1 <= load_crc;
    bad_1 <= bad;
  end

  wire right_1 = whole_1 && crc_1 == crc_given_1;

  always @* begin
    place_is_that_of_the_words_so_far :
      assert (\dut.is_loading == loading
              && (section < SECTIONS ? \dut.section == 1 << section && \dut.index == record && \dut.word == word :
                  section == SECTIONS ? \dut.section == 1 << SECTIONS : \dut.section == 0));
    records_are_written_in_order :
      assert (!ended_1 || write == 1 << section_1 && index == record_1);
    nothing_else_is_written : assert (ended_1 || write == 0);
    the_bank_in_use_is_not_written : assert (!begun || write_bank == other_bank && bank == {other_bank, !other_bank});
    the_bank_in_use_passes_through : assert (memory_bank == in_bank);
    whole_images_alone_are_accepted : assert (accept == (commit_1 && right_1 && !begin_1 && !rst_1));
    others_are_refused : assert (bad == (!rst_1 && !begin_1 && (commit_1 ? !right_1 : bad_1)));
    words_are_kept_in_order : assert (!seen || kept == (taken_1 ? {word_1, kept_1[KEPT-1:32]} : kept_1));
    scalars_are_the_last_words : assert (scalars[SCALAR_BITS-1:KEPT-96] == data[SCALAR_BITS-KEPT+95:0]);
    crc_starts_anew : assert (!begin_1 || crc == 0);
    crc_is_of_the_words_taken : assert (begin_1 || taken_1 || crc == crc_1 || !begun);
  end

endmodule
