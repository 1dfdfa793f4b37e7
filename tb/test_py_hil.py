"""The other side of the RTL in the loop, without the RTL: brakes, a network that says nothing, runs and their logs."""

from dataclasses import replace

import numpy as np
import pytest

from gravcomp.prototype.engine import TIME_STEP_S
from gravcomp.prototype.plant import Plant
from gravcomp.robot.spheiro.kinematics import direct_kinematics
from gravcomp.robot.spheiro.statics import holding_forces_at
from gravcomp.twin.network import core
from gravcomp_lab.hil.loop import silent_network
from gravcomp_lab.hil.plant import BRAKE_N, FrictionBrakes
from gravcomp_lab.hil.runs import FULL, SHORT, Log, stop_after
from gravcomp_lab.shipped import SPHEIRO, shipped_machine
from machines import P

START_M = FULL[0].target_m(0.0, shipped_machine())
NO_FORCE, ENGAGED, RELEASED = np.zeros(3), np.zeros(3, bool), np.ones(3, bool)


@pytest.fixture
def plant() -> Plant:
    plant = Plant(shipped_machine())
    plant.place(START_M, NO_FORCE, 0.0)
    return plant


def fallen_m(plant: Plant, is_released: np.ndarray, steps: int, force_n: np.ndarray = NO_FORCE) -> np.ndarray:
    """How far each axis goes in so many steps."""
    robot, brakes, before = plant.engine, FrictionBrakes(3), plant.engine.motor_positions().copy()
    for _ in range(steps):
        robot.model.dof_frictionloss[robot.motor_dofs] = brakes.friction_n(is_released)
        plant.exert(force_n)
    return np.abs(robot.motor_positions() - before)


def test_brakes_hold_the_robot_that_falls_without_them(plant):
    assert fallen_m(plant, ENGAGED, 100).max() < 1e-7
    assert fallen_m(plant, RELEASED, 30).max() > 1e-3


def test_brakes_of_single_axes_leave_the_others_free(plant):
    moved = fallen_m(plant, np.array([True, False, False]), 20)
    assert moved[0] > 1e-4
    assert moved[1:].max() < 1e-6


def test_brakes_slip_when_the_motors_are_stronger(plant):
    assert fallen_m(plant, ENGAGED, 50, np.full(3, 0.7 * BRAKE_N)).max() < 1e-6
    assert fallen_m(plant, ENGAGED, 50, np.full(3, 1.5 * BRAKE_N)).max() > 1e-3


@pytest.mark.parametrize("closing_steps", [0, 10])
def test_brakes_close_after_their_time_and_open_at_once(closing_steps):
    brakes = FrictionBrakes(3, closing_steps * TIME_STEP_S)
    assert (brakes.friction_n(ENGAGED) == BRAKE_N).all(), "engaged for long"
    assert not brakes.friction_n(RELEASED).any()
    closing = [brakes.friction_n(ENGAGED) for _ in range(closing_steps + 2)]
    assert not np.any(closing[:closing_steps])
    assert (closing[closing_steps] == BRAKE_N).all()


def test_holding_forces_hold_the_robot_without_brakes(plant):
    assert fallen_m(plant, RELEASED, 50, holding_forces_at(START_M, P)).max() < 1e-6


def test_silent_network_asks_for_no_force_at_any_pose():
    counts = shipped_machine().drive.counts(shipped_machine().robot.workspace(2000, 5))
    assert not core(counts, silent_network(SPHEIRO)).force_mn.any()


@pytest.mark.parametrize("run", [*FULL, *SHORT], ids=lambda run: f"{run.name}-{run.duration_s}s")
def test_targets_move_smoothly_inside_the_workspace(run):
    t_s = np.arange(round(run.duration_s / TIME_STEP_S)) * TIME_STEP_S
    target_m = np.array([run.target_m(t, shipped_machine()) for t in t_s])
    assert np.abs(np.diff(target_m, axis=0)).max() <= 13e-6, "faster than the servo's limits"
    assert np.abs(np.diff(target_m, 2, axis=0)).max() < 0.3e-6
    assert not np.ptp(target_m[t_s <= run.hold_s], axis=0).any()
    for q_m in target_m[::50]:
        direct_kinematics(q_m, P)


def test_phases_share_out_all_samples():
    t_s = np.arange(0.0, 2.3, TIME_STEP_S)
    phases = FULL[0].phases(t_s)
    np.testing.assert_array_equal(sum(mask.astype(int) for mask in phases.values()), 1)
    for time_s, wanted in (
        (0.49, "holding"),
        (0.6, "stepping"),
        (0.89, "stepping"),
        (0.95, "holding after steps"),
        (1.45, "holding after steps"),
        (2.0, "moving slowly"),
    ):
        assert [name for name, mask in phases.items() if mask[round(time_s / TIME_STEP_S)]] == [wanted]


def log_with(speeds_radps: np.ndarray, path_m: np.ndarray) -> Log:
    n = len(speeds_radps)
    axes = np.zeros((n, 3))
    q_m = np.stack([path_m, 0 * path_m, -path_m / 2], axis=1)
    return Log(np.arange(n) * TIME_STEP_S, axes, q_m, axes, axes, np.ones(n, bool), speeds_radps, 3)


def test_stop_is_when_the_platform_is_still_for_good():
    run = replace(FULL[2], fault_s=10 * TIME_STEP_S)
    speeds = np.full(40, 0.02)
    speeds[13:15] = 0.0
    speeds[20:] = 1e-5
    stop = stop_after(run, log_with(speeds, np.minimum(np.arange(40), 20) * 1e-6))
    assert stop.still_s == pytest.approx(10 * TIME_STEP_S)
    assert stop.drop_m == pytest.approx(10e-6)
    assert (stop.speed, stop.last_speed) == (0.02, 1e-5)


def test_stop_never_comes_while_the_platform_moves():
    run = replace(FULL[2], fault_s=10 * TIME_STEP_S)
    assert stop_after(run, log_with(np.full(40, 0.02), np.arange(40) * 1e-6)).still_s == np.inf
