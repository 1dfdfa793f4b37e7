// SPDX-License-Identifier: MIT
//
// gc_system under Verilator with a host, encoders and single-bit flips; gravcomp_lab.inject.bench talks to it through pipes.
//
// One line of standard input is one order, answered by a line of standard output where it says so:
//   w ADDRESS DATA   the host writes; answers OK or ERROR          r ADDRESS   the host reads; answers the data or ERROR
//   c N              N clocks of the core pass                     e A B C     encoders begin here, counts: no edge is made
//   i A B C          indices, counts                               t A B C     targets of the encoders: walked to, then OK
//   @ N              in hold the host waits for clock N of its loop, then does what follows till the next @
//   + AXIS STEP      in hold the encoder moves by STEP             x STORE     the register of the latched causes
//   h LOOP HORIZON STRIDE SHIFT MOMENT...
//                    hold: runs without a fault, saved at the MOMENTs; answers, per register, the bits that changed and,
//                    per memory, the words that were read; w, r between @ and h are the host's loop of LOOP clocks
//   f MOMENT STORE WORD BIT
//                    flip one bit at a moment, then HORIZON clocks; answers as answer() says
//   p MOMENT STORE WORD BIT
//                    the same, but ends as soon as the flip has reached another instance
// It ends sooner once the brakes have been engaged and the command off for a while with a cause latched: nobody clears it.
// A command that comes up to SHIFT clocks sooner or later than without a fault is not wrong.
// Every STRIDE clocks all state is compared with that of the run without a fault; a run that has none left ends there.
// Numbers are decimal.

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <vector>

#include "Vgc_system.h"
#include "Vgc_system___024root.h"
#include "verilated.h"

void Vgc_system___024root___eval_settle(Vgc_system___024root *root);

static constexpr int axes = 3;
static constexpr uint64_t core_ns = 25, axi_ns = 98, edge_clocks = 8, patience = 20000;

static Vgc_system *top;

// ---- state of the design

struct Store {
  uint8_t *data;
  uint32_t element, bits, depth, instance;
  std::vector<const void *> addresses;
  std::vector<uint32_t> address_bytes;
};

static std::vector<Store> stores;

template <class T> static uint8_t *at(T &signal) { return reinterpret_cast<uint8_t *>(&signal); }

static void collect(Vgc_system___024root *root) {
#define REGISTER(member, bits, instance) stores.push_back({at(root->member), sizeof root->member, bits, 0, instance, {}, {}});
#define MEMORY(member, bits, depth, instance) \
  stores.push_back({at(root->member), sizeof root->member / depth, bits, depth, instance, {}, {}});
#define ADDRESS(member) \
  stores.back().addresses.push_back(&root->member), stores.back().address_bytes.push_back(sizeof root->member);
#include "stores.h"
}

// All of it side by side; the same vector again and again.
static const std::vector<uint8_t> &gathered(bool memories) {
  static std::vector<uint8_t> all[2];
  std::vector<uint8_t> &bytes = all[memories];
  bytes.clear();
  for (auto &s : stores)
    if (memories == (s.depth > 0)) bytes.insert(bytes.end(), s.data, s.data + s.element * std::max(s.depth, 1u));
  return bytes;
}

static const std::vector<uint8_t> &registers() { return gathered(false); }
static const std::vector<uint8_t> &memories() { return gathered(true); }

// ---- what is outside of it

struct Order {
  char kind;  // w, r, @, +
  uint32_t address, data;
  int step;
};

struct Host {  // an AXI4-Lite master, one transfer at a time
  bool aw, w, b, ar, r, error;
  uint32_t data;
  bool busy() const { return aw || w || b || ar || r; }
};

struct World {
  uint64_t clock, axi_next;
  int32_t position[axes], target[axes], index[axes];
  uint64_t next_edge;
  Host host;
  bool in_loop;
  uint32_t loop_at, loop_clock;
};

static World world;
static std::vector<Order> loop_orders;
static uint32_t loop_clocks = 1;

static void begin(const Order &order) {
  Host &h = world.host;
  h.error = false;
  if (order.kind == 'w') {
    h.aw = h.w = h.b = true;
    top->s_axi_awaddr = order.address, top->s_axi_wdata = order.data, top->s_axi_wstrb = 15;
  } else {
    h.ar = h.r = true;
    top->s_axi_araddr = order.address;
  }
}

static void follow_loop() {
  if (loop_orders.empty() || world.host.busy()) return;
  const Order &order = loop_orders[world.loop_at];
  if (order.kind == '@' && world.loop_clock != order.address) return;
  if (order.kind == '+') world.target[order.address] += order.step;
  if (order.kind == 'w' || order.kind == 'r') begin(order);
  world.loop_at = (world.loop_at + 1) % loop_orders.size();
}

