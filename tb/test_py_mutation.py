"""The mutation tool: what it plants, that it tells a caught mutant from a survivor, and its table."""

import shutil

import pytest

from gravcomp.errors import InputError
from gravcomp_lab.mutation import campaign, equivalence, trial
from gravcomp_lab.mutation.campaign import markdown, plan, reasons, to_try
from gravcomp_lab.mutation.equivalence import proof, write_originals
from gravcomp_lab.mutation.mutants import Mutant, candidates, draw
from gravcomp_lab.mutation.trial import (
    CAUGHT,
    EQUIVALENT,
    INVALID,
    SURVIVED,
    TIMEOUT,
    Outcome,
    relevant_tests,
    run_tests,
    try_mutant,
)
from gravcomp_lab.mutation.verdicts import Verdicts
from gravcomp_lab.synthesis.verilog import source_of
from gravcomp_lab.synthesis.yosys import run_passes
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


def test_plan_plants_four_hundred_in_the_vhdl():
    planned = plan(ROOT, 440, 1)
    assert sum(min(share, len(order)) for share, order in planned.values()) >= 400
    assert planned["gc_delay"] == plan(ROOT, 440, 1, ["gc_delay"])["gc_delay"]


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


def test_time_limit_ends_yosys(tmp_path):
    with pytest.raises(InputError, match=r"not done in 0\.2 s"):
        run_passes(["exec -- sleep 30"], tmp_path / "yosys.log", 0.2)


def test_table_explains_a_survivor_by_its_line():
    mutant = in_delay("stages(i) <= stages(i - 01);")
    outcomes = [Outcome(mutant, SURVIVED), Outcome(in_delay("null;"), TIMEOUT)]
    table = markdown(outcomes, {("gc_delay", mutant.good, mutant.bad): "the same number"}, 5, 9)
    assert "| gc_delay | 2 | 0 | 0 | 1 | 1 | 1 |" in table
    assert "| the same number | argued |" in table
    assert "Seed 5; tried: 2 of 9 faults; caught or equivalent: 50.0 %" in table
    assert "What is not tried yet" in table
    assert "What is not tried yet" not in markdown(outcomes, {}, 5, len(outcomes))
    unexplained = markdown(outcomes, {}, 5, 9)
    assert "**not explained**" in unexplained
    assert "Seed 5; tried: 2 of 9 faults; caught or equivalent: 0.0 %" in unexplained
    proven = markdown([Outcome(mutant, EQUIVALENT, "the same netlist")], {}, 5, 9)
    assert "| gc_delay | 1 | 0 | 1 | 0 | 0 | 0 |" in proven
    assert "| the same netlist | proven |" in proven


BOTH = "next_done <= axis(axes_c - 1); next_first <= not axis(axes_c - 1);"
ENABLED = "if enable = '1' and enable_1 = '0' and in_healthy = '1' then"


@pytest.fixture(scope="module")
def originals(tmp_path_factory):
    """With few systems, so that the tests are quick: one lane with a ROM, and every guard."""
    folder = tmp_path_factory.mktemp("originals")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(equivalence, "SYSTEMS", (equivalence.SYSTEMS[1], equivalence.SYSTEMS[-1]))
        write_originals(ROOT / "rtl", folder)
    return folder


