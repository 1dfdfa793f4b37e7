// SPDX-License-Identifier: MIT
//
// gc_system and a host (cosim.v) under Verilator as a shared library: clocks, encoder edges and currents around them.
// gravcomp_lab.cosim.library compiles it and steps it; what the two share is one Port.
//
// A step of the world is port.step_clocks clocks of the core. In it every encoder goes from where it is to its target, in
// edges that are evenly spread, and one measured current of each axis comes. The bus' clock is half as fast as clk and
// half a clock behind it, so that no eval has an edge of both; what crosses is for unrelated clocks.

#include <cstdint>
#include <cstring>
#include <deque>

#include "Vcosim.h"
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
static Vcosim *top;
static Port port;
static int32_t start[most_axes];  // of this step

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

// The other end of a serial line, 8N1: characters to the core and from it, what a bit takes, and what is on its way.
static struct {
  std::deque<uint8_t> to_core, from_core;
  uint32_t bit_clocks;
  uint32_t sending, bits_left, send_clocks;
  uint32_t receiving, place, receive_clocks;
} line;

static void line_sends() {
  if (line.send_clocks) {
    line.send_clocks--;
  } else if (line.bits_left || !line.to_core.empty()) {
    if (!line.bits_left) {
      line.sending = 0x200 | line.to_core.front() << 1;
      line.bits_left = 10;
      line.to_core.pop_front();
    }
    top->pin_rx = line.sending & 1;
    line.sending >>= 1, line.bits_left--, line.send_clocks = line.bit_clocks - 1;
  }
}

// Looks at the middle of each bit; place: of the next one, 0 for the start.
static void line_receives() {
  if (line.receive_clocks) {
    line.receive_clocks--;
  } else if (line.place == 0) {
    if (top->pin_tx) return;
    line.receiving = 0, line.place = 1, line.receive_clocks = line.bit_clocks * 3 / 2 - 1;
  } else if (line.place < 9) {
    line.receiving |= top->pin_tx << (line.place - 1);
    line.place++, line.receive_clocks = line.bit_clocks - 1;
  } else {
    line.from_core.push_back(line.receiving);
    line.place = 0;
  }
}

static void core_clock() {
  if (line.bit_clocks) line_sends(), line_receives();
  encoders();
  currents();
  top->estop_n = !port.estop;
  top->clk = 1, top->bus_clk = 0;
  top->eval();
  top->clk = 0, top->bus_clk = port.clock & 1;
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
  top = new Vcosim(context);
  port = Port{};
  port.axes = axes, port.step_clocks = step_clocks;
  std::memcpy(port.index, index, 4 * axes);
  std::memcpy(port.target, counts, 4 * axes);
  std::memcpy(start, counts, 4 * axes);
  line = {};
  top->pin_rx = 1;
  top->bus_rst_n = 0;
  for (uint32_t k = 0; k < step_clocks; k++) core_clock();
  top->bus_rst_n = 1;
  return &port;
}

void cosim_close() {
  top->final();
  delete top;
  delete context;
}

// A line whose bits take so many clocks.
void cosim_line(uint32_t bit_clocks) { line.bit_clocks = bit_clocks; }

void cosim_send(const uint8_t *characters, uint32_t count) {
  line.to_core.insert(line.to_core.end(), characters, characters + count);
}

// At most so many characters that came; returns how many.
uint32_t cosim_receive(uint8_t *characters, uint32_t most) {
  uint32_t count = 0;
  for (; count < most && !line.from_core.empty(); line.from_core.pop_front()) characters[count++] = line.from_core.front();
  return count;
}

void cosim_begin(uint32_t is_write, uint32_t address, uint32_t data) {
  top->host_turn = !top->host_turn;
  top->host_writes = is_write, top->host_address = address, top->host_word = data;
}

// So many clocks, or with 0 until the access has ended, but no longer than to the end of the step; returns whether an
// access is under way.
int cosim_run(uint32_t clocks) {
  do core_clock();
  while (port.step_clock && (clocks ? --clocks != 0 : top->host_busy));
  port.data = top->host_data, port.error = top->host_error;
  return top->host_busy;
}
}
