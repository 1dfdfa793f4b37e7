// Claims of gc_clock_monitor, for every behaviour of both clocks, see crossing_pulse: each may stop at any time, for any
// time, and run again. BUS_LIMIT, CORE_LIMIT, STAGES: bus_limit_g, core_limit_g, stages_g.
module clock_monitor #(
    parameter BUS_LIMIT = 8,
    parameter CORE_LIMIT = 8,
    parameter STAGES = 2
) (
    input bus_clk,
    input bus_rst,
    input core_clk,
    input core_rst
);

  // A trip may still end after its clock stopped; then the limit, and the registers behind it.
  localparam BUS_CLOCKS = BUS_LIMIT + STAGES + 3, CORE_CLOCKS = CORE_LIMIT + STAGES + 2;

  wire core_alive, bus_lost;

  gc_clock_monitor dut (
      .bus_clk(bus_clk), .bus_rst(bus_rst), .core_alive(core_alive), .core_clk(core_clk), .core_rst(core_rst),
      .bus_lost(bus_lost)
  );

  // Clocks of one side while the other clock stood low, and while it stood high.
  reg [7:0] n_bus_low = 0, n_bus_high = 0, n_core_low = 0, n_core_high = 0;

  always @(posedge bus_clk or posedge core_clk)
    if (core_clk) n_bus_low <= 0;
    else n_bus_low <= n_bus_low <= BUS_CLOCKS ? n_bus_low + 1 : n_bus_low;

  always @(posedge bus_clk or negedge core_clk)
    if (!core_clk) n_bus_high <= 0;
    else n_bus_high <= n_bus_high <= BUS_CLOCKS ? n_bus_high + 1 : n_bus_high;

  always @(posedge core_clk or posedge bus_clk)
    if (bus_clk) n_core_low <= 0;
    else n_core_low <= core_rst ? 0 : n_core_low <= CORE_CLOCKS ? n_core_low + 1 : n_core_low;

  always @(posedge core_clk or negedge bus_clk)
    if (!bus_clk) n_core_high <= 0;
    else n_core_high <= core_rst ? 0 : n_core_high <= CORE_CLOCKS ? n_core_high + 1 : n_core_high;

  // Clocks of core_clk in a row in which core_alive was '0', STAGES at most.
  reg [2:0] n_told = 0;
  // As many in which it was '1', one more than STAGES at most; and whether there were so many since a reset of the core.
  reg [2:0] n_alive = 0;
  reg was_alive = 0;
  reg rst_1 = 0;

  always @(posedge bus_clk) rst_1 <= bus_rst;
  always @(posedge core_clk) n_told <= core_alive ? 0 : n_told < STAGES ? n_told + 1 : n_told;

  always @(posedge core_clk) begin
    n_alive <= core_rst || !core_alive ? 0 : n_alive <= STAGES ? n_alive + 1 : n_alive;
    was_alive <= !core_rst && (was_alive || n_alive > STAGES);
  end

  always @* begin
    core_that_stands_is_found : assert (n_bus_low < BUS_CLOCKS && n_bus_high < BUS_CLOCKS || !core_alive);
    bus_that_stands_is_found : assert (n_core_low < CORE_CLOCKS && n_core_high < CORE_CLOCKS || bus_lost);
    core_that_stood_is_told : assert (!was_alive || n_told < STAGES || bus_lost);
    reset_waits_for_the_other_clock : assert (!rst_1 || !core_alive);
  end

endmodule
