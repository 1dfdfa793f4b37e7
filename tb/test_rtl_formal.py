"""Every claim about the hardware is proven, and every checker refutes a fault planted in the VHDL."""

import shutil
from pathlib import Path

import pytest

from gravcomp_lab.formal.claims import CLAIMS, verify
from gravcomp_lab.synthesis.verilog import source_of
from runner import BUILD, ROOT, RTL

CHECKERS = ROOT / "tb" / "formal"
BY_NAME = {claim.name: claim for claim in CLAIMS}
SLOW = (
    "axi", "interrupts", "force_path-lanes_g4", "valid_pipeline-lanes_g1", "hidden_sums-lanes_g1",
    *(f"output_sums-lanes_g{n}" for n in (1, 2, 4, 5, 10, 20)),
)  # fmt: skip

FILTERED, UNFILTERED = "quad_decoder-filter_samples_g4", "quad_decoder-filter_samples_g0-speed_timeout_g20"

WATCH, INDEX = next(name for name in BY_NAME if name.startswith("edge_watch")), "index_check-mark_clocks_g4"
ONE_SIGN = "pwm-clocks_g6-dead_g2-two_pins_gfalse"

# claim, file, VHDL, fault, assertion that must break
PLANTED = [
    ("glitch_filter-samples_g4", "gc_glitch_filter", "if run_v = samples_g then", "if run_v = samples_g - 1 then",
     "short_pulse_never_passes"),
    ("glitch_filter-samples_g4", "gc_glitch_filter", "run_v := 0;\n          if", "run_v := run;\n          if",
     "dropped_pulse_is_reported"),
    ("glitch_filter-samples_g4", "gc_glitch_filter", "known <= '1';", "known <= known;", "long_level_always_passes"),
    ("glitch_filter-samples_g4", "gc_glitch_filter", "or in_valid = '0' then", "then", "reset_forgets_the_level"),
    (UNFILTERED, "gc_quad_decoder", "count <= count + signed(change_v);", "count <= count + 2;",
     "moves_by_at_most_one"),
    (UNFILTERED, "gc_quad_decoder", "level(0) xor level(1)", "level(0) or level(1)",
     "counts_every_edge"),
    (UNFILTERED, "gc_quad_decoder", "direction <= not change_v(1);", "direction <= '0';",
     "direction_is_that_of_the_edge"),
    (UNFILTERED, "gc_quad_decoder", "sts_illegal <= '1';", "sts_illegal <= not cfg_clear;",
     "illegal_edge_is_flagged"),
    (UNFILTERED, "gc_quad_decoder", "sts_illegal <= '1';\n        sts_referenced <= '0';",
     "sts_illegal <= '1';", "flagged_counts_end_the_reference"),
    (UNFILTERED, "gc_quad_decoder", "or broken or", "or", "what_is_told_is_flagged"),
    (UNFILTERED, "gc_quad_decoder", "synced_valid and synced(3)", "synced_valid and synced(2)", "error_is_flagged"),
    (UNFILTERED, "gc_quad_decoder", "if lost = '1' or", "if lost = '1' or cfg_clear = '1' or",
     "nothing_else_is_flagged"),
    (UNFILTERED, "gc_quad_decoder", "elsif armed = '1' then", "else", "homing_has_seen_a_low_index"),
    (FILTERED, "gc_count_check", "if lead_v = four_c then", "if lead_v = four_c and both_v = '1' then",
     "lost_counts_are_told"),
    (FILTERED, "gc_count_check", "if lead_v = four_c then", "if lead_v = four_c or lead_v = 3 then",
     "no_other_count_is_told_as_lost"),
    (WATCH, "gc_edge_watch", "reserve_v := reserve - 1;", "reserve_v := reserve;", "slow_dither_is_never_a_fault"),
    (WATCH, "gc_edge_watch", "reserve_v := reserve - 1;", "reserve_v := reserve;", "slow_edges_leave_no_reserve"),
    (WATCH, "gc_edge_watch", "reserve_v := reserve + dither_clocks_g - 1;", "reserve_v := dither_clocks_g;",
     "fast_edges_fill_the_reserve"),
    (WATCH, "gc_edge_watch", "or reserve >= nearly_c", "or reserve > nearly_c", "reserve_is_below_its_end"),
    (WATCH, "gc_edge_watch", "edges <= edges_v;", "edges <= 0;", "suspicion_is_held"),
    (WATCH, "gc_edge_watch", "quick <= '1';", "quick <= '0';", "quick_is_held"),
    (WATCH, "gc_edge_watch", "clocks <= 1;", "clocks <= 0;", "clocks_are_those_since_the_step"),
    (WATCH, "gc_edge_watch", "known <= '1';", "known <= known;", "known_is_held"),
    (WATCH, "gc_edge_watch", "broken_v := '0';", "broken_v := quick;", "broken_only_at_an_edge_of_the_same_channel"),
    (WATCH, "gc_edge_watch", "suspect_v := '1';", "suspect_v := suspect;", "turn_on_the_spot_is_found"),
    (WATCH, "gc_edge_watch", "reserve_v := reserve + dither_clocks_g - 1;", "reserve_v := dither_clocks_g;",
     "fast_edges_are_found"),
    (WATCH, "gc_edge_watch", "reserve_v := reserve - 1;", "reserve_v := reserve + 1;", "reserve_never_wraps"),
    (INDEX, "gc_index_check", "last <= cfg_index_period - 1;", "last <= cfg_index_period;", "period_is_taken"),
    (INDEX, "gc_index_check", "rest <= unsigned(signed(rest) - step_v);", "rest <= unsigned(signed(rest) + step_v);",
     "both_are_counted"),
    (INDEX, "gc_index_check", "pins_2 <= pins_1;", "pins_2 <= not pins_1;", "pins_are_those"),
    (INDEX, "gc_index_check", "at_2 <= '1';", "at_2 <= '0';", "place_is_that"),
    (INDEX, "gc_index_check", "stay <= stay + 1;", "stay <= stay;", "stay_is_counted"),
    (INDEX, "gc_index_check", "near_2 = '0' or (pins_2(1) = '1' and at_2 = '0')", "near_2 = '0'",
     "mark_elsewhere_is_told"),
    (INDEX, "gc_index_check", "near_2 = '0' or (", "(", "mark_far_away_is_told"),
    (INDEX, "gc_index_check", "stay /= mark_clocks_g", "stay = mark_clocks_g", "missing_mark_is_told"),
    (INDEX, "gc_index_check", "residue <= cycle_c or", "residue < cycle_c or", "nothing_else_is_told"),
    (FILTERED, "gc_quad_decoder", "if dropped(0) = '1' or dropped(1) = '1'",
     "if dropped(0) = '1'", "dropped_pulse_is_flagged"),
    (UNFILTERED, "gc_quad_decoder", "count <= cfg_index_position;",
     "count <= cfg_index_position + 1;", "homing_sets_the_index_position"),
    (UNFILTERED, "gc_quad_decoder", "direction <= '0';\n        sts", "sts", "reset_clears"),
    (UNFILTERED, "gc_speed_meter", "        speed_zero <= '0';\n        speed_period <= slowest_c;",
     "        speed_zero <= '0';", "reset_forgets_the_speed"),
    ("valid_pipeline-lanes_g4", "gc_core", "since_runs <= in_valid or not since(0);", "since_runs <= in_valid;",
     "ready_after_the_interval"),
    ("valid_pipeline-lanes_g5", "gc_multiply", "valid_2 <= '0';", "valid_2 <= valid_1;", "none_invented"),
    ("valid_pipeline-lanes_g2", "gc_core", "lane_valid <= x_valid or not step(0);", "lane_valid <= x_valid;",
     "none_lost"),
    ("valid_pipeline-lanes_g20", "gc_core", "in_ready <= since(0);", "in_ready <= since(0) and not x_valid;",
     "always_ready"),
    (ONE_SIGN, "gc_pwm", "if wave = '0' and quiet = dead_g then", "if quiet = dead_g then", "sign_changes_in_silence"),
    (ONE_SIGN, "gc_pwm", "negative <= wanted;\n          rest <= dead_g;", "negative <= wanted;",
     "silence_after_the_change"),
    ("output_sums-lanes_g1", "gc_output_layer", "acc(high_c downto low_c) + tree", "acc(high_c downto low_c) - tree",
     "no_sum_overflows"),
    ("output_sums-lanes_g4", "gc_adder_tree", "node(2 * k) + node(2 * k + 1)", "node(2 * k) - node(2 * k + 1)",
     "no_sum_overflows"),
]  # fmt: skip


def planted(folder: Path, file: str, good: str, bad: str) -> Path:
    """A copy of rtl/ in which good, of which there is one in the file, became bad."""
    rtl = folder / "rtl"
    shutil.copytree(ROOT / "rtl", rtl)
    source = source_of(rtl, file)
    text = source.read_text()
    assert text.count(good) == 1, f"{source.name}: {text.count(good)} times {good!r}"
    source.write_text(text.replace(good, bad))
    return rtl


@pytest.mark.parametrize(
    "claim", [pytest.param(c, id=c.name, marks=[pytest.mark.slow] * (c.name in SLOW)) for c in CLAIMS]
)
def test_claim_is_proven(claim):
    verdict = verify(claim, RTL, CHECKERS, BUILD / "formal")
    assert verdict.holds, verdict


@pytest.mark.parametrize(("name", "file", "good", "bad", "assertion"), PLANTED, ids=[p[4] for p in PLANTED])
def test_planted_fault_is_refuted(tmp_path, name, file, good, bad, assertion):
    verdict = verify(BY_NAME[name], planted(tmp_path, file, good, bad), CHECKERS, tmp_path / "out", {assertion})
    assert assertion in verdict.broken, verdict