static void axi_clock() {
  Host &h = world.host;  // a transfer takes place in a clock that both sides have seen
  if (top->s_axi_awvalid && top->s_axi_awready) h.aw = false;
  if (top->s_axi_wvalid && top->s_axi_wready) h.w = false;
  if (top->s_axi_bready && top->s_axi_bvalid) h.b = false, h.error |= top->s_axi_bresp != 0;
  if (top->s_axi_arvalid && top->s_axi_arready) h.ar = false;
  if (top->s_axi_rready && top->s_axi_rvalid)
    h.r = false, h.error |= top->s_axi_rresp != 0, h.data = top->s_axi_rdata;
  top->s_axi_aclk = 1;
  top->eval();
  if (world.in_loop) {
    follow_loop();
    world.loop_clock = (world.loop_clock + 1) % loop_clocks;
  }
  top->s_axi_awvalid = h.aw, top->s_axi_wvalid = h.w, top->s_axi_bready = h.b;
  top->s_axi_arvalid = h.ar, top->s_axi_rready = h.r;
  top->s_axi_aclk = 0;
  top->eval();
}

static void encoders() {
  if (world.clock < world.next_edge) return;
  world.next_edge = world.clock + edge_clocks;
  int a = 0, b = 0, z = 0;
  for (int i = 0; i < axes; i++) {
    int32_t &p = world.position[i];
    p += (p < world.target[i]) - (p > world.target[i]);
    int phase = p & 3;
    a |= (phase == 1 || phase == 2) << i;
    b |= (phase >= 2) << i;
    z |= (p == world.index[i]) << i;
  }
  top->pin_a = a, top->pin_b = b, top->pin_z = z;
}

// ---- what it does to the robot

struct Outputs {
  int32_t command[axes];
  // range of the command, SHIFT clocks before to after; of runs without a fault
  int32_t low[axes], high[axes];
  // which brakes the two paths release, side by side
  uint8_t brakes, enable;
  uint8_t released() const { return brakes & brakes >> axes; }
};

// Brakes that the second path releases; the first one's, where there is no second.
template <class T> static uint8_t second_path(const T &model) {
  if constexpr (requires { model.brake_engage; }) return ~model.brake_engage & ((1 << axes) - 1);
  else return model.brake_release;
}

static Outputs outputs() {
  Outputs now{};
  for (int i = 0; i < axes; i++) now.command[i] = top->drive_current[i];
  now.brakes = top->brake_release | second_path(*top) << axes, now.enable = top->drive_enable;
  return now;
}

// A brake is fed as it was told.
static void brakes() { top->brake_fed = outputs().released(); }

static void core_clock() {
  while (world.axi_next <= core_ns * world.clock) {
    axi_clock();
    world.axi_next += axi_ns;
  }
  encoders();
  brakes();
  top->clk = 1;
  top->eval();
  top->clk = 0;
  top->eval();
  world.clock++;
}

static bool transfer(const Order &order) {
  for (uint64_t k = 0; k < patience && world.host.busy(); k++) core_clock();
  if (world.host.busy()) return false;
  begin(order);
  for (uint64_t k = 0; k < patience && world.host.busy(); k++) core_clock();
  return !world.host.busy() && !world.host.error;
}

// ---- runs with and without a fault

struct Saved {
  std::vector<uint8_t> root;
  World world;
  void save() {
    root.resize(sizeof *top->rootp);
    std::memcpy(root.data(), static_cast<void *>(top->rootp), root.size());
    ::memcpy(&world, &::world, sizeof world);
  }
  void restore() const {
    std::memcpy(static_cast<void *>(top->rootp), root.data(), root.size());
    ::memcpy(&::world, &world, sizeof world);
  }
};

struct Snapshot {
  std::vector<uint8_t> registers;
  World world;
};

static std::vector<uint64_t> moments;
static std::vector<Saved> saved;
static std::vector<Outputs> golden;
static std::vector<Snapshot> snapshots;
static std::vector<uint8_t> golden_memories;
static uint32_t watched;
static constexpr long settled_clocks = 4000;
static uint64_t horizon, stride, shift;

