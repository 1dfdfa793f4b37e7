// Claims of gc_pwm about its pins, for every value and enable in every clock. DEAD: dead_g; TWO: two_pins_g.
module pwm #(
    parameter DEAD = 2,
    parameter TWO = 0
) (
    input clk,
    input rst,
    input enable,
    input [31:0] in_value
);

  wire pin_a, pin_b;

  gc_pwm dut (.clk(clk), .rst(rst), .enable(enable), .in_value(in_value), .pin_a(pin_a), .pin_b(pin_b));

  // A pulse, and its sign.
  wire pulse = TWO ? pin_a || pin_b : pin_a;
  // Clocks since the last pulse, and since the sign changed; both stop at 2 DEAD. The clock before.
  reg [7:0] quiet = 2 * DEAD, since = 2 * DEAD;
  reg a_1 = 0, b_1 = 0, enable_1 = 0, rst_1 = 1, ever = 0;
  // The sign of the last pulse: what two pins say.
  reg last = 0;

  always @(posedge clk) begin
    quiet <= pulse ? 0 : quiet == 2 * DEAD ? quiet : quiet + 1;
    since <= pin_b != b_1 ? 1 : since == 2 * DEAD ? since : since + 1;
    {a_1, b_1, enable_1, rst_1} <= {pin_a, pin_b, enable, rst};
    ever <= rst ? 0 : ever || pulse;
    if (pulse) last <= pin_b;
  end

  wire turns = !TWO && pin_b != b_1;

  always @* begin
    stop_is_low_one_clock_later : assert (!(rst_1 || !enable_1) || !pulse);
    never_both_pins : assert (!TWO || !(pin_a && pin_b));
    signs_are_apart : assert (!TWO || !pulse || !ever || pin_b == last || quiet == 2 * DEAD);
    sign_changes_in_silence : assert (!turns || rst_1 || !pin_a && quiet >= DEAD);
    silence_after_the_change : assert (TWO || !pin_a || turns == 0 && since >= DEAD);
  end

endmodule
