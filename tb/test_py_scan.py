"""Periodic lines and steps in a residual: found where they are, on their own axis, and none in noise or trends."""

import numpy as np
import pytest

from gravcomp.diagnosis import corrections
from gravcomp.diagnosis.search.hinge import SIDES, corner_in, corners_in, hinge
from gravcomp.diagnosis.search.periodogram import find_lines, pitch_of, step_in
from measured_samples import holds

SPAN_M = 0.16
PITCH_M = 0.012


def scattered(seed: int, n: int = 1000) -> tuple[np.ndarray, np.ndarray]:
    """Positions (n, 3), m, and white noise of variance one (n, 3)."""
    rng = np.random.default_rng(seed)
    return rng.uniform(-SPAN_M / 2, SPAN_M / 2, (n, 3)), rng.standard_normal((n, 3))


def ripple(q, harmonic=1):
    return np.sin(2 * np.pi * harmonic * q / PITCH_M + 0.7)


def test_lines_are_found_strongest_first_and_nothing_else():
    q, noise = scattered(1)
    r = noise + 1.0 * ripple(q, 3) + 2.0 * ripple(q) + 0.5 * ripple(q, 7)
    cycles = [frequency * PITCH_M for frequency, _ in find_lines(q, r)]
    np.testing.assert_allclose(cycles, [1, 3, 7], atol=0.1 * PITCH_M / SPAN_M)


def test_ripple_of_few_cycles_leaves_no_lines_beside_it():
    """The trend of a few cycles isn't small; it must not stay behind as lines."""
    q, noise = scattered(6, 400)
    wave = np.sin(2 * np.pi * q / 0.03 + 0.3) + 0.5 * np.sin(4 * np.pi * q / 0.03)
    pitch, harmonics = pitch_of(find_lines(q, wave + 0.1 * noise), SPAN_M, None)
    assert (harmonics, pitch) == ((1, 2), pytest.approx(0.03, rel=0.01))


def test_ripple_shows_over_its_own_axis_and_variable_alone():
    q, r = scattered(2)
    r[:, 1] += 1.5 * ripple(q[:, 1])
    t = np.arange(len(q), dtype=float)
    found = [[len(find_lines(x, r[:, [axis]])) for axis in range(3)] for x in (q[:, 0], q[:, 1], q[:, 2], t)]
    assert found == [[0, 0, 0], [0, 1, 0], [0, 0, 0], [0, 0, 0]]


@pytest.mark.parametrize("n_columns", [1, 3])
def test_noise_has_no_lines(n_columns):
    """The threshold's own rate is exp(-7), 0.05 false alarms in 50 scans."""
    drawn = [scattered(seed) for seed in range(50)]
    assert sum(bool(find_lines(q[:, :n_columns], r[:, :n_columns])) for q, r in drawn) <= 1


def test_weak_line_is_found_nearly_always():
    """A quarter of the noise over 1000 samples has a power of 15.6, near the threshold; twice that is safe."""
    found = 0
    for seed in range(50):
        q, r = scattered(seed)
        lines = find_lines(q[:, 0], r[:, [0]] + 0.35 * ripple(q[:, [0]]))
        found += bool(lines) and abs(lines[0][0] * PITCH_M - 1) < 0.5 * PITCH_M / SPAN_M
    assert found >= 48


def test_smooth_trend_is_no_ripple():
    q, r = scattered(3)
    x = q / (SPAN_M / 2)
    assert find_lines(q, 0.1 * r + 5 * x**3 - 20 * x + np.exp(x)) == []


def test_axis_that_does_not_move_has_no_lines():
    q, r = scattered(4)
    q[:, 2] = 0.01
    assert find_lines(q, r + 5 * ripple(q)) == []


@pytest.mark.parametrize("when", [120.0, 500.0, 870.0])
def test_step_is_found_at_its_time(when):
    t, r = np.arange(1000.0), np.random.default_rng(5).standard_normal(1000)
    assert step_in(t, r + 2.0 * (t > when)) == pytest.approx(when, abs=6.0)


