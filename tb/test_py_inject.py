"""Fault injection: how a run with a wrong bit is judged, and that all state of a design is found."""

from dataclasses import replace

import pytest

from gravcomp.errors import InputError
from gravcomp_lab.inject.campaign import Flip
from gravcomp_lab.inject.outcome import BRAKED, HARMLESS, LATENT, SILENT, Outcome, classify, parse, upper_bound
from gravcomp_lab.inject.report import ALL, judge, merged, shares, silent_table, table
from gravcomp_lab.inject.state import Store, find_state, make_public

UA_PER_MN = 20.0
# As a run that nothing happened in.
CALM = Outcome(True, 300, False, (0, 0, 0), 0, -1, 0, False, 7, 1, 0, ())
STOPPED = replace(CALM, converged=False, brakes=0, enable=0, brake_clocks=40_000)
VERILOG = """\
module gc_inner_8
  (input  clk,
   output [7:0] q);
  reg [7:0] held;
  wire [7:0] n1_o;
  reg [7:0] n2_q;
  wire [2:0] n3_o;
  wire [7:0] n4_data; // mem_rd
  assign q = n2_q;
  always @*
    held = n2_q; // (isignal)
  assign n1_o = held + 8'b00000001;
  always @(posedge clk)
    n2_q <= n1_o;
  initial
    n2_q <= 8'b00000000;
  reg [7:0] n5[7:0] ; // memory
  initial begin
    n5[1] = 8'b00000001;
    n5[0] = 8'b00000000;
    end
  assign n4_data = n5[n3_o];
endmodule

module gc_outer
  (input  clk);
  reg n6_q;
  gc_inner_8 i_a (
    .clk(clk));
  gc_inner_8 i_b (
    .clk(clk));
  always @(posedge clk)
    if (n7_o)
      n6_q <= n7_o;
endmodule
"""


@pytest.mark.parametrize(
    ("outcome", "expected"),
    [
        (CALM, HARMLESS),
        (replace(CALM, largest_ua=(0, 90_000, 0)), HARMLESS),  # within 1 %, and over
        (replace(CALM, wrong_clocks=1, first_wrong=3), SILENT),
        (replace(CALM, brake_clocks=1), SILENT),
        (replace(CALM, converged=False), LATENT),
        (replace(CALM, converged=False, largest_ua=(0, 0, 1200)), LATENT),
        (replace(CALM, converged=False, largest_ua=(0, 0, 1201)), SILENT),
        (STOPPED, SILENT),  # brakes engaged, and nobody knows why
        (replace(STOPPED, causes=1 << 7), BRAKED),
        (replace(STOPPED, causes=1 << 7, wrong_clocks=500, first_wrong=3), BRAKED),
        (replace(STOPPED, causes=1 << 7, released_wrongly=True), SILENT),
        (replace(STOPPED, causes=1 << 7, enable=1), SILENT),
        (replace(STOPPED, causes=1 << 7, brakes=2), SILENT),
        (replace(CALM, converged=False, causes=1), LATENT),  # a cause that nothing follows
    ],
)
def test_classes_of_outcomes(outcome, expected):
    assert classify(outcome, UA_PER_MN) == expected


def test_answer_of_the_bench_is_parsed():
    line = "0 40192 1 5 6 7 40 151 2 1 3 1 129 70 71"
    assert parse(line) == Outcome(False, 40192, True, (5, 6, 7), 40, 151, 2, True, 3, 1, 129, (70, 71))


def test_bound_of_a_share():
    """Clopper-Pearson: none in n bounds the share at 1 - 0.025^(1/n); all in n leaves it at one."""
    assert upper_bound(0, 300) == pytest.approx(1 - 0.025 ** (1 / 300))
    assert upper_bound(300, 300) == 1.0


