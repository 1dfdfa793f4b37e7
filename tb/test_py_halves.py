"""What of a remainder goes with the direction: the parts of friction, of what is the same both ways, and of both."""

import numpy as np
import pytest

from gravcomp.diagnosis.samples.halves import Neighbours
from gravcomp.logs.measurement import Measurement

N, NOISE = 600, 0.1


def held(force_of, n=N, noise=NOISE, v=True) -> Measurement:
    """Holds of one axis at scattered places, each approached from either side; force_of(q, direction)."""
    rng = np.random.default_rng(5)
    q, way = rng.uniform(-1.0, 1.0, (n, 1)), rng.choice([-1.0, 1.0], (n, 1))
    force = force_of(q, way) + noise * rng.standard_normal((n, 1))
    return Measurement("held", 2.0 * np.arange(n), q, 0.1 * way if v else None, force, 0.0 * force, "Nm", ("rad",))


def halves_of(data: Measurement, noise=NOISE):
    return Neighbours.of(data, np.arange(len(data.t_s))).halves(data.force, np.full(data.n_axes, noise))


@pytest.mark.parametrize(
    ("force_of", "odd"),
    [
        (lambda q, way: way, 1.0),
        (lambda q, way: (1.0 + 0.3 * q) * way, 1.0),
        (lambda q, way: np.cos(2.0 * q), 0.0),
        (lambda q, way: 1.0 + 0.5 * way, 0.2),
        (lambda q, way: np.cos(2.0 * q) + 0.5 * way, 0.25 / (0.25 + 0.5 + np.sin(4.0) / 8.0)),
    ],
)
def test_energy_of_a_remainder_is_parted_by_direction(force_of, odd):
    found = halves_of(held(force_of))
    assert found.odd[0] == pytest.approx(odd, abs=0.05)
    assert found.even[0] == pytest.approx(1.0 - odd, abs=0.05)


def test_what_no_neighbour_shows_may_be_of_either_half():
    """Another value at every place: nothing tells whether it would be the same from the other side."""
    data = held(lambda q, way: np.random.default_rng(6).standard_normal(q.shape))
    found = halves_of(data)
    assert min(found.odd[0], found.even[0]) > 0.85


def test_without_directions_all_may_be_of_either_half():
    found = halves_of(held(lambda q, way: way, v=False))
    assert (found.odd[0], found.even[0]) == (1.0, 1.0)


def test_friction_is_no_part_of_what_is_the_same_both_ways():
    friction, cable = (halves_of(held(own, noise=0.0), 0.0) for own in (lambda q, way: way, lambda q, way: q**2))
    both = halves_of(held(lambda q, way: (1.0 + 0.5 * np.sign(way)) * q, noise=0.0), 0.0)
    rest = halves_of(held(lambda q, way: np.cos(3.0 * q) + 0.3 * way))
    assert rest.shared_with(friction)[0] == pytest.approx(rest.odd[0], abs=0.05)
    assert rest.shared_with(cable)[0] == pytest.approx(rest.even[0], abs=0.05)
    assert rest.shared_with(both)[0] > rest.even[0] + 0.3 * rest.odd[0]


def test_samples_of_a_motion_are_no_neighbours_of_those_beside_them_in_time():
    """Noise that lasts some samples is in no product: nothing beyond it is left, and nothing is told."""
    t = 0.05 * np.arange(2000)
    q, v = np.sin(0.4 * t)[:, None], 0.4 * np.cos(0.4 * t)[:, None]
    white = np.random.default_rng(7).standard_normal(2040)
    force = np.convolve(white, np.ones(41) / np.sqrt(41), "valid")[:, None]
    data = Measurement("motion", t, q, v, force, 0.0 * force, "Nm", ("rad",))
    found = halves_of(data, noise=0.1)
    assert min(found.odd[0], found.even[0]) > 0.75