def test_pitch_is_the_fundamental_even_where_it_has_no_line_itself():
    for harmonics in [(1,), (1, 2, 5), (2, 3), (3, 4, 5)]:
        lines = [(h / PITCH_M, 100.0 / (1 + k)) for k, h in enumerate(harmonics)]
        pitch, found = pitch_of(lines, SPAN_M, None)
        assert (found, pitch) == (harmonics, pytest.approx(PITCH_M))


def test_lines_off_the_harmonics_are_left_out():
    lines = [(1 / PITCH_M, 100.0), (2 / PITCH_M, 50.0), (2.37 / PITCH_M, 20.0)]
    assert pitch_of(lines, SPAN_M, None)[1] == (1, 2)


def test_orders_of_a_full_turn_are_counted_per_turn():
    turn = 2 * np.pi
    pitch, orders = pitch_of([(72 / turn, 90.0), (18 / turn, 20.0), (7 / turn, 15.0)], turn, turn)
    assert (pitch, orders) == (pytest.approx(turn), (7, 18, 72))


def test_no_lines_have_no_pitch():
    assert pitch_of([], SPAN_M, None) is None


def test_harmonics_of_a_pitch_can_be_told_from_one_another():
    """Any two lines of a few cycles are near to two of a pitch that is longer than the range."""
    for first, second in np.random.default_rng(13).uniform(2.0, 6.0, (200, 2)):
        pitch, _ = pitch_of([(first / SPAN_M, 34.0), (second / SPAN_M, 23.0)], SPAN_M, None)
        assert SPAN_M / pitch > 0.9


@pytest.mark.parametrize("cycles", [2.5, 2.7, 2.9, 3.0, 3.3])
@pytest.mark.parametrize("phase", [0.0, 1.6])
def test_line_of_few_cycles_is_found_where_it_is(cycles, phase):
    """A trend takes the more of a wave the fewer its cycles, so the peak of the power lies above it."""
    q, noise = scattered(11)
    x = q[:, 0]
    wave = np.sin(2 * np.pi * cycles * x / SPAN_M + phase)
    (frequency, _), *_ = find_lines(x, wave[:, None] + 0.3 * noise[:, [0]])
    assert frequency * SPAN_M == pytest.approx(cycles, abs=0.05)


@pytest.mark.parametrize("power", [1.0, 2.0])
def test_both_ends_of_a_travel_are_found_together(power):
    """The corners of one end alone lie where the other end's force is."""
    q, noise = scattered(12)
    x = q[:, 0] / SPAN_M  # -0.5..0.5
    force = 40.0 * (hinge(x, 0.1, 1.0, power) - 0.7 * hinge(x, -0.2, -1.0, power)) + 3.0 + 0.3 * noise[:, 0]
    np.testing.assert_allclose(corners_in(x, force, power), (-0.2, 0.1), atol=0.03)
    assert corners_in(x[:10], force[:10], power) is None


def test_stop_is_scanned_without_what_is_left_out():
    """Its deepest samples are gross errors until it has a name; as zeros they would move the corner."""
    data = holds(600, 1)
    force = 3000.0 * hinge(data.q, 0.05, 1.0, 1.0)
    keep = force < 60.0
    found = corrections.hinges(data, np.arange(600), force * keep, keep)
    corners = [own.shape[0] for own in found if own.kind == "hinge" and own.shape[1:] == (1.0, 1.0)]
    np.testing.assert_allclose(corners, 0.05, atol=2e-4)


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("power", [1.0, 2.0])
def test_corner_is_found_where_a_stop_begins(side, power):
    q, noise = scattered(9)
    x = q[:, 0] / SPAN_M  # -0.5..0.5
    force = 40.0 * np.maximum(side * (x - 0.1), 0.0) ** power + 3.0 + 0.5 * noise[:, 0]
    assert corner_in(x, force, side, power) == pytest.approx(0.1, abs=0.03)


def test_corner_needs_room_on_both_sides():
    assert corner_in(np.zeros(100), np.ones(100), 1.0, 1.0) is None
    assert corner_in(np.arange(10.0), np.ones(10), 1.0, 1.0) is None