// Range of the commands around each clock.
static void widen() {
  for (size_t t = 0; t < golden.size(); t++)
    for (int i = 0; i < axes; i++) {
      golden[t].low[i] = golden[t].high[i] = golden[t].command[i];
      size_t first = t < shift ? 0 : t - shift, last = std::min(golden.size() - 1, t + shift);
      for (size_t k = first; k <= last; k++) {
        golden[t].low[i] = std::min(golden[t].low[i], golden[k].command[i]);
        golden[t].high[i] = std::max(golden[t].high[i], golden[k].command[i]);
      }
    }
}

static void hold() {
  world.in_loop = true;
  world.loop_at = 0, world.loop_clock = 0;
  std::vector<uint8_t> first = registers(), last = first, changed(first.size(), 0);
  std::vector<std::vector<bool>> read;
  for (auto &s : stores) read.emplace_back(s.depth, false);
  uint64_t last_clock = moments.back() + horizon + stride + 1;
  size_t next = 0;
  for (uint64_t t = 0; t <= last_clock; t++) {
    if (next < moments.size() && moments[next] == t) saved.emplace_back(), saved.back().save(), next++;
    if (t % stride == 0) snapshots.push_back({registers(), world});
    golden.push_back(outputs());
    core_clock();
    const std::vector<uint8_t> &now = registers();
    for (size_t k = 0; k < now.size(); k++) changed[k] |= now[k] ^ last[k];
    last = now;
    for (size_t k = 0; k < stores.size(); k++)
      for (size_t a = 0; a < stores[k].addresses.size(); a++) {
        uint32_t address = 0;
        std::memcpy(&address, stores[k].addresses[a], stores[k].address_bytes[a]);
        if (address < stores[k].depth) read[k][address] = true;
      }
  }
  golden_memories = memories();
  widen();
  size_t k = 0;
  for (size_t n = 0; n < stores.size(); n++) {
    if (stores[n].depth) {
      for (size_t word = 0; word < stores[n].depth; word++) std::putchar('0' + read[n][word]);
    } else {
      for (uint32_t bit = 0; bit < stores[n].bits; bit++) std::putchar('0' + (changed[k + bit / 8] >> bit % 8 & 1));
      k += stores[n].element;
    }
    std::putchar('\n');
  }
}

// Numbers of the stores that differ from the run without a fault; those beyond the flipped one's instance, too.
static std::vector<uint32_t> differing(const std::vector<uint8_t> &good) {
  std::vector<uint32_t> found;
  size_t k = 0, m = 0;
  for (uint32_t n = 0; n < stores.size(); n++) {
    Store &s = stores[n];
    size_t bytes = s.element * (s.depth ? s.depth : 1);
    const uint8_t *reference = s.depth ? &golden_memories[m] : &good[k];
    if (std::memcmp(s.data, reference, bytes)) found.push_back(n);
    (s.depth ? m : k) += bytes;
  }
  return found;
}

static bool same_world(const World &a, const World &b) { return !std::memcmp(&a, &b, sizeof a); }

// The causes that are latched.
static uint32_t latched() {
  uint32_t value = 0;
  std::memcpy(&value, stores[watched].data, std::min<size_t>(sizeof value, stores[watched].element));
  return value;
}

struct Answer {
  bool converged, reaches, released_wrongly;
  uint64_t clocks;
  long largest[axes], wrong, first_wrong, brakes_longest, brakes_run, off_run;
};

// What this clock adds to the answer.
static void compare(Answer &answer, const Outputs &good) {
  Outputs now = outputs();
  // A command counts while it can move an axis or pushes against a closed brake; one that was stopped does not.
  bool stopped = !now.enable && !now.released(), wrong = false;
  for (int i = 0; i < axes && !stopped; i++) {
    long command = now.command[i], low = good.low[i], high = good.high[i];
    long difference = std::max({low - command, command - high, 0L});
    long magnitude = std::max(std::labs(low), std::labs(high));
    answer.largest[i] = std::max(answer.largest[i], difference);
    wrong |= 100 * difference > magnitude;
  }
  if (wrong && !answer.wrong) answer.first_wrong = answer.clocks;
  answer.wrong += wrong;
  bool brakes = now.brakes != good.brakes || now.enable != good.enable;
  answer.brakes_run = brakes ? answer.brakes_run + 1 : 0;
  answer.brakes_longest = std::max(answer.brakes_longest, answer.brakes_run);
  answer.released_wrongly |= (now.released() & ~good.released()) != 0;
  answer.off_run = stopped && latched() ? answer.off_run + 1 : 0;
  answer.reaches |= brakes || std::memcmp(now.command, good.command, sizeof now.command);
}

