"""Clocks and positions as loggers write them: stamps coarser than the rows, single positions that are none."""

import numpy as np
import pytest

from gravcomp.logs.clock import spread
from gravcomp.logs.csv_reader import read_measurement
from gravcomp.logs.glitches import without_glitches

N, STEP_S = 400, 0.01


def arm_log(tmp_path, t, q):
    model = 8.0 * np.cos(q)
    rows = np.column_stack([t, q, model, model])
    path = tmp_path / "log.csv"
    path.write_text("t_s,q1_rad,f1_nm,fm1_nm\n" + "\n".join(",".join(f"{x:.9g}" for x in row) for row in rows) + "\n")
    return read_measurement(path)


def motion():
    t = STEP_S * np.arange(N)
    return t, np.sin(2.0 * t), 2.0 * np.cos(2.0 * t)


@pytest.mark.parametrize("times", [2, 3])
def test_rows_of_a_coarse_clock_lie_evenly_between_its_stamps(tmp_path, times):
    """Every stamp stands in two or three rows; the velocity is that of the rows, not half of it."""
    t, q, v = motion()
    coarse = t[np.arange(N) // times * times]
    data = arm_log(tmp_path, coarse, q)
    np.testing.assert_allclose(data.t_s, t, atol=1e-9)
    assert np.abs(data.v[10:-10, 0] - v[10:-10]).max() < 0.02
    assert any("spread evenly" in note for note in data.notes)


def test_spread_keeps_runs_apart():
    t, run = np.array([0.0, 0.0, 2.0, 2.0, 7.0, 7.0, 9.0, 9.0]), np.repeat([0, 1], 4)
    np.testing.assert_allclose(spread(t, run), [0.0, 1.0, 2.0, 3.0, 7.0, 8.0, 9.0, 10.0])


def test_single_bad_positions_are_drawn_between_their_neighbours(tmp_path):
    t, q, v = motion()
    bad = q.copy()
    bad[[60, 250]] += [1.5, -0.9]
    data = arm_log(tmp_path, t, bad)
    np.testing.assert_allclose(data.q[:, 0], q, atol=1e-3)
    assert np.abs(data.v[10:-10, 0] - v[10:-10]).max() < 0.02
    assert any("q1: 2 single positions" in note for note in data.notes)


@pytest.mark.parametrize("kind", ["motion", "holds", "grid", "steps"])
def test_good_positions_stay(kind):
    rng = np.random.default_rng(1)
    q = {
        "motion": motion()[1],
        "holds": rng.uniform(-1.0, 1.0, N),
        "grid": np.abs(np.arange(N) % 100 - 50) / 50.0,
        "steps": np.repeat(rng.uniform(-1.0, 1.0, N // 20), 20),
    }[kind]
    same, notes = without_glitches(q[:, None], np.zeros(N, int))
    np.testing.assert_array_equal(same[:, 0], q)
    assert notes == []