@pytest.mark.slow
@pytest.mark.parametrize(
    ("entity", "good", "bad", "how"),
    [
        ("gc_delay", DELAY, "stages(i) <= stages(i - 01);", "the same netlist"),
        ("gc_brake_sequencer", ENABLED, "if in_healthy = '1' and enable_1 /= '1' and enable = '1' then", "Yosys: "),
        ("gc_brake_sequencer", ENABLED, "if enable = '1' and enable_1 = '0' then", ""),
        ("gc_brake_sequencer", "next_v := state_holding_c;", "null;", ""),
        ("gc_delay", DELAY, "null;", ""),
        # In no system, in one with guards alone, for another machine alone.
        ("gc_biss", "bits <= bits + 1;", "bits <= bits - 1;", ""),
        ("gc_biss", "bits <= bits + 1;", "bits <= 1 + bits;", "Yosys: "),
        ("gc_biss", "ma <= not ma;", "ma <= ma;", ""),
        # A register that differs where it does not matter: no matching of registers shows it.
        ("gc_brake_test", "next_done <= axis(axes_c - 1);", BOTH, "ABC: "),
        ("gc_lockstep", "if in_twin /= main(lag_g) then", "if in_twin = main(lag_g) then", ""),
        ("gc_turn_stage", "waits <= in_valid;", "waits <= not in_valid;", ""),
    ],
    ids=[
        "number",
        "order",
        "condition",
        "assignment",
        "delay",
        "alone",
        "alone-order",
        "alone-assignment",
        "ports",
        "guard",
        "machine",
    ],
)
def test_only_what_changes_nothing_is_proven(originals, entity, good, bad, how, tmp_path):
    rtl = tmp_path / "rtl"
    shutil.copytree(ROOT / "rtl", rtl)
    source = source_of(rtl, entity)
    source.write_text(mutant_of(entity, good, bad).plant(source.read_text()))
    found = proof(originals, rtl, entity, tmp_path)
    assert found.startswith(how)
    assert bool(found) == bool(how)


@pytest.mark.slow
def test_a_proven_mutant_runs_no_further_test(originals):
    mutant = in_delay("stages(i) <= stages(i - 01);")
    outcome = try_mutant(mutant, ROOT, ["test_rtl_delay.py", "no_such_file.py"], 300.0, originals)
    assert (outcome.result, outcome.test) == (EQUIVALENT, "the same netlist")


@pytest.fixture
def tree(tmp_path):
    """A tree of its own, and its table of verdicts: one caught by its own test, one that changes nothing."""
    for folder in ("rtl", "tb"):
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__"))
    caught = Outcome(in_delay("null;"), CAUGHT, "test_rtl_delay.py::test_delay", 3.0)
    equal = Outcome(in_delay("stages(i) <= stages(i - 01);"), EQUIVALENT, "the same netlist", 9.0)
    Verdicts(tmp_path / "verdicts.csv", tmp_path).keep([caught, equal])
    return tmp_path, caught, equal


def test_verdicts_are_kept_while_nothing_they_rest_on_changes(tree):
    root, caught, equal = tree
    verdicts = Verdicts(root / "verdicts.csv", root)
    assert [verdicts.known(outcome.mutant) for outcome in (caught, equal)] == [caught, equal]
    assert verdicts.known(in_delay("stages(i) <= stages(i - 2);")) is None
    assert verdicts.killers("gc_delay") == ["test_rtl_delay.py"]


@pytest.mark.parametrize(
    ("file", "is_kept"),
    [
        ("rtl/common/gc_delay.vhd", (False, False)),
        ("rtl/common/gc_copy.vhd", (True, True)),
        ("tb/test_rtl_delay.py", (False, False)),
        ("tb/test_rtl_core.py", (True, False)),  # gc_core has a gc_delay
        ("tb/test_rtl_ring.py", (True, True)),
    ],
)
def test_verdicts_fall_with_what_they_rest_on(tree, file, is_kept):
    root, *outcomes = tree
    with (root / file).open("a") as text:
        text.write("\n")
    verdicts = Verdicts(root / "verdicts.csv", root)
    assert tuple(verdicts.known(outcome.mutant) is not None for outcome in outcomes) == is_kept


def test_only_entities_with_an_unknown_verdict_are_tried(tree):
    root, caught, equal = tree
    verdicts = Verdicts(root / "verdicts.csv", root)
    invalid = Outcome(in_delay("stages(i) <= stages;"), INVALID)
    new = in_delay("stages(i) <= stages(i - 2);")
    assert to_try({"gc_delay": (2, [caught.mutant, equal.mutant, new])}, verdicts) == []
    assert to_try({"gc_delay": (2, [caught.mutant, new, equal.mutant])}, verdicts) == ["gc_delay"]
    verdicts.keep([caught, equal, invalid])
    verdicts = Verdicts(root / "verdicts.csv", root)
    assert to_try({"gc_delay": (2, [invalid.mutant, caught.mutant, equal.mutant])}, verdicts) == []
    assert to_try({"gc_delay": (3, [invalid.mutant, caught.mutant, equal.mutant, new])}, verdicts) == ["gc_delay"]


