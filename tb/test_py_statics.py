"""Statics: hand values, energy gradient, symmetry, the design's figures."""

import dataclasses

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gravcomp.robot.spheiro.kinematics import PoseError, inverse_kinematics, jacobian
from gravcomp.robot.spheiro.reactions import _across
from gravcomp.robot.spheiro.statics import holding_forces, holding_forces_at, potential_energy
from gravcomp.robot.spheiro.workspace import sample_workspace
from machines import P

CYCLE = np.eye(3)[[2, 0, 1]]
STEP_RAD = 1e-6


def test_home_forces_are_the_designs():
    np.testing.assert_allclose(holding_forces(np.eye(3), P), [50.2946] * 3, atol=5e-5)


def test_forces_over_the_workspace_are_the_designs():
    rotation = sample_workspace(20_000, P, seed=0)
    force = holding_forces(rotation, P)
    assert np.abs(force).mean() == pytest.approx(48.1, abs=0.1)
    assert force.min() == pytest.approx(-10.4, abs=0.5)
    assert force.max() == pytest.approx(127.8, abs=1.0)
    assert np.abs(inverse_kinematics(rotation, P)).max() == pytest.approx(0.158, abs=0.001)


def test_carriages_alone_are_carried_by_their_motors():
    massless = {name: 0.0 for name in ("link1_mass_kg", "link2_mass_kg", "platform_mass_kg")}
    p = dataclasses.replace(P, **massless)
    weight = p.carriage_mass_kg * 9.81 / np.sqrt(3)
    np.testing.assert_allclose(holding_forces(sample_workspace(20, p, seed=1), p), weight, rtol=1e-12)


def test_platform_alone_gives_the_moment_of_its_weight():
    p = dataclasses.replace(P, carriage_mass_kg=0.0, link1_mass_kg=0.0, link2_mass_kg=0.0)
    rotation = sample_workspace(20, p, seed=2)
    moment = np.einsum("...ij,...i->...j", jacobian(rotation, p), holding_forces(rotation, p))
    np.testing.assert_allclose(moment, -np.cross(rotation @ p.platform_com_m, p.platform_mass_kg * p.gravity_mps2))


def test_forces_are_the_gradient_of_the_energy():
    rotation = sample_workspace(200, P, seed=3)
    energy = [
        [potential_energy(Rotation.from_rotvec(s * axis).as_matrix() @ rotation, P) for axis in np.eye(3)]
        for s in (STEP_RAD, -STEP_RAD)
    ]
    gradient = np.moveaxis((np.array(energy[0]) - energy[1]) / (2 * STEP_RAD), 0, -1)
    moment = np.einsum("...ij,...i->...j", jacobian(rotation, P), holding_forces(rotation, P))
    np.testing.assert_allclose(moment, gradient, atol=1e-7)


def test_turning_the_pose_by_a_third_permutes_the_forces():
    rotation = sample_workspace(50, P, seed=4)
    force = holding_forces(rotation, P)
    np.testing.assert_allclose(holding_forces(CYCLE @ rotation @ CYCLE.T, P), force[:, [2, 0, 1]], atol=1e-11)


def test_forces_at_joint_positions_are_those_at_the_pose_and_vectorised():
    rotation = sample_workspace(6, P, seed=5)
    force, q = holding_forces(rotation, P), inverse_kinematics(rotation, P)
    np.testing.assert_allclose(holding_forces_at(q.reshape(2, 1, 3, 3), P), force.reshape(2, 1, 3, 3), atol=1e-10)
    np.testing.assert_allclose(np.stack([holding_forces(r, P) for r in rotation]), force, rtol=1e-13)


def test_impossible_poses_are_refused():
    beyond = [[0.0] * 3, [-0.2] * 3]
    with pytest.raises(PoseError, match=r"^pose 1 is at or beyond a singular face"):
        holding_forces_at(beyond, P)
    for function in (holding_forces, potential_energy):
        with pytest.raises(PoseError, match=r"^pose 0 is not a rotation"):
            function(2 * np.eye(3), P)


def test_forces_of_the_legs_on_the_platform_are_those_of_the_motors_less_the_weight_that_they_carry():
    rotation = sample_workspace(50, P, seed=12)
    along = np.einsum("nii->ni", _across(rotation, P)[1])
    carried = (P.carriage_mass_kg + P.link1_mass_kg + P.link2_mass_kg) * P.gravity_mps2
    np.testing.assert_allclose(along - carried, holding_forces(rotation, P), atol=1e-11)
