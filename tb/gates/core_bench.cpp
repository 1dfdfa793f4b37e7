// SPDX-License-Identifier: MIT
//
// Streams poses through a verilated gc_core of three axes: core_bench POSES RESULTS ACCEPTED.
// POSES: per pose four int32, the counts and the clocks to wait before it is offered. RESULTS: per result six uint32,
// three words of out_force, out_clamped, out_saturated, the clock. ACCEPTED: uint32, the clock in which each was taken.

#include <cstdint>
#include <cstdio>
#include <memory>

#include "Vgc_core.h"
#include "verilated.h"

static constexpr int axes = 3, flush_clocks = 64;

int main(int argc, char **argv) {
  if (argc != 4) return 2;
  std::FILE *poses = std::fopen(argv[1], "rb"), *results = std::fopen(argv[2], "wb"), *accepted = std::fopen(argv[3], "wb");
  if (!poses || !results || !accepted) return 2;
  auto core = std::make_unique<Vgc_core>();
  auto clock_edge = [&](int level) {
    core->clk = level;
    core->eval();
  };
  core->rst = 1;
  core->in_valid = 0;
  for (int k = 0; k < 3; k++) {
    clock_edge(1);
    clock_edge(0);
  }
  core->rst = 0;
  int32_t pose[axes + 1];
  bool more = std::fread(pose, sizeof pose, 1, poses) == 1;
  int idle = 0;
  for (uint32_t clock = 0; idle < flush_clocks; clock++) {
    if (core->out_valid) {
      uint32_t result[axes + 3] = {};
      for (int i = 0; i < axes; i++) result[i] = core->out_force[i];
      result[axes] = core->out_clamped;
      result[axes + 1] = core->out_saturated;
      result[axes + 2] = clock;
      std::fwrite(result, sizeof result, 1, results);
    }
    core->in_valid = more && pose[axes] == 0;
    for (int i = 0; i < axes; i++) core->in_count[i] = pose[i];
    core->eval();
    if (core->in_valid && core->in_ready) {
      std::fwrite(&clock, sizeof clock, 1, accepted);
      more = std::fread(pose, sizeof pose, 1, poses) == 1;
    } else if (more && pose[axes] > 0) {
      pose[axes]--;
    }
    clock_edge(1);
    clock_edge(0);
    idle = more ? 0 : idle + 1;
  }
  return std::fclose(results) || std::fclose(accepted);
}
