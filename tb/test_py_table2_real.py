"""The paper's Table 2 on a real machine: its figures, its rows on made holds, the command and what it refuses."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from sklearn.model_selection import GroupKFold

from gravcomp.diagnosis.diagnosis import diagnose
from gravcomp.diagnosis.effects import effect_named
from gravcomp.diagnosis.model import Model
from gravcomp.diagnosis.samples import split
from gravcomp.logs.measurement import Measurement
from gravcomp.robot.machine import load_machine
from gravcomp_lab.__main__ import main
from gravcomp_lab.paper import table2_real as real
from gravcomp_lab.paper.table2 import ANALYTIC, FIELD
from mechanisms import WEIGHTS
from support.published import published

ROWS = [ANALYTIC, FIELD, real.TUNED, real.FOUND]


def made_holds(n=160) -> Measurement:
    """Of the arm of two links with friction and a heavier forearm, no noise."""
    robot = load_machine(WEIGHTS / "arm2").robot
    rng = np.random.default_rng(5)
    q, v = robot.workspace(n, 5), rng.choice([-0.1, 0.1], (n, 2))
    f = robot.forces(q)
    measured = f + 0.2 * robot.payload_regressors(q)[..., 0] + 0.3 * np.sign(v) + 0.02 * rng.standard_normal(q.shape)
    return Measurement("made", 2.0 * np.arange(n), q, v, measured, f, "Nm", ("rad",) * 2, None, robot.forces, robot)


@pytest.mark.parametrize("seed", [1, 3])
def test_400_holds_of_the_real_arm_have_cables_where_the_arm_has_them(seed):
    """Elastic cables on joints 4 and 5, weights that the model lacks on 2 and 3; 16 mNm of 250 are left, held out and
    on the 5850 holds beside. With draw 3 the weight of the upper arm was a cable on joint 2; with draw 1 that weight
    and a table over q2 were 26 Nm each and cancelled, and 22 mNm were left on the other holds.
    """
    folder = Path(published(str(real.HOLDS))).parents[1]
    machine = load_machine(WEIGHTS / "dvrk_mtm")
    holds = real.read_holds(folder, machine)
    order = np.random.default_rng(seed).permutation(len(holds.t_s))
    own, others = (real.rows_of(holds, np.sort(rows)) for rows in (order[:400], order[400:]))
    found = diagnose(own, Model(machine), seed)
    axes = {e.name: {name.axis + 1 for name in e.parameters if name.axis is not None} for e in found.fit.effects}
    assert "body_moment" in axes
    assert axes["nonlinear_cable_spring"] == {4, 5}
    assert np.sqrt(np.mean(found.after[found.is_test] ** 2)) <= 0.016
    error = others.force - others.nominal - found.fit.predict(others)
    assert np.sqrt(np.mean(error**2)) <= 0.016


def test_small_names_of_the_real_arms_last_joint_hold_on_blocks_that_were_not_fitted():
    """Spring and friction by load on joint 6, of 2 and 3 mNm beside 4.6 that are left without them: what each takes off
    blocks that taught nothing is above zero in 97.5 % of the bootstraps over blocks. No other log of the arm is known.
    """
    folder = Path(published(str(real.HOLDS))).parents[1]
    holds = real.read_holds(folder, load_machine(WEIGHTS / "dvrk_mtm"))
    effort, model, sign = (x[:, 5] for x in (holds.force - holds.nominal, holds.nominal, holds.direction))
    weights = np.stack(list(effect_named("body_moment").columns(holds, {}).values()), axis=-1)[:, 5]
    known = np.column_stack([weights, np.ones(len(effort)), sign])
    blocks = split.block_labels(holds, 1)
    rng = np.random.default_rng(0)
    for column in (holds.q[:, 5], np.abs(model) * sign):
        gain = np.zeros(blocks.max() + 1)
        for train, test in GroupKFold(8).split(known, groups=blocks):
            for x, factor in ((known, 1.0), (np.column_stack([known, column]), -1.0)):
                left = effort[test] - x[test] @ np.linalg.lstsq(x[train], effort[train], rcond=1e-9)[0]
                gain += factor * np.bincount(blocks[test], left**2, len(gain))
        drawn = gain[rng.integers(0, len(gain), (2000, len(gain)))].sum(axis=1)
        assert np.quantile(drawn, 0.025) > 0.0


def test_errors_are_those_of_the_paper_and_in_percent_of_the_rms_effort():
    measured = np.array([[3.0, 4.0], [0.0, 1.0]])
    error = np.array([[0.3, 0.4], [0.0, -0.2]])
    e = real.errors_of(measured + error, measured)
    assert (e.max_percent, e.average_percent) == pytest.approx((20.0, 15.0))
    rms_effort = np.sqrt((25.0 + 1.0) / 2)
    assert (e.max_of_rms, e.average_of_rms) == pytest.approx((50.0 / rms_effort, 35.0 / rms_effort))
    assert e.rms_nm == pytest.approx(np.sqrt((0.25 + 0.04) / 4))


@pytest.mark.slow
def test_what_was_found_beats_the_analytic_model_on_holds_that_taught_nothing(monkeypatch):
    monkeypatch.setattr(real, "_POSES", 300)
    data = made_holds()
    table = real.table2_real(load_machine(WEIGHTS / "arm2"), data, 1, (40, 60), 60)
    assert list(table.errors) == [40, 60]
    assert [*table.errors[60]] == ROWS
    assert table.errors[60][real.FOUND].average_percent < 0.5 * table.errors[60][ANALYTIC].average_percent
    assert len(table.test.t_s) == len(table.sizes[ANALYTIC]) == 100
    assert {entry.name for entry in table.found[60].fit.effects} >= {"coulomb_friction"}


def test_command_writes_the_page_beside_the_papers_figures(monkeypatch, tmp_path):
    errors = {name: real.Errors(40.0 + k, 4.0 + k, 30.0, 3.0 + k, 0.02) for k, name in enumerate(ROWS)}
    found = SimpleNamespace(verdict="explained", fit=SimpleNamespace(effects=[SimpleNamespace(name="payload")],
                                                                     corrections=[]))  # fmt: skip
    q = load_machine(WEIGHTS / "dvrk_mtm").robot.workspace(50, 1)
    sizes = {name: np.linspace(0.0, 0.1 + k, 50) for k, name in enumerate(ROWS)}
    table = real.RealTable({100: errors}, {100: found}, sizes, SimpleNamespace(q=q))
    monkeypatch.setattr("gravcomp_lab.commands.table2_real.table2_real", lambda *_: table)
    monkeypatch.setattr("gravcomp_lab.commands.table2_real.read_holds", lambda *_: SimpleNamespace(t_s=np.zeros(6250)))
    arguments = ["table2-real", "--data", str(tmp_path), "--robot", str(WEIGHTS / "dvrk_mtm"), "--docs", str(tmp_path)]
    assert main(arguments) == 0
    page = (tmp_path / "table2_real.md").read_text()
    assert f"| {ANALYTIC} | 8.5 | 3.8 | 40 | 4.0 | 30.0 | 3.00 | 20.0 |" in page
    assert "| 100 | 3.00 | 4.00 | 5.00 | 6.00 |" in page
    assert "- 100 holds: explained: payload; 0 empirical corrections" in page
    assert (tmp_path / "figures" / "table2_real.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [([], "--data or GRAVCOMP_DATA"), (["--data", "nowhere"], "holds.csv: not found"),
     (["--data", "nowhere", "--seed", "-1"], "negative")],
)  # fmt: skip
def test_command_refuses_in_one_line(monkeypatch, capsys, tmp_path, arguments, words):
    monkeypatch.delenv("GRAVCOMP_DATA", raising=False)
    robot = str(WEIGHTS / "dvrk_mtm")
    assert main(["table2-real", "--robot", robot, "--docs", str(tmp_path), *arguments]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1
    assert not list(tmp_path.iterdir())
