"""The blind tally's arithmetic, on outcomes made by hand: which count as right, the rows of the table, the misses."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from gravcomp.measured.blind import CASES
from gravcomp.measured.tally import (
    AFTER_LIMIT,
    Outcome,
    confusion_png,
    markdown,
    pooled_ratio,
    run_all,
    run_case,
    summary,
)
from measured_samples import holds

RIGHT = Outcome(
    kind="listed", seed=0, truth="payload", machine="holds", n_samples=120, ratio=2.0, named=("payload",), listed=(),
    verdict="explained", driver="q1", is_driver_right=False, after_ratio=1.0,
)  # fmt: skip
CLEAN = replace(RIGHT, kind="clean", truth="", named=(), verdict="nothing_missing", driver="", ratio=0.0)
UNLISTED = replace(RIGHT, kind="unlisted", truth="soft_stop", named=(), verdict="unexplained", is_driver_right=True)
WRONG = replace(RIGHT, named=("cable_spring",), verdict="partly_explained", after_ratio=1.2)


@pytest.mark.parametrize(
    ("outcome", "is_right"),
    [
        (RIGHT, True),
        (replace(RIGHT, named=("current_offset", "payload")), True),
        (replace(WRONG, listed=("cable_spring", "payload")), True),
        (WRONG, False),
        (replace(WRONG, is_driver_right=True), False),
        (replace(RIGHT, named=()), False),
        (CLEAN, True),
        (replace(CLEAN, verdict="unexplained"), True),
        (replace(CLEAN, named=("payload",)), False),
        (UNLISTED, True),
        (replace(UNLISTED, is_driver_right=False), False),
    ],
)
def test_outcome_is_right_only_as_its_kind_asks(outcome, is_right):
    assert outcome.is_right is is_right


def test_summary_counts_each_kind_by_itself():
    outcomes = [
        *[RIGHT] * 5, replace(WRONG, listed=("cable_spring", "payload")), WRONG, replace(RIGHT, after_ratio=1.06),
        *[CLEAN] * 3, replace(CLEAN, named=("payload",)),
        *[UNLISTED] * 2, replace(UNLISTED, named=("payload",)), replace(UNLISTED, is_driver_right=False),
        replace(UNLISTED, is_driver_right=False, named=("payload",)),
    ]  # fmt: skip
    rows = {what: (value, n) for what, value, _, n in summary(outcomes)}
    assert rows == {
        "listed: right effect named or listed": (pytest.approx(100 * 7 / 8), 8),
        "listed: right effect named itself": (pytest.approx(100 * 6 / 8), 8),
        f"listed: after-error <= {AFTER_LIMIT} x noise": (pytest.approx(100 * 5 / 8), 8),
        "clean: no effect named": (pytest.approx(75.0), 4),
        "unlisted: right driver first": (pytest.approx(60.0), 5),
        "unlisted: physical name given": (pytest.approx(40.0), 5),
    }


def test_after_error_at_the_limit_is_within_it():
    rows = summary([replace(RIGHT, after_ratio=AFTER_LIMIT), CLEAN, UNLISTED])
    assert rows[2][1] == 100.0


def test_targets_are_those_of_the_contract():
    targets = [target for _, _, target, _ in summary([RIGHT, CLEAN, UNLISTED])]
    assert targets == [">= 95", "-", "-", ">= 97", ">= 90", "<= 5"]
    assert AFTER_LIMIT == 1.05


def test_ratio_is_pooled_over_its_own_kind():
    outcomes = [replace(RIGHT, after_ratio=1 + k / 100) for k in range(21)] + [replace(CLEAN, after_ratio=9.0)]
    assert pooled_ratio(outcomes, "listed") == (pytest.approx(1.10), pytest.approx(1.19))


def test_page_lists_every_miss_and_no_hit():
    named = replace(UNLISTED, seed=7, named=("payload",))
    outcomes = [RIGHT, replace(WRONG, seed=41), CLEAN, replace(CLEAN, seed=5, named=("payload",)), UNLISTED, named]
    page = markdown(outcomes, 200, "make blind")
    misses = page.split("## Misses")[1].strip().splitlines()[2:]
    assert [line.split("|")[1:3] for line in misses] == [
        [" listed ", " 41 "], [" clean ", " 5 "], [" unlisted ", " 7 "]
    ]  # fmt: skip
    assert "| payload | cable_spring | partly_explained | q1 | 1.20 |" in misses[0]
    assert "| listed: right effect named or listed | 50.0 | >= 95 | 2 |" in page
    assert "2 seeds of each kind from 200 on" in page


def test_picture_counts_a_truth_among_several_names_as_itself():
    outcomes = [replace(RIGHT, named=("current_offset", "payload")), CLEAN, UNLISTED, WRONG]
    first = confusion_png(outcomes)
    assert first.startswith(b"\x89PNG")
    assert confusion_png([RIGHT, *outcomes[1:]]) == first
    assert confusion_png([replace(RIGHT, named=("current_offset",)), *outcomes[1:]]) != first


def test_every_kind_is_run_with_every_seed(monkeypatch):
    monkeypatch.setattr("gravcomp.measured.tally.run_case", lambda kind, seed: (kind, seed))
    assert run_all(2, 30, 1) == [(kind, seed) for kind in CASES for seed in (30, 31)]


def test_run_compares_what_was_named_with_the_sealed_answer(monkeypatch):
    rng = np.random.default_rng(2)
    noise = 0.1 * rng.standard_normal((200, 3))
    data = holds(200, 3)
    data = replace(data, force=data.nominal + 0.5 * np.sign(data.v) + noise)
    case = SimpleNamespace(data=data, truth="coulomb_friction", axes=(0, 1, 2), noise=noise, machine="holds", ratio=5.0)
    monkeypatch.setattr("gravcomp.measured.blind.draw", lambda kind, seed: case)
    outcome = run_case("listed", 9)
    assert (outcome.kind, outcome.seed, outcome.n_samples) == ("listed", 9, 200)
    assert (outcome.truth, outcome.named, outcome.is_right) == ("coulomb_friction", ("coulomb_friction",), True)
    assert outcome.after_ratio == pytest.approx(1.0, abs=0.05)
