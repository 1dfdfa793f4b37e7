"""What a stage for play or for passive joints would gain is measured against formulas."""

from dataclasses import replace

import numpy as np
import pytest

from gravcomp_lab.joint_stages import Motions, by_axis, fitted_jacobian, friction, friction_left, play_error, rms
from machines import MACHINE

pytest.importorskip("mujoco", reason="extra prototype is not installed")


@pytest.fixture(scope="module")
def motions() -> Motions:
    return Motions.draw(MACHINE)


def test_play_errs_by_half_the_gap_times_the_slope_of_the_force(motions):
    gap, step = 1e-5, 1e-7
    at = MACHINE.robot.forces
    slope = [(at(motions.q + step * e) - at(motions.q - step * e)) / (2 * step) for e in np.eye(3)]
    slope = np.stack(slope, axis=-1)
    wanted = -0.5 * gap * np.einsum("nij,nj->ni", slope, np.sign(motions.v))
    assert rms(play_error(MACHINE, motions, gap) - wanted) < 0.02 * rms(wanted)


def test_friction_of_joints_takes_power_out_of_every_motion(motions):
    force = friction(motions.passive, motions.v)
    speed = np.einsum("npk,nk->np", motions.passive, motions.v)
    np.testing.assert_allclose(np.sum(force * motions.v, axis=1), np.abs(speed).sum(axis=1))


def test_nearest_friction_by_axis_leaves_nothing_of_friction_by_axis(motions):
    own = np.array([1.0, 2.0, 0.5]) * np.sign(motions.v)
    np.testing.assert_allclose(by_axis(own, motions.v, motions.is_test), own)


def test_jacobian_that_is_linear_in_the_positions_is_found_and_its_friction_whole(motions):
    linear = np.einsum("pkj,nj->npk", np.random.default_rng(1).standard_normal((6, 3, 3)), motions.q) + 1.0
    own = replace(motions, passive=linear)
    np.testing.assert_allclose(fitted_jacobian(own, 1), linear, atol=1e-9)
    left = friction_left(own, own.is_prismatic)
    assert left["J_p(q) of degree 1"][0] < 1e-6 < left["J_p(q) of degree 0"][0]


def test_products_are_counted(motions):
    """Degree 1: each of 18 entries a product per position, then J v; the signs only choose additions."""
    assert friction_left(motions, motions.is_prismatic)["J_p(q) of degree 1"][1] == 18 * 3 + 18
