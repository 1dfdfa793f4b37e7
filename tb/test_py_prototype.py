"""The physics engine's closed chain agrees with the statics that it knows nothing of."""

import dataclasses

import numpy as np
import pytest

from gravcomp.errors import InputError
from gravcomp.prototype.body import Prototype
from gravcomp.robot.spheiro.kinematics import (
    HOME_AXES,
    PoseError,
    inverse_kinematics,
    passive_coordinates,
    passive_jacobian,
)
from gravcomp.robot.spheiro.reactions import slide_reactions
from gravcomp.robot.spheiro.statics import holding_forces
from gravcomp.robot.spheiro.workspace import sample_workspace
from machines import P

POSES = sample_workspace(20, P, seed=20)


@pytest.fixture(scope="module")
def robot():
    return Prototype(P)


def test_chain_closes_at_every_pose(robot):
    for rotation in POSES:
        robot.set_pose(rotation)
        assert robot.closure_error() < 1e-14
        np.testing.assert_allclose(robot.motor_positions(), inverse_kinematics(rotation, P), atol=1e-15)


def test_chain_has_three_degrees_of_freedom(robot):
    robot.set_pose(POSES[0])
    assert robot.model.nv == 21
    assert np.linalg.matrix_rank(robot.data.efc_J.reshape(-1, 21)) == 18


def test_servo_holds_20_poses_with_the_forces_of_the_statics(robot):
    held = np.array([robot.holding_forces_servo(rotation) for rotation in POSES])
    worst_n = np.abs(held - holding_forces(POSES, P)).max()
    print(f"engine held by a servo, 20 poses: worst difference {worst_n * 1e3:.2f} mN")
    assert worst_n < 0.02


def test_slides_bear_what_the_engine_says(robot):
    """The force inside link 2 of each leg, held by a servo, across the slide."""
    for rotation in POSES[:2]:
        robot.holding_forces_servo(rotation)
        robot.mujoco.mj_rnePostConstraint(robot.model, robot.data)
        borne = []
        for n, u in enumerate(HOME_AXES.T, start=1):
            body = robot.model.body(f"link2_{n}").id
            force, along = robot.data.cfrc_int[body][3:], robot.data.xmat[body].reshape(3, 3) @ u
            borne.append(np.linalg.norm(force - (force @ along) * along))
        np.testing.assert_allclose(slide_reactions(rotation, P), borne, rtol=1e-4)


def test_engines_weights_and_constraints_give_the_forces_of_the_statics(robot):
    poses = sample_workspace(200, P, seed=21)
    solved = np.array([robot.holding_forces_algebra(rotation) for rotation in poses])
    worst_n = np.abs(solved - holding_forces(poses, P)).max()
    print(f"engine's equilibrium solved, 200 poses: worst difference {worst_n * 1e3:.4f} mN")
    assert worst_n < 1e-3


def test_velocity_of_the_motors_moves_the_whole_chain(robot):
    velocity = np.array([0.01, -0.02, 0.005])
    robot.set_pose(POSES[0], velocity)
    passive = [*robot.data.qvel[robot.dofs("slide")], *robot.data.qvel[robot.dofs("turn")]]
    np.testing.assert_allclose(robot.data.qvel[robot.motor_dofs], velocity, atol=1e-15)
    np.testing.assert_allclose(passive, passive_jacobian(POSES[0], P) @ velocity, atol=1e-12)


def test_equilibrium_counts_springs_dampers_and_the_friction_of_moving_joints():
    robot, velocity, friction_n = Prototype(P), np.array([0.01, -0.02, 0.005]), 2.0
    robot.model.jnt_stiffness[robot.dofs("slide")] = 50.0
    robot.model.dof_damping[robot.motor_dofs] = 100.0
    robot.model.dof_frictionloss[robot.dofs("slide")] = friction_n
    robot.set_pose(POSES[0], velocity)
    j = passive_jacobian(POSES[0], P)[:3]
    stretch = passive_coordinates(POSES[0], P)[:3] - P.d_m
    expected = holding_forces(POSES[0], P) + 100.0 * velocity
    expected += j.T @ (50.0 * stretch + friction_n * np.sign(j @ velocity))
    np.testing.assert_allclose(robot.equilibrium_efforts(), expected, atol=2e-3)


def test_prototype_follows_its_parameters():
    p = dataclasses.replace(P, d_m=0.3, link1_com_m=0.02, platform_com_m=np.array([0.05, -0.02, 0.01]))
    other = Prototype(p)
    for rotation in POSES[:3]:
        np.testing.assert_allclose(other.holding_forces_algebra(rotation), holding_forces(rotation, p), atol=1e-3)


def test_engine_moves_the_passive_joints_as_the_kinematics_say(robot):
    robot.set_pose(POSES[0])
    target = inverse_kinematics(POSES[1], P)
    start = robot.motor_positions().copy()
    for k in range(3000):
        wanted = start + (target - start) * min(k / 2000, 1.0)
        robot.data.ctrl[:] = holding_forces(POSES[0], P) + 2e4 * (wanted - robot.motor_positions())
        robot.data.ctrl[:] -= 1.2e3 * robot.data.qvel[robot.motor_dofs]
        robot.mujoco.mj_step(robot.model, robot.data)
    quaternion = robot.data.joint("platform").qpos[3:]
    rotation = np.empty(9)
    robot.mujoco.mju_quat2Mat(rotation, quaternion)
    rotation = rotation.reshape(3, 3)
    np.testing.assert_allclose(inverse_kinematics(rotation, P), robot.motor_positions(), atol=1e-5)
    found = [*(robot.data.qpos[robot.dofs("slide")] + P.d_m), *robot.data.qpos[robot.dofs("turn")]]
    np.testing.assert_allclose(found, passive_coordinates(rotation, P), atol=1e-4)
    assert np.abs(robot.data.joint("platform").qpos[:3]).max() < 1e-4  # it only turns about O


def test_pose_out_of_reach_and_robot_not_at_rest_are_refused(robot):
    with pytest.raises(PoseError, match="is not a rotation"):
        robot.set_pose(2 * np.eye(3))
    with pytest.raises(InputError, match=r"isn't at rest after 0\.02 s"):
        robot.holding_forces_servo(POSES[0], settle_s=0.02)
