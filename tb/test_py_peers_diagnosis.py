"""Other tools beside the diagnosis: each is right where its own kind of model is; the table counts what they say."""

from dataclasses import replace

import numpy as np
import pytest

from gravcomp_lab.blind import peers
from gravcomp_lab.blind.peers import OURS, TOOLS, ToolResult, table
from measured_samples import holds

NOISE = 0.1


def left_by(tool, force) -> tuple[float, set]:
    """What a tool leaves over the noise on holds that it was not fitted to, and the names that it gives."""
    data = holds(600, 3)
    data = replace(
        data, force=data.nominal + force(data) + NOISE * np.random.default_rng(1).standard_normal(data.shape)
    )
    blocks = np.arange(600) // 30
    is_test = blocks % 4 == 0
    left, named = tool(data, ~is_test, blocks)
    return float(np.sqrt(np.mean(left[is_test] ** 2)) / NOISE), named


def test_least_squares_has_every_friction_term_and_its_name():
    friction = lambda d: 1.0 * np.sign(d.v) + 150.0 * d.v  # noqa: E731
    ratio, named = left_by(peers._least_squares, friction)
    assert ratio == pytest.approx(1.0, abs=0.08)
    assert named >= {"coulomb_friction", "viscous_friction"}


def test_least_squares_names_next_to_nothing_in_noise():
    assert len(left_by(peers._least_squares, lambda d: 0.0 * d.q)[1]) <= 1


def test_sparse_regression_finds_a_polynomial():
    pytest.importorskip("pysindy", reason="pysindy is not installed; make peers-diagnosis installs it")
    ratio, named = left_by(peers._sindy, lambda d: 300.0 * d.q[:, [0]] * d.q)
    assert (ratio, named) == (pytest.approx(1.0, abs=0.1), None)


def test_trees_follow_a_step():
    ratio, named = left_by(peers._trees, lambda d: 2.0 * np.sign(d.q))
    assert ratio < 4.0
    assert named is None


def test_table_counts_names_by_truth_and_sets_in_which_a_tool_is_better():
    ours = ToolResult("listed", ("payload",), 1.0, frozenset({"payload"}), 2.0)
    right, wrong = ours, replace(ours, over_noise=0.9, named=frozenset({"cogging", "payload"}))
    others = {tool: replace(ours, over_noise=1.5, named=None) for tool in TOOLS[2:]}
    page = table([{OURS: right, TOOLS[1]: wrong, **others}, {OURS: right, TOOLS[1]: right, **others}])
    rows = {line.split(" | ")[0].strip("| "): line.split(" | ") for line in page.splitlines()[2:]}
    assert rows[OURS][4:7] == ["0 of 2", "2 of 2", "0"]
    assert rows[TOOLS[1]][1] == "0.950"
    assert rows[TOOLS[1]][4:7] == ["1 of 2", "2 of 2", "1"]
    assert rows[TOOLS[3]][4:7] == ["0 of 2", "none", "none"]
