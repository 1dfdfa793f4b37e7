"""Records of gc_recorder become the measured CSV that the diagnosis reads: units, signs, what is left out."""

import numpy as np
import pytest

from gravcomp.errors import InputError
from gravcomp.logs.csv_reader import read_measurement
from gravcomp.logs.records import measured_csv, records_of, speeds
from gravcomp.twin.encoder import NO_PERIOD
from gravcomp.twin.recorder import LOST_BEFORE, STALE, Mode, Recorder
from machines import MACHINE

TICK_S = 1e-3


def words(rows, n_axes=3) -> list[int]:
    """Words of records (tick, flags, [count, period, sense, command, force] per axis)."""
    return [value % 2**32 for tick, flags, *axes in rows for value in (tick, flags, *np.ravel(axes).tolist())]


def some(n, rng, flags=0):
    axes = rng.integers(-(2**20), 2**20, (n, 3, 5))
    return [(7 + k, flags, *axes[k]) for k in range(n)], axes


def test_words_become_fields_with_their_signs():
    rows, axes = some(5, np.random.default_rng(1))
    rows[2] = (rows[2][0], LOST_BEFORE | 0x3FFFFFFF, *rows[2][2:])
    rows[3] = (rows[3][0], STALE | 5, *rows[3][2:])
    records = records_of(words(rows), 3)
    for k, name in enumerate(("count", "period", "sense", "command", "force")):
        np.testing.assert_array_equal(getattr(records, name), axes[:, :, k])
    assert records.tick.tolist() == [7, 8, 9, 10, 11]
    assert records.status.tolist() == [0, 0, 2**30 - 1, 5, 0]
    assert records.was_lost.tolist() == [False, False, True, False, False]
    assert records.is_stale.tolist() == [False, False, False, True, False]


def test_twin_and_reader_have_one_layout():
    """Through the twin, which equals the RTL: what goes in comes out."""
    recorder = Recorder(2, 8, Mode.FREE)
    recorder.sense(0, -5)
    recorder.sense(1, 6)
    axes = [{"count": -10 - k, "period": 20 + k, "command": -30 - k, "force": 40 + k} for k in range(2)]
    recorder.tick(1, 3, axes)
    records = records_of(np.ravel(recorder.records), 2)
    assert records.sense.tolist() == [[-5, 6]]
    for name in axes[0]:
        assert getattr(records, name).tolist() == [[axis[name] for axis in axes]]


def test_tick_number_goes_on_where_it_wraps():
    rows, _ = some(3, np.random.default_rng(2))
    rows = [(tick, *row[1:]) for tick, row in zip((2**32 - 2, 2**32 - 1, 1), rows, strict=True)]
    assert np.diff(records_of(words(rows), 3).tick).tolist() == [1, 2]


def test_speed_is_four_counts_per_period():
    assert speeds(np.array([[4000, -1000, NO_PERIOD]]), 40e6).tolist() == [[40_000.0, -160_000.0, 0.0]]


def test_log_is_read_back_as_it_was_measured(tmp_path):
    """Positions to a count, currents to a microampere, velocities and times; by the reader of the diagnosis."""
    rng = np.random.default_rng(3)
    rows, axes = some(40, rng)
    axes[:, :, 0] //= 16  # counts within the workspace
    path = tmp_path / "log.csv"
    path.write_text(measured_csv(records_of(words(rows), 3), MACHINE, TICK_S))
    measured = read_measurement(path, MACHINE)
    np.testing.assert_allclose(measured.q, axes[:, :, 0] / MACHINE.drive.counts_per_unit, atol=1e-12)
    np.testing.assert_allclose(measured.force, axes[:, :, 2] * 1e-6 * MACHINE.drive.effort_per_ampere, rtol=1e-8)
    np.testing.assert_allclose(measured.v, speeds(axes[:, :, 1], MACHINE.clock_hz) / MACHINE.drive.counts_per_unit)
    np.testing.assert_allclose(measured.t_s, np.arange(40) * TICK_S, atol=1e-12)


def test_columns_carry_units_of_the_contract():
    rows, axes = some(3, np.random.default_rng(4))
    approach = np.full((3, 3), -0.02)
    text = measured_csv(records_of(words(rows), 3), MACHINE, TICK_S, approach=approach, with_feed_forward=True)
    header, first, *_ = text.splitlines()
    assert header == "t_s,q1_m,q2_m,q3_m,v1_mps,v2_mps,v3_mps,i1_a,i2_a,i3_a,fm1_n,fm2_n,fm3_n"
    values = [float(cell) for cell in first.split(",")]
    np.testing.assert_allclose(values[4:7], -0.02)
    np.testing.assert_allclose(values[7:10], axes[0, :, 2] * 1e-6)
    np.testing.assert_allclose(values[10:], axes[0, :, 4] * 1e-3)


def test_records_without_a_current_are_left_out():
    rows, _ = some(4, np.random.default_rng(5))
    rows[1] = (rows[1][0], STALE, *rows[1][2:])
    lines = measured_csv(records_of(words(rows), 3), MACHINE, TICK_S).splitlines()
    assert [float(line.split(",")[0]) for line in lines[1:]] == [0.0, 0.002, 0.003]


def test_what_does_not_fit_is_refused():
    rows, _ = some(2, np.random.default_rng(6), flags=STALE)
    good = words(rows)
    with pytest.raises(InputError, match="33 words are not whole records of 17 words"):
        records_of(good[:-1], 3)
    with pytest.raises(InputError, match="no measured current in any of them"):
        measured_csv(records_of(good, 3), MACHINE, TICK_S)
    with pytest.raises(InputError, match=r"1 axes, but .* has 3"):
        measured_csv(records_of(good[:14], 1), MACHINE, TICK_S)
    with pytest.raises(InputError, match=r"approach velocities are \(1, 3\), records \(2, 3\)"):
        measured_csv(records_of(good, 3), MACHINE, TICK_S, approach=np.zeros((1, 3)))