// Converged to the run without a fault, clocks, reached another instance; per axis the largest difference of a command,
// uA; clocks with a command more than 1 % off and the first of them; longest time, clocks, that brake and enable pins
// differ; whether a brake was released that should not be; pins and causes at the end, differing stores.
static void answer(const Answer &a, const std::vector<uint32_t> &left) {
  Outputs end = outputs();
  std::printf("%d %llu %d", a.converged, static_cast<unsigned long long>(a.clocks), a.reaches);
  for (long value : a.largest) std::printf(" %ld", value);
  std::printf(" %ld %ld %ld %d %d %d", a.wrong, a.first_wrong, a.brakes_longest, a.released_wrongly, end.released(), end.enable);
  std::printf(" %u", latched());
  for (size_t k = 0; k < left.size() && k < 8; k++) std::printf(" %u", left[k]);
  std::putchar('\n');
}

static void inject(size_t moment, uint32_t store, uint32_t word, uint32_t bit, bool probe) {
  saved[moment].restore();
  Store &flipped = stores[store];
  flipped.data[word * flipped.element + bit / 8] ^= 1 << bit % 8;
  Vgc_system___024root___eval_settle(top->rootp);
  Answer a{};
  a.first_wrong = -1;
  std::vector<uint32_t> left;
  for (uint64_t t = moments[moment];; t++, a.clocks++) {
    if (t % stride == 0) {
      const Snapshot &good = snapshots[t / stride];
      bool equal = registers() == good.registers && same_world(world, good.world);
      if (equal && memories() == golden_memories) {
        a.converged = true;
        break;
      }
      if (!a.reaches && !equal)
        for (uint32_t n : differing(good.registers)) a.reaches |= stores[n].instance != flipped.instance;
      if (a.clocks >= horizon || a.off_run >= settled_clocks || (probe && a.reaches)) {
        left = differing(good.registers);
        break;
      }
    }
    compare(a, golden[t]);
    core_clock();
  }
  answer(a, left);
}

int main() {
  auto model = std::make_unique<Vgc_system>();
  top = model.get();
  std::memset(static_cast<void *>(&world), 0, sizeof world);
  collect(top->rootp);
  top->estop_n = 1;
  top->s_axi_aresetn = 0;
  char kind, line[1 << 16];
  while (std::scanf(" %c", &kind) == 1) {
    long v[4] = {};
    auto numbers = [&](int n) {
      for (int k = 0; k < n; k++)
        if (std::scanf("%ld", &v[k]) != 1) std::exit(2);
    };
    if (kind == 'n') {
      for (int k = 0; k < 60; k++) core_clock();
      top->s_axi_aresetn = 1;
      for (int k = 0; k < 60; k++) core_clock();
    } else if (kind == 'w' || kind == 'r') {
      numbers(kind == 'w' ? 2 : 1);
      Order order{kind, static_cast<uint32_t>(v[0]), static_cast<uint32_t>(v[1]), 0};
      if (!loop_orders.empty()) {
        loop_orders.push_back(order);
        continue;
      }
      bool ok = transfer(order);
      if (!ok) std::puts("ERROR");
      else if (kind == 'w') std::puts("OK");
      else std::printf("%u\n", world.host.data);
    } else if (kind == 'c') {
      numbers(1);
      for (long k = 0; k < v[0]; k++) core_clock();
    } else if (kind == 'e' || kind == 'i' || kind == 't') {
      numbers(axes);
      for (int k = 0; k < axes; k++)
        (kind == 'e' ? world.position : kind == 'i' ? world.index : world.target)[k] = v[k];
      if (kind == 'e') std::memcpy(world.target, world.position, sizeof world.target);
      if (kind == 't') {
        while (std::memcmp(world.target, world.position, sizeof world.target)) core_clock();
        for (int k = 0; k < 60; k++) core_clock();
        std::puts("OK");
      }
    } else if (kind == '@' || kind == '+') {
      numbers(kind == '+' ? 2 : 1);
      loop_orders.push_back({kind, static_cast<uint32_t>(v[0]), 0, static_cast<int>(v[1])});
    } else if (kind == 'x') {
      numbers(1);
      watched = v[0];
    } else if (kind == 'h') {
      numbers(4);
      loop_clocks = v[0], horizon = v[1], stride = v[2], shift = v[3];
      if (!std::fgets(line, sizeof line, stdin)) return 2;
      for (char *word = std::strtok(line, " \n"); word; word = std::strtok(nullptr, " \n"))
        moments.push_back(std::strtoull(word, nullptr, 10));
      hold();
    } else if (kind == 'f' || kind == 'p') {
      numbers(4);
      inject(v[0], v[1], v[2], v[3], kind == 'p');
    } else {
      return 2;
    }
    std::fflush(stdout);
  }
}
