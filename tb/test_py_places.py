"""Places at which an axis was held, and motions that pass none."""

import numpy as np

from gravcomp.logs.places import places


def test_places_that_the_effort_draws_apart_are_one_each():
    """Ten places 0.1 apart, each approached both ways, off by a thousandth."""
    rng = np.random.default_rng(1)
    at = np.repeat(0.1 * np.arange(10.0), 4)
    found = places(at + rng.uniform(-0.001, 0.001, 40), 1.0)
    assert found.count == 10
    np.testing.assert_allclose(found.centre, at, atol=0.0011)


def test_stretches_of_a_motion_are_no_places():
    """Dense positions with a gap between them: within a stretch the axis moved farther than the gap is wide."""
    rng = np.random.default_rng(2)
    q = np.concatenate([rng.uniform(0.0, 1.0, 400), rng.uniform(1.2, 1.7, 300)])
    assert places(q, 1.0) is None
