"""Brakes and faults: each claim of tb/formal/safety.sv is refuted where the VHDL is broken."""

import shutil

import pytest

from gravcomp.formal.claims import CLAIMS, verify
from runner import ROOT

(SAFETY,) = (claim for claim in CLAIMS if claim.checker == "safety")
CHECKERS = ROOT / "tb" / "formal"

# By file: VHDL, fault, assertion that must break. The faults of a file are planted together.
PLANTED = {
    "gc_brake_sequencer": [
        ("next_v = state_run_c else '0';\n    end", "next_v /= state_braked_c else '0';\n    end",
         "brakes_are_engaged_but_in_run"),
        ("next_v = state_holding_c or next_v = state_run_c", "next_v /= state_braked_c",
         "command_is_zero_braked_and_in_fault"),
        ("enable_1 = '0' and in_healthy = '1'", "enable_1 = '0'", "motion_starts_by_an_edge_while_healthy"),
        ("next_v := state_holding_c;\n        end if;\n      elsif state = state_h",
         "next_v := state_run_c;\n        end if;\n      elsif state = state_h", "brakes_open_after_the_motors_hold"),
        ("if clear = '1' then", "if enable = '0' then", "fault_lasts_until_clear_while_healthy"),
    ],
    "gc_safety": [
        ("estop_known and not estop_level(0)", "estop_known and estop_level(0)", "emergency_stop_engages_the_brakes"),
        ("if in_illegal(i) = '1'", "if in_illegal(0) = '1'", "lost_counts_engage_the_brakes"),
        ("if in_referenced(i) = '0'", "if in_referenced(0) = '0'", "lost_reference_engages_the_brakes"),
        ("state_braked_c else present", "state_holding_c else present", "causes_engage_the_brakes"),
        ("cleared <= clear and healthy", "cleared <= clear", "causes_are_kept"),
    ],
    "gc_fault_latch": [
        ("sts_fault <= kept_v or in_fault", "sts_fault <= in_fault", "fault_is_the_state_of_latched_causes"),
        ("if kept_v = no_causes_c and in_fault", "if in_fault", "first_is_kept"),
        ("        first_cause <= no_causes_c;\n      end if;\n\n      sts", "      end if;\n\n      sts",
         "first_cause_is_one_of_them"),
    ],
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("file", PLANTED)
def test_planted_faults_of_safety_are_refuted(file, tmp_path):
    shutil.copytree(ROOT / "rtl", tmp_path / "rtl")
    source = tmp_path / "rtl" / f"{file}.vhd"
    text = source.read_text()
    for good, bad, _ in PLANTED[file]:
        assert text.count(good) == 1, good
        text = text.replace(good, bad)
    source.write_text(text)
    verdict = verify(SAFETY, tmp_path / "rtl", CHECKERS, tmp_path / "out")
    assert {assertion for _, _, assertion in PLANTED[file]} <= set(verdict.broken), verdict
