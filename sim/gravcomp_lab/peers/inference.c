// SPDX-License-Identifier: MIT
//
// The network in float32, one pose at a time, and how long each call takes. weights.h is generated from the CSV files.
// Writes to standard output: nanoseconds of each call (int64, CALLS of them), nanoseconds of a measurement of nothing
// (as many), forces in N at every pose (float, POSES times AXES).

#define _POSIX_C_SOURCE 199309L
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "weights.h"

static int64_t now_ns(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * INT64_C(1000000000) + t.tv_nsec;
}

// f in N from q in m.
__attribute__((noinline)) static void forces(const float *q_m, float *f_n) {
  float h[NEURONS];
  for (int j = 0; j < NEURONS; j++) h[j] = hidden_bias[j];
  for (int i = 0; i < AXES; i++) {
    float x = (q_m[i] - q_offset[i]) * q_scale[i];
    for (int j = 0; j < NEURONS; j++) h[j] += hidden_weights[i][j] * x;
  }
  for (int j = 0; j < NEURONS; j++) {
    float a = h[j] > 2.0f ? 2.0f : h[j];
    a = a < -2.0f ? -2.0f : a;
    h[j] = a * (1.0f - 0.25f * fabsf(a));
  }
  for (int i = 0; i < AXES; i++) {
    float y = output_bias[i];
    for (int j = 0; j < NEURONS; j++) y += output_weights[i][j] * h[j];
    f_n[i] = f_offset[i] + f_scale[i] * y;
  }
}

int main(void) {
  static float f_n[POSES][AXES];
  int64_t *call_ns = malloc(CALLS * sizeof *call_ns), *nothing_ns = malloc(CALLS * sizeof *nothing_ns);
  if (!call_ns || !nothing_ns) return 1;
  for (int k = 0; k < CALLS; k++) {
    int64_t began = now_ns();
    forces(q_m[k % POSES], f_n[k % POSES]);
    call_ns[k] = now_ns() - began;
    began = now_ns();
    nothing_ns[k] = now_ns() - began;
  }
  size_t written = fwrite(call_ns, sizeof *call_ns, CALLS, stdout);
  written += fwrite(nothing_ns, sizeof *nothing_ns, CALLS, stdout);
  written += fwrite(f_n, sizeof f_n, 1, stdout);
  return written != 2 * (size_t)CALLS + 1;
}
