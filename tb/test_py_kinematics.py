"""Kinematics: identities between inverse, direct and passive kinematics, Jacobians, and every refused pose."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gravcomp.robot.spheiro.kinematics import (
    HOME_AXES,
    PoseError,
    direct_kinematics,
    inverse_kinematics,
    jacobian,
    passive_coordinates,
    passive_jacobian,
    universal_angles,
    universal_jacobian,
)
from gravcomp.robot.spheiro.workspace import sample_workspace
from machines import P

CYCLE = np.eye(3)[[2, 0, 1]]  # x -> y -> z -> x
STEP_RAD = 1e-6


def turned(rotation, k, step_rad):
    return Rotation.from_rotvec(step_rad * np.eye(3)[k]).as_matrix() @ rotation


def test_home_has_zero_motor_positions_and_passive_joints_at_their_origin():
    np.testing.assert_array_equal(inverse_kinematics(np.eye(3), P), np.zeros(3))
    np.testing.assert_allclose(passive_coordinates(np.eye(3), P), [P.d_m] * 3 + [0.0] * 3, atol=1e-15)


def test_direct_undoes_inverse_kinematics_over_10000_poses():
    rotation = sample_workspace(10_000, P, seed=1)
    assert np.abs(direct_kinematics(inverse_kinematics(rotation, P), P) - rotation).max() < 1e-12


def test_inverse_undoes_direct_kinematics_over_the_whole_tetrahedron():
    barycentric = np.random.default_rng(2).dirichlet(np.ones(4), 10_000)
    barycentric = 0.999 * barycentric + 0.001 / 4
    q = P.d_m * barycentric @ np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    rotation = direct_kinematics(q, P)
    assert np.abs(inverse_kinematics(rotation, P) - q).max() < 1e-12


def test_joint_positions_are_projections_of_the_universal_joints():
    rotation = sample_workspace(50, P, seed=3)
    points = P.d_m * rotation @ HOME_AXES  # columns P_i
    for i in range(3):
        np.testing.assert_allclose(inverse_kinematics(rotation, P)[:, i], points[:, i, i], atol=1e-15)


def test_passive_slides_reach_the_universal_joints():
    rotation = sample_workspace(50, P, seed=4)
    q, passive = inverse_kinematics(rotation, P), passive_coordinates(rotation, P)
    for i, (e, u) in enumerate(zip(np.eye(3), HOME_AXES.T, strict=True)):
        w = Rotation.from_rotvec(passive[:, 3 + i, None] * e).apply(u)
        reached = q[:, i, None] * e + passive[:, i, None] * w
        np.testing.assert_allclose(reached, P.d_m * rotation @ u, atol=1e-14)


def test_turning_the_robot_by_a_third_permutes_the_axes():
    rotation = sample_workspace(50, P, seed=5)
    q = inverse_kinematics(rotation, P)
    np.testing.assert_allclose(inverse_kinematics(CYCLE @ rotation @ CYCLE.T, P), q[:, [2, 0, 1]], atol=1e-15)


def test_jacobian_is_the_derivative_of_inverse_kinematics():
    rotation = sample_workspace(50, P, seed=6)
    ahead, behind = (
        np.stack([inverse_kinematics(turned(rotation, k, s), P) for k in range(3)], -1) for s in (STEP_RAD, -STEP_RAD)
    )
    np.testing.assert_allclose(jacobian(rotation, P), (ahead - behind) / (2 * STEP_RAD), atol=1e-9)


def test_passive_jacobian_is_the_derivative_of_passive_coordinates():
    rotation = sample_workspace(50, P, seed=7)
    ahead, behind = (
        np.stack([passive_coordinates(turned(rotation, k, s), P) for k in range(3)], -1) for s in (STEP_RAD, -STEP_RAD)
    )
    by_rotation = (ahead - behind) / (2 * STEP_RAD)
    np.testing.assert_allclose(passive_jacobian(rotation, P) @ jacobian(rotation, P), by_rotation, atol=1e-8)


def test_hinges_of_the_universal_joints_turn_link_2_into_the_platform():
    """phi about e, inner about e x u, outer about u, in that order, carried along."""
    rotation = sample_workspace(50, P, seed=10)
    phi, hinges = passive_coordinates(rotation, P)[:, 3:], universal_angles(rotation, P)
    assert np.abs(universal_angles(np.eye(3), P)).max() < 1e-15
    for i, (e, u) in enumerate(zip(np.eye(3), HOME_AXES.T, strict=True)):
        turns = ((phi[:, i], e), (hinges[:, i], np.cross(e, u)), (hinges[:, 3 + i], u))
        reached = np.eye(3)
        for angle, axis in turns:
            reached = reached @ Rotation.from_rotvec(angle[:, None] * axis).as_matrix()
        np.testing.assert_allclose(reached, rotation, atol=1e-13)


def test_universal_jacobian_is_the_derivative_of_the_angles():
    q, step = inverse_kinematics(sample_workspace(50, P, seed=11), P), 1e-6 * np.eye(3)
    at = lambda q: universal_angles(direct_kinematics(q, P), P)  # noqa: E731
    by_q = np.stack([(at(q + e) - at(q - e)) / 2e-6 for e in step], -1)
    np.testing.assert_allclose(universal_jacobian(direct_kinematics(q, P), P), by_q, atol=1e-8)


VECTORISED = [inverse_kinematics, jacobian, passive_coordinates, passive_jacobian, universal_angles, universal_jacobian]


@pytest.mark.parametrize("function", VECTORISED)
def test_leading_axes_are_vectorised_over(function):
    rotation = sample_workspace(6, P, seed=8)
    one_by_one = np.stack([function(r, P) for r in rotation])
    np.testing.assert_allclose(
        function(rotation.reshape(2, 3, 3, 3), P), one_by_one.reshape(2, 3, *one_by_one.shape[1:])
    )
    q = inverse_kinematics(rotation, P)
    np.testing.assert_allclose(direct_kinematics(q.reshape(3, 1, 2, 3), P), rotation.reshape(3, 1, 2, 3, 3), atol=1e-12)


def bad_at_3(good, bad):
    poses = np.repeat(np.asarray(good, dtype=float)[None], 6, axis=0)
    poses[3] = bad
    return poses


@pytest.mark.parametrize(
    ("q", "why"),
    [
        ([-P.d_m, 0.0, 0.0], "is at or beyond a singular face"),
        ([-P.d_m / 3] * 3, "is at or beyond a singular face"),
        ([P.d_m] * 3, "is at or beyond a singular face"),
        ([-0.2, -0.2, -0.2], "is at or beyond a singular face"),
        ([10.0, 0.0, 0.0], "is at or beyond a singular face"),
        ([np.nan, 0.0, 0.0], "is not a number"),
        ([0.0, np.inf, 0.0], "is not a number"),
    ],
)
def test_impossible_joint_positions_are_refused_with_pose_and_reason(q, why):
    with pytest.raises(PoseError, match=f"^pose 3 {why}"):
        direct_kinematics(bad_at_3(np.zeros(3), q), P)


@pytest.mark.parametrize(
    ("rotation", "why"),
    [
        (Rotation.from_rotvec([np.pi / 2, 0, 0]).as_matrix(), "is at or beyond a singular face"),
        (Rotation.from_rotvec([np.pi, 0, 0]).as_matrix(), "is at or beyond a singular face"),
        (Rotation.from_rotvec(np.ones(3) * 2.2).as_matrix(), "is at or beyond a singular face"),
        (np.full((3, 3), np.nan), "is not a number"),
        (1.001 * np.eye(3), "is not a rotation"),
        (-np.eye(3), "is not a rotation"),
        (np.zeros((3, 3)), "is not a rotation"),
    ],
)
@pytest.mark.parametrize("function", VECTORISED)
def test_impossible_rotations_are_refused_with_pose_and_reason(function, rotation, why):
    with pytest.raises(PoseError, match=f"^pose 3 {why}"):
        function(bad_at_3(np.eye(3), rotation), P)


def test_further_bad_poses_are_counted_and_wrong_shapes_named():
    with pytest.raises(PoseError, match=r"^pose 1 \(and 2 more\) is not a number"):
        direct_kinematics([[0.0] * 3, [np.nan] * 3, [np.nan] * 3, [np.nan] * 3], P)
    with pytest.raises(PoseError, match=r"shape \(4,\); give \(\.\.\., 3\)"):
        direct_kinematics(np.zeros(4), P)
    with pytest.raises(PoseError, match=r"shape \(3,\); give \(\.\.\., 3, 3\)"):
        inverse_kinematics(np.zeros(3), P)
