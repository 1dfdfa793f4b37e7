"""The workspace sampler: seeded, within its ranges, denser near home."""

import numpy as np
import pytest

from gravcomp.robot.spheiro.workspace import CENTRE, pose, sample_workspace
from machines import P


def tilt_deg(rotation):
    return np.rad2deg(np.arccos(np.clip(CENTRE @ rotation @ CENTRE, -1.0, 1.0)))


def torsion_deg(rotation):
    """The quaternion of Rot(tilt) Rot(gamma about n) has cos(tilt/2) sin(gamma/2) along n, cos cos as real part."""
    along = np.stack([rotation[..., j, i] - rotation[..., i, j] for i, j in ((1, 2), (2, 0), (0, 1))], -1) @ CENTRE
    return np.rad2deg(2 * np.arctan2(along, 1 + np.trace(rotation, axis1=-2, axis2=-1)))


def test_same_seed_gives_the_same_poses_and_another_seed_others():
    np.testing.assert_array_equal(sample_workspace(50, P, seed=7), sample_workspace(50, P, seed=7))
    assert np.abs(sample_workspace(50, P, seed=7) - sample_workspace(50, P, seed=8)).max() > 0.1


def test_tilt_and_torsion_fill_their_ranges_uniformly():
    rotation = sample_workspace(20_000, P, seed=1)
    tilt, torsion = tilt_deg(rotation), torsion_deg(rotation)
    assert tilt.max() <= P.tilt_max_deg + 1e-6
    assert np.abs(torsion).max() <= P.torsion_max_deg + 1e-6
    np.testing.assert_allclose(np.histogram(tilt, 7, (0, 35))[0] / len(tilt), 1 / 7, atol=0.01)
    np.testing.assert_allclose(np.histogram(torsion, 8, (-20, 20))[0] / len(torsion), 1 / 8, atol=0.01)


def test_poses_are_denser_near_home():
    tilt = np.deg2rad(tilt_deg(sample_workspace(20_000, P, seed=2)))
    counts, edges = np.histogram(tilt, 7, (0, np.deg2rad(35)))
    density = counts / (np.cos(edges[:-1]) - np.cos(edges[1:]))
    assert (np.diff(density) < 0).all()
    assert density[0] > 5 * density[-1]


def test_azimuth_turns_the_tilt_all_around():
    tipped = sample_workspace(20_000, P, seed=3) @ CENTRE
    assert np.linalg.norm(tipped.mean(axis=0) - (tipped @ CENTRE).mean() * CENTRE) < 0.01


def test_torsion_and_smaller_cone_can_be_asked_for():
    rotation = sample_workspace(500, P, seed=4, torsion_deg=15.0, tilt_max_deg=10.0)
    np.testing.assert_allclose(torsion_deg(rotation), 15.0, atol=1e-9)
    assert tilt_deg(rotation).max() <= 10.0


@pytest.mark.parametrize("torsion", [0.0, 0.2])
def test_pose_broadcasts_and_has_home_at_zero_tilt(torsion):
    grid = pose(np.linspace(0, 6, 5)[:, None], np.linspace(0, 0.6, 4), torsion)
    assert grid.shape == (5, 4, 3, 3)
    np.testing.assert_allclose(grid[:, 0], np.broadcast_to(pose(0.0, 0.0, torsion), (5, 3, 3)), atol=1e-15)
    np.testing.assert_allclose(grid[2, 3], pose(3.0, 0.6, torsion), atol=1e-15)
