"""The mutation tool: what it plants, that it tells a caught mutant from a survivor, and its table."""

import pytest

from gravcomp_lab.mutation import trial
from gravcomp_lab.mutation.campaign import markdown, plan, reasons
from gravcomp_lab.mutation.mutants import Mutant, candidates, draw
from gravcomp_lab.mutation.trial import (
    CAUGHT,
    INVALID,
    SURVIVED,
    TIMEOUT,
    Outcome,
    relevant_tests,
    run_tests,
    try_mutant,
)
from gravcomp_lab.synthesis.verilog import source_of
from runner import ROOT

VHDL = """\
entity gc_x is
  port (a : in bit := '0');
end entity gc_x;
architecture rtl of gc_x is
begin
  -- a comment with '0' and 7
  p : process (clk) is
  begin
    if a = '1' and n > 3 then
      q <= b + 1;
    end if;
    assert n < 4
      report "need n < 4"
      severity failure;
  end process p;
end architecture rtl;
"""
DELAY = "stages(i) <= stages(i - 1);"


def mutant_of(entity: str, good: str, bad: str) -> Mutant:
    lines = source_of(ROOT / "rtl", entity).read_text().split("\n")
    return Mutant(entity, 1 + next(k for k, line in enumerate(lines) if line.strip() == good), good, bad, "constant")


def in_delay(bad: str) -> Mutant:
    return mutant_of("gc_delay", DELAY, bad)


def test_candidates_are_in_code_only():
    found = candidates("gc_x", VHDL)
    assert {mutant.line for mutant in found} == {9, 10}
    assert {mutant.bad for mutant in found if mutant.line == 9} == {
        "if a /= '1' and n > 3 then", "if a = '0' and n > 3 then", "if a = '1' or n > 3 then",
        "if a = '1' and n >= 3 then",
        "if a = '1' and n > 4 then", "if a = '1' and n > 2 then", "if true then", "if not (a = '1' and n > 3) then",
    }  # fmt: skip
    assert {mutant.bad for mutant in found if mutant.line == 10} == {
        "q <= b - 1;", "q <= b + 2;", "q <= b + 0;", "null;",
    }  # fmt: skip


def test_plant_changes_one_line_and_refuses_another_text():
    mutant = candidates("gc_x", VHDL)[0]
    planted = mutant.plant(VHDL)
    assert [
        k for k, (old, new) in enumerate(zip(VHDL.split("\n"), planted.split("\n"), strict=True), 1) if old != new
    ] == [mutant.line]
    with pytest.raises(ValueError, match="expected"):
        mutant.plant(planted)


def test_draw_depends_on_the_seed_alone():
    texts = {"gc_x": VHDL, "gc_y": VHDL}
    assert draw(texts, 10, 3) == draw(dict(reversed(texts.items())), 10, 3)
    assert draw(texts, 10, 3) != draw(texts, 10, 4)
    assert [share for share, _ in draw(texts, 10, 3).values()] == [5, 5]


def test_plan_plants_two_hundred_in_the_vhdl():
    planned = plan(ROOT, 260, 1)
    assert sum(min(share, len(order)) for share, order in planned.values()) >= 200
    assert planned["gc_delay"] == plan(ROOT, 260, 1, ["gc_delay"])["gc_delay"]


def test_tests_of_an_entity_begin_with_its_own():
    files = relevant_tests("gc_multiply", ROOT / "rtl", ROOT / "tb")
    assert files[0] == "test_rtl_multiply.py"
    assert files.index("test_rtl_hidden_lane.py") < files.index("test_rtl_force_path.py")


@pytest.mark.parametrize(
    ("bad", "result"),
    [("null;", CAUGHT), ("stages(i) <= stages(i - 01);", SURVIVED), ("stages(i) <= stages;", INVALID)],
)
def test_mutant_of_the_delay(bad, result):
    outcome = try_mutant(in_delay(bad), ROOT, ["test_rtl_delay.py"], 300.0)
    assert outcome.result == result, outcome
    assert outcome.test.startswith("test_rtl_delay.py") == (result == CAUGHT)


def test_time_limit_ends_an_elaboration(monkeypatch):
    monkeypatch.setattr(trial, "COMPILE_TIMEOUT_S", 10.0)
    endless = mutant_of("gc_fixed_pkg", "depth_v := depth_v + 1;", "null;")
    assert try_mutant(endless, ROOT, [], 300.0).result == INVALID


def test_time_limit_ends_the_tests(tmp_path):
    assert run_tests(ROOT, ROOT / "rtl", tmp_path, ["test_rtl_delay.py"], 0.1) == (TIMEOUT, "")


def test_table_explains_a_survivor_by_its_line():
    mutant = in_delay("stages(i) <= stages(i - 01);")
    outcomes = [Outcome(mutant, SURVIVED), Outcome(in_delay("null;"), TIMEOUT)]
    table = markdown(outcomes, {("gc_delay", mutant.good, mutant.bad): "the same number"}, 5)
    assert "| gc_delay | 2 | 1 | 1 | 1 | 1 |" in table
    assert "the same number" in table
    assert "Seed 5; caught: 50.0 %" in table
    assert "**not explained**" in markdown(outcomes, {}, 5)


def test_reasons_name_lines_of_the_vhdl():
    for entity, good, _ in reasons(ROOT / "tb" / "equivalent_mutants.toml"):
        lines = [line.strip() for line in source_of(ROOT / "rtl", entity).read_text().split("\n")]
        assert good in lines, f"{entity}: no line {good!r}"
