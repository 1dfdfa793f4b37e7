"""Axes that change no effort: found, and left alone by the network."""

import numpy as np
import pytest

from gravcomp.robot.machine import load_machine
from gravcomp.training.felt_axes import felt_axes
from gravcomp.training.training import Effort, poses_of_size, train, workspace_set
from machines import MACHINE
from mechanisms import WEIGHTS, body, mechanism, mjcf

SHORT = Effort(draws=2, tied_hops=1, hops=1, search_poses=100)
# A turntable, a lever on it, and a wheel balanced about its own axis, which is level.
ARM = mjcf(
    body("a", 'name="turn" axis="0 0 1" range="-1 1"', 4.0, "0.2 0 0", inside=body(
        "b", 'name="lift" axis="0 -1 0" range="-1 2"', 2.5, "0.15 0 0", inside=body(
            "c", 'name="wheel" axis="0 1 0" range="-1 1"', 1.0, "0 0 0", "0.3 0 0"
        )
    ))
)  # fmt: skip


def arm(folder, turn=""):
    return mechanism(folder, ARM, {"turn": turn, "lift": "", "wheel": ""})


def test_axes_that_change_no_effort_are_found(tmp_path):
    assert felt_axes(arm(tmp_path).robot).tolist() == [False, True, False]


def test_all_axes_count_where_other_poses_cannot_be_told_or_nothing_changes(tmp_path):
    assert felt_axes(MACHINE.robot).all()
    lift = mjcf(body("a", 'name="j" type="slide" axis="0 0 1" range="0 1"', 1.0))
    assert felt_axes(mechanism(tmp_path, lift, {"j": "counts_per_m = 1000"}).robot).tolist() == [True]


def test_axes_of_the_ur5_that_matter_are_those_of_its_shoulder_elbow_and_first_wrist():
    """The base is level, and what its last two links weigh sits on the axes of the wrists."""
    assert felt_axes(load_machine(WEIGHTS / "ur5").robot).tolist() == [False, True, True, True, False, False]


@pytest.mark.parametrize("turn", ["", 'input = "sin_cos"'])
def test_network_has_no_weights_on_an_axis_that_changes_nothing(turn, tmp_path):
    machine = arm(tmp_path, turn)
    data = workspace_set(200, machine.robot, 1)
    network, _ = train(data, machine, n_hidden=5, n_starts=1, backend="threading", effort=SHORT)
    n_turn = 2 if turn else 1
    assert not network.hidden_weights[:, :n_turn].any()
    assert not network.hidden_weights[:, -1].any()
    assert network.hidden_weights[:, n_turn].any()
    error = network.forces(data.q) - data.f
    assert np.sqrt(np.mean(error**2)) < 0.01 * np.sqrt(np.mean(data.f**2))


def test_a_large_network_gets_poses_in_proportion_to_its_parameters():
    assert poses_of_size(20, 3, 3) == 3500
    assert poses_of_size(128, 6, 7) >= 4 * (128 * 7 + 7 * 129)