def test_all_state_is_found():
    found = find_state(VERILOG, "gc_outer", ["gc_inner", "gc_outer"])
    assert found == [
        Store(("gc_outer",), "gc_outer", "n6_q", "n6_q", 1, 0, ()),
        Store(("gc_outer", "i_a"), "gc_inner", "n2_q", "q", 8, 0, ()),
        Store(("gc_outer", "i_a"), "gc_inner", "n5", "n5", 8, 8, ("n3_o",)),
        Store(("gc_outer", "i_b"), "gc_inner", "n2_q", "q", 8, 0, ()),
        Store(("gc_outer", "i_b"), "gc_inner", "n5", "n5", 8, 8, ("n3_o",)),
    ]
    assert found[1].member("n2_q") == "gc_outer__DOT__i_a__DOT__n2_q"
    public = make_public(VERILOG)
    for line in ("reg [7:0] n2_q {};", "reg [7:0] n5[7:0]  {};", "wire [2:0] n3_o {};", "reg n6_q {};"):
        assert line.format("/*verilator public_flat_rd*/") in public
    assert public.count("verilator") == 4


def test_state_that_is_not_understood_is_refused():
    with pytest.raises(InputError, match="gc_inner_8: no entity"):
        find_state(VERILOG, "gc_outer", ["gc_outer"])
    with pytest.raises(InputError, match="neither register nor memory: n6_q"):
        find_state(VERILOG.replace("reg n6_q", "integer n6_q"), "gc_outer", ["gc_inner", "gc_outer"])


def test_tables_count_each_flip_once():
    stores = find_state(VERILOG, "gc_outer", ["gc_inner", "gc_outer"])
    flips = [Flip("rom", 0, 0, 0, 0), Flip("rom", 0, 1, 0, 3), Flip("rom", 0, 2, 5, 3), Flip("rom", 0, 1, 0, 3)]
    outcomes = [CALM, STOPPED, replace(STOPPED, causes=1), replace(CALM, largest_ua=(4000, 0, 0), wrong_clocks=2)]
    judged = judge(stores, flips, outcomes, UA_PER_MN)
    assert table(judged, stores, [1, 8, 20, 0, 0]).splitlines()[2:] == [
        "| gc_inner | 144 | 28 | 3 | 0 | 1 | 0 | 2 | 99.16 % |",
        "| gc_outer | 1 | 1 | 1 | 1 | 0 | 0 | 0 | 97.50 % |",
        "| **all** | 145 | 29 | 4 | 1 | 1 | 0 | 2 | 93.24 % |",
    ]
    assert silent_table(judged, UA_PER_MN).splitlines()[2:] == ["| gc_inner | `q` | 2 | 2 | 200 | 1 | 1 |"]


def test_rows_of_some_entities_are_renewed():
    """The others stay, sums and bound are those of all."""
    header = [
        "| entity | bits | flips | harmless | braked | latent | silently wrong | silently wrong, 95 % bound |",
        "|-|",
    ]
    old = "\n".join([*header, "| gc_a | 8 | 100 | 90 | 0 | 0 | 10 | 18 % |",
                     "| gc_b | 2 | 300 | 300 | 0 | 0 | 0 | 1 % |",
                     f"| {ALL} | 10 | 400 | 390 | 0 | 0 | 10 | 5 % |"])  # fmt: skip
    new = "\n".join(
        [*header, "| gc_a | 9 | 100 | 60 | 40 | 0 | 0 | 4 % |", f"| {ALL} | 9 | 100 | 60 | 40 | 0 | 0 | 4 % |"]
    )
    bound = f"{100 * upper_bound(0, 400):.2f} %"
    table = merged(old, new, ["gc_a"])
    assert table.splitlines()[2:] == [
        "| gc_a | 9 | 100 | 60 | 40 | 0 | 0 | 4 % |",
        "| gc_b | 2 | 300 | 300 | 0 | 0 | 0 | 1 % |",
        f"| {ALL} | 11 | 400 | 360 | 40 | 0 | 0 | {bound} |",
    ]
    assert shares(table)["gc_a"] == {HARMLESS: 60, BRAKED: 40, LATENT: 0, SILENT: 0}
