// Claims of gc_bank_switch, for every behaviour of the loader, the host, and a core that keeps to what the header says:
// at most 63 inferences at a time, of which none begins while out_hold is high, and none ends that did not begin.
// ROM: the scalars of the ROM, in the order of scalars_t, the first field lowest. BIAS_BITS, PHASE_BITS: of output_bias and phase_step of one axis in scalars_t.
module bank_switch #(
    parameter BIAS_BITS = 38,
    parameter PHASE_BITS = 25,
    parameter SCALAR_BITS = 3 * (2 * 32 + 5 * 18 + BIAS_BITS + PHASE_BITS),
    parameter [SCALAR_BITS-1:0] ROM = 0
) (
    input clk,
    input rst,
    input in_accept,
    input [1:0] in_bank,
    input [SCALAR_BITS-1:0] in_scalars,
    input [31:0] in_crc,
    input load_rom,
    input load_begin,
    input in_start,
    input in_done
);

  wire hold, restart, waiting;
  wire [1:0] bank;
  (* hierconn *) wire [5:0] \dut.under_way ;
  (* hierconn *) wire [1:0] \dut.next_bank ;
  wire [SCALAR_BITS-1:0] scalars;
  wire [31:0] crc;

  wire [95:0] in_count_low, in_count_high, count_low, count_high;
  wire [53:0] in_x_low, in_x_high, in_input_scale, in_output_scale, x_low, x_high, input_scale, output_scale;
  wire [3*BIAS_BITS-1:0] in_output_bias, output_bias;
  wire [53:0] in_current_scale, current_scale;
  wire [3*PHASE_BITS-1:0] in_phase_step, phase_step;

  assign {in_phase_step, in_current_scale, in_output_scale, in_output_bias, in_x_high, in_x_low, in_input_scale,
          in_count_high, in_count_low} = in_scalars;
  assign scalars = {phase_step, current_scale, output_scale, output_bias, x_high, x_low, input_scale, count_high,
                    count_low};

  gc_bank_switch dut (
      .clk(clk), .rst(rst), .in_accept(in_accept), .in_bank(in_bank), .in_scalars_count_low(in_count_low),
      .in_scalars_count_high(in_count_high), .in_scalars_x_low(in_x_low), .in_scalars_x_high(in_x_high),
      .in_scalars_input_scale(in_input_scale), .in_scalars_output_bias(in_output_bias),
      .in_scalars_output_scale(in_output_scale), .in_scalars_current_scale(in_current_scale),
      .in_scalars_phase_step(in_phase_step), .in_crc(in_crc), .load_rom(load_rom), .load_begin(load_begin),
      .in_start(in_start), .in_done(in_done), .out_hold(hold), .out_restart(restart), .out_bank(bank),
      .out_scalars_count_low(count_low), .out_scalars_count_high(count_high), .out_scalars_x_low(x_low),
      .out_scalars_x_high(x_high), .out_scalars_input_scale(input_scale), .out_scalars_output_bias(output_bias),
      .out_scalars_output_scale(output_scale), .out_scalars_current_scale(current_scale),
      .out_scalars_phase_step(phase_step), .sts_waiting(waiting), .sts_crc(crc)
  );

  // Inferences under way, and whether a swap shall come: to which bank.
  reg [5:0] n_under_way = 0;
  reg asked = 0;
  reg [1:0] asked_bank = 0;
  // The clock before.
  reg seen = 0, rst_1 = 1, asked_1 = 0, idle_1 = 0, begin_1 = 0;
  reg [1:0] asked_bank_1 = 0, bank_1 = 0;
  reg [SCALAR_BITS-1:0] scalars_1, in_scalars_1;
  reg [31:0] crc_1 = 0, in_crc_1;

  wire swap = asked && n_under_way == 0 && !load_begin;

  always @(posedge clk) begin
    seen <= 1;
    n_under_way <= rst ? 0 : n_under_way + in_start - in_done;
    asked <= !rst && !load_begin && (in_accept || load_rom || asked && !swap);
    asked_bank <= load_rom ? 0 : in_accept ? in_bank : asked_bank;
    rst_1 <= rst;
    asked_1 <= asked;
    idle_1 <= n_under_way == 0;
    begin_1 <= load_begin;
    asked_bank_1 <= asked_bank;
    bank_1 <= bank;
    scalars_1 <= scalars;
    in_scalars_1 <= in_scalars;
    crc_1 <= crc;
    in_crc_1 <= in_crc;
  end

  wire swapped_1 = asked_1 && idle_1 && !begin_1;
  wire same = bank == bank_1 && scalars == scalars_1 && crc == crc_1;
  wire is_rom = bank == 0 && scalars == ROM && crc == 0;
  wire is_image = bank == asked_bank_1 && scalars == in_scalars_1 && crc == in_crc_1;

  always @* begin
    assume (!in_start || !hold && n_under_way != 63);
    assume (!in_done || n_under_way != 0);
    counts_inferences : assert (\dut.under_way == n_under_way);
    last_one_asked_is_next : assert (!asked || \dut.next_bank == asked_bank);
    waits_until_it_is_swapped_or_dropped : assert (waiting == asked);
    no_inference_begins_while_a_swap_waits : assert (hold == (waiting || restart));
    constants_change_between_inferences_only : assert (!seen || same || rst_1 || idle_1);
    constants_change_when_asked_only : assert (!seen || same || rst_1 || swapped_1);
    swaps_once_none_is_under_way : assert (!swapped_1 || restart);
    restart_comes_with_the_constants : assert (!seen || restart == (rst_1 || swapped_1));
    all_constants_are_swapped_together :
      assert (!seen || rst_1 || !swapped_1 || (asked_bank_1 == 0 ? is_rom : is_image));
    reset_returns_to_the_rom : assert (!seen || !rst_1 || is_rom && !waiting);
  end

endmodule
