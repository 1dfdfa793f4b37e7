// SPDX-License-Identifier: MIT
//
// gc_system under Verilator as a shared library: clocks, encoder edges, currents and an AXI4-Lite master around it.
// gravcomp_lab.cosim.library compiles it and steps it; what the two share is one Port.
//
// A step of the world is port.step_clocks clocks of the core. In it every encoder goes from where it is to its target, in
// edges that are evenly spread, and one measured current of each axis comes. s_axi_aclk is as fast as clk and half a clock
// behind it, so that an eval has an edge of each; what crosses is for unrelated clocks.

#include <cstdint>
#include <cstring>

#include "Vgc_system.h"
#include "verilated.h"

static constexpr int most_axes = 8;

extern "C" {

struct Port {
  uint64_t clock;                          // of the core, since reset
  uint32_t axes, step_clocks, step_clock;  // step_clock: of this step, so far
  int32_t position[most_axes], target[most_axes], index[most_axes];  // counts; target: at the end of this step
  int32_t sense_ua[most_axes];                                       // measured at the start of this step
  int32_t command_ua[most_axes];
  uint32_t released, enabled, estop;  // sets of axes, in every clock; whether drives are enabled; emergency stop pressed
  uint32_t data, error;               // of the last access
  int32_t jump[most_axes];            // counts that the pins are ahead of the position: a fault of the encoder
};
}

static VerilatedContext *context;
static Vgc_system *top;
static Port port;
static int32_t start[most_axes];  // of this step

static struct {
  bool aw, w, b, ar, r;
  bool busy() const { return aw || w || b || ar || r; }
} host;

// A transfer takes place in a clock that both sides have seen.
static void axi_rises() {
  if (top->s_axi_awvalid && top->s_axi_awready) host.aw = false;
  if (top->s_axi_wvalid && top->s_axi_wready) host.w = false;
  if (top->s_axi_bready && top->s_axi_bvalid) host.b = false, port.error = top->s_axi_bresp;
  if (top->s_axi_arvalid && top->s_axi_arready) host.ar = false;
  if (top->s_axi_rready && top->s_axi_rvalid) host.r = false, port.error = top->s_axi_rresp, port.data = top->s_axi_rdata;
}

static void axi_drives() {
  top->s_axi_awvalid = host.aw, top->s_axi_wvalid = host.w, top->s_axi_bready = host.b;
  top->s_axi_arvalid = host.ar, top->s_axi_rready = host.r;
}

static void encoders() {
  int a = 0, b = 0, z = 0;
  for (uint32_t i = 0; i < port.axes; i++) {
    int64_t way = int64_t(port.target[i]) - start[i];
    port.position[i] = start[i] + way * (port.step_clock + 1) / port.step_clocks;
    int phase = (port.position[i] + port.jump[i]) & 3;
    a |= (phase == 1 || phase == 2) << i;
    b |= (phase >= 2) << i;
    z |= (port.position[i] == port.index[i]) << i;
  }
  top->pin_a = a, top->pin_b = b, top->pin_z = z;
}

static void currents() {
  bool comes = port.step_clock == 0;
  top->sense_valid = comes ? (1 << port.axes) - 1 : 0;
  if (comes) std::memcpy(&top->sense_current, port.sense_ua, 4 * port.axes);
}

static void core_clock() {
  encoders();
  currents();
  axi_drives();
  top->estop_n = !port.estop;
  top->clk = 1, top->s_axi_aclk = 0;
  top->eval();
  axi_rises();
  top->clk = 0, top->s_axi_aclk = 1;
  top->eval();
  port.clock++;
  port.released = top->brake_release & ~top->brake_engage & ((1 << port.axes) - 1);
  if (++port.step_clock < port.step_clocks) return;
  port.step_clock = 0;
  std::memcpy(start, port.position, sizeof start);
  std::memcpy(port.command_ua, &top->drive_current, 4 * port.axes);
  port.enabled = top->drive_enable;
}

extern "C" {

// A new core at these counts, reset.
Port *cosim_open(uint32_t axes, uint32_t step_clocks, const int32_t *counts, const int32_t *index) {
  context = new VerilatedContext;
  top = new Vgc_system(context);
  port = Port{};
  port.axes = axes, port.step_clocks = step_clocks;
  std::memcpy(port.index, index, 4 * axes);
  std::memcpy(port.target, counts, 4 * axes);
  std::memcpy(start, counts, 4 * axes);
  host = {};
  top->s_axi_aresetn = 0;
  for (uint32_t k = 0; k < step_clocks; k++) core_clock();
  top->s_axi_aresetn = 1;
  return &port;
}

void cosim_close() {
  top->final();
  delete top;
  delete context;
}

void cosim_begin(uint32_t is_write, uint32_t address, uint32_t data) {
  if (is_write) {
    host.aw = host.w = host.b = true;
    top->s_axi_awaddr = address, top->s_axi_wdata = data, top->s_axi_wstrb = 15;
  } else {
    host.ar = host.r = true;
    top->s_axi_araddr = address;
  }
}

// So many clocks, or with 0 until the access has ended, but no longer than to the end of the step; returns whether an
// access is under way.
int cosim_run(uint32_t clocks) {
  do core_clock();
  while (port.step_clock && (clocks ? --clocks != 0 : host.busy()));
  return host.busy();
}
}