def test_known_verdicts_are_told_up_to_the_share(tree):
    root, caught, equal = tree
    new = in_delay("stages(i) <= stages(i - 2);")
    verdicts = Verdicts(root / "verdicts.csv", root)
    planned = {"gc_delay": (2, [new, caught.mutant, equal.mutant])}
    assert [outcome.mutant for outcome in campaign.known(planned, verdicts)] == [caught.mutant, equal.mutant]
    assert campaign.known({"gc_delay": (1, planned["gc_delay"][1])}, verdicts) == [caught]


def test_a_run_of_known_verdicts_tries_nothing(tree, monkeypatch):
    root, caught, equal = tree
    monkeypatch.setattr(campaign, "try_mutant", None)
    monkeypatch.setattr(campaign.equivalence, "write_originals", None)
    planned, seen = {"gc_delay": (2, [caught.mutant, equal.mutant])}, []
    outcomes = campaign.run(root, planned, 1, Verdicts(root / "verdicts.csv", root), seen.append)
    assert {outcome.mutant for outcome in outcomes} == {caught.mutant, equal.mutant}
    assert len(seen) == 2


def test_a_trial_whose_time_was_up_leaves_no_verdict(tree):
    root, caught, equal = tree
    Verdicts(root / "verdicts.csv", root).keep([caught, Outcome(equal.mutant, TIMEOUT)])
    verdicts = Verdicts(root / "verdicts.csv", root)
    assert verdicts.known(caught.mutant) == caught
    assert verdicts.known(equal.mutant) is None


@pytest.mark.parametrize("is_argued", [False, True])
def test_a_fault_that_is_argued_is_tried_where_others_were_caught(tree, monkeypatch, is_argued):
    root, caught, _ = tree
    new, tried = in_delay("stages(i) <= stages(i - 2);"), []

    def try_mutant(mutant, root, tests, *_):
        tried.extend(tests)
        return Outcome(mutant, SURVIVED)

    monkeypatch.setattr(campaign, "try_mutant", try_mutant)
    monkeypatch.setattr(campaign.equivalence, "write_originals", lambda *_: None)
    monkeypatch.setattr(campaign, "relevant_tests", lambda *_: [caught.test, "test_rtl_core.py"])
    argued = {("gc_delay", new.good, new.bad)} if is_argued else ()
    campaign.run(root, {"gc_delay": (1, [new])}, 1, Verdicts(root / "verdicts.csv", root), lambda _: None, argued)
    assert tried == ([caught.test] if is_argued else [caught.test, "test_rtl_core.py"])


def test_verdicts_of_other_entities_stay(tree):
    root, caught, _ = tree
    other = Outcome(Mutant("gc_copy", 1, "a", "b", "bit"), CAUGHT, "test_rtl_core.py", 5.0)
    Verdicts(root / "verdicts.csv", root).keep([other])
    verdicts = Verdicts(root / "verdicts.csv", root)
    assert verdicts.known(caught.mutant) == caught
    assert verdicts.known(other.mutant) == other


def test_draw_of_an_entity_does_not_depend_on_others():
    order = draw({"gc_x": VHDL, "gc_y": VHDL}, 10, 3)["gc_y"][1]
    assert draw({"gc_w": VHDL * 2, "gc_y": VHDL}, 10, 3)["gc_y"][1] == order


def test_reasons_name_lines_of_the_vhdl():
    for entity, good, _ in reasons(ROOT / "tb" / "equivalent_mutants.toml"):
        lines = [line.strip() for line in source_of(ROOT / "rtl", entity).read_text().split("\n")]
        assert good in lines, f"{entity}: no line {good!r}"
