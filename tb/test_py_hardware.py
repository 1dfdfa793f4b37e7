"""Where effects go: constants that make the compensator's model the effect itself, a network that learns the rest."""

from dataclasses import replace

import numpy as np
import pytest

from arm import arm_toml
from codes import ROOT
from gravcomp.diagnosis.effects import NAMES, effect_named
from gravcomp.diagnosis.model import Model
from gravcomp.errors import InputError
from gravcomp.logs.measurement import Measurement
from gravcomp.loop.placement import compensation_from_effects
from gravcomp.loop.retraining import augmented_set
from gravcomp.network.weights import load_network
from gravcomp.robot.machine import parse_machine
from gravcomp.training.fine_tuning import retrained
from machines import MACHINE

THREE = (1, 2, 3)


def values(stem: str, *numbers: float) -> dict[str, float]:
    return {f"{stem}_{axis}": number for axis, number in zip(THREE, numbers, strict=True)}


DIRECT = {
    "coulomb_friction": values("fc", 1.0, 2.0, 0.5),
    "coulomb_friction by direction": values("fc_pos", 1.0, 2.0, 0.5) | values("fc_neg", 0.7, 2.5, -0.1),
    "coulomb_friction of one axis": {"fc_2": 1.0},
    "viscous_friction": values("b", 100.0, 300.0, 50.0),
    "viscous_friction by direction": values("b_pos", 100.0, 300.0, 50.0) | values("b_neg", 80.0, 310.0, 40.0),
    "stribeck_friction": values("fc", 1.0, 2.0, 0.5) | values("fs", 3.0, 2.5, 1.0) | values("vs", 2e-3, 3e-3, 1e-3),
    "load_dependent_friction": values("mu", 0.02, 0.05, 0.01),
    "cogging": {"pitch": 0.03, "amplitude_1_h1": 2.0, "phase_1_h1": 0.3, "amplitude_3_h4": 0.5, "phase_3_h4": -2.0},
}


@pytest.fixture(scope="module")
def data() -> Measurement:
    rng = np.random.default_rng(6)
    q = rng.uniform(-0.08, 0.08, (300, 3))
    v = rng.uniform(1.1e-4, 1e-2, q.shape) * rng.choice([-1, 1], q.shape)
    f = MACHINE.robot.forces(q)
    robot = MACHINE.robot
    return Measurement("test", np.arange(300.0), q, v, f, f, "N", ("m",) * 3, force_at=robot.forces, robot=robot)


@pytest.mark.parametrize("case", DIRECT)
def test_compensator_gives_the_effect_itself(case, data):
    name, params = case.split()[0], DIRECT[case]
    placed = compensation_from_effects([{"name": name, "params": params}], data, MACHINE.drive)
    assert (placed.in_compensator, placed.in_network, placed.nowhere) == ([name], [], [])
    given_n = placed.compensation.corrections(data.q, data.v, data.nominal)
    np.testing.assert_allclose(given_n, Model(effects=[(name, params)]).predict(data), atol=1e-9)


def test_friction_of_several_effects_adds_up(data):
    effects = [{"name": case.split()[0], "params": DIRECT[case]} for case in DIRECT]
    placed = compensation_from_effects(effects, data, MACHINE.drive)
    given_n = placed.compensation.corrections(data.q, data.v, data.nominal)
    wanted_n = Model(effects=[(e["name"], e["params"]) for e in effects]).predict(data)
    np.testing.assert_allclose(given_n, wanted_n, atol=1e-9)
    with pytest.raises(InputError, match="two of them give pitch"):
        compensation_from_effects(effects + effects[-1:], data, MACHINE.drive)


def test_passive_friction_becomes_the_nearest_friction_of_the_axes(data):
    name, params = "passive_joint_friction", {"fc_prismatic_n": 2.0, "fc_rotary_nm": 0.0}
    placed = compensation_from_effects([{"name": name, "params": params}], data, MACHINE.drive)
    true_n = Model(effects=[(name, params)]).predict(data)
    rest = true_n - placed.compensation.corrections(data.q, data.v, data.nominal)
    assert np.mean(rest**2) < 0.6 * np.mean(true_n**2)
    np.testing.assert_allclose(np.mean(rest * np.sign(data.v), axis=0), 0.0, atol=1e-9)


def test_every_effect_has_one_place(data):
    in_compensator = {name for name in NAMES if effect_named(name).hardware == "compensator"}
    assert {case.split()[0] for case in DIRECT} < in_compensator
    for name in set(NAMES) - in_compensator:
        placed = compensation_from_effects([{"name": name, "params": {}}], data, MACHINE.drive)
        assert (placed.in_network or placed.nowhere) == [name]
        assert placed.in_network == [name] * (effect_named(name).hardware == "network")
        assert not placed.compensation.corrections(data.q, data.v, data.nominal).any()


def test_friction_is_whole_at_all_but_the_slowest_speeds(data):
    slow = replace(data, v=np.where(np.arange(300)[:, None] < 30, 1e-6, 5e-5) * np.sign(data.v))
    friction = [{"name": "coulomb_friction", "params": DIRECT["coulomb_friction"]}]
    for case, full in ((data, 1e-4), (slow, 2e-5)):
        constants = compensation_from_effects(friction, case, MACHINE.drive).compensation
        np.testing.assert_allclose(constants.v_full, full)
        np.testing.assert_allclose(constants.v_dead, full / 2)
        np.testing.assert_allclose(constants.v_max, np.abs(case.v).max(axis=0))


def test_friction_of_a_joint_is_whole_from_as_many_counts_per_second_on():
    """Whatever its unit; an axis that stands has the limits alone."""
    arm = parse_machine(arm_toml(2, "4096"), "arm")
    rng = np.random.default_rng(2)
    q = rng.uniform(-1, 1, (300, 2))
    v = np.stack([rng.uniform(0.3, 2.0, 300) * rng.choice([-1, 1], 300), np.zeros(300)], axis=1)
    f = arm.robot.forces(q)
    data = Measurement("arm", np.arange(300.0), q, v, f, f, "Nm", ("rad",) * 2, force_at=arm.robot.forces)
    friction = [{"name": "coulomb_friction", "params": {"fc_1": 1.0, "fc_2": 1.0}}]
    constants = compensation_from_effects(friction, data, arm.drive).compensation
    hundred_counts_per_s = 100 * 2 * np.pi / 4096
    np.testing.assert_allclose(constants.v_full, hundred_counts_per_s)
    np.testing.assert_allclose(constants.v_max, [np.abs(v[:, 0]).max(), hundred_counts_per_s])


def test_harmonic_that_the_table_cannot_hold_is_refused(data):
    params = {"pitch": 0.05, "amplitude_1_h33": 1.0, "phase_1_h33": 0.0}
    with pytest.raises(InputError, match="harmonic 33 is above 32"):
        compensation_from_effects([{"name": "cogging", "params": params}], data, MACHINE.drive)


def test_network_learns_a_payload_and_a_spring():
    """From 3 N RMS to what the network reaches on the plain statics, 0.1 N, on poses that it was not trained on."""
    moment = {f"moment_{axis}": m for axis, m in zip("xyz", (0.1, -0.05, 0.08), strict=True)}
    spring = values("k", 30, 20, 40) | values("q0", 0, 0.01, 0)
    lacking = Model(MACHINE, effects=[("payload", moment), ("cable_spring", spring)])
    network = load_network(ROOT / "weights" / "spheiro")
    unseen = augmented_set(lacking, 2)
    after, _ = retrained(network, augmented_set(lacking, 1), MACHINE.drive)
    rms_n = [float(np.sqrt(np.mean((net.forces(unseen.q) - unseen.f) ** 2))) for net in (network, after)]
    print(f"MEASURED {rms_n[0]:.3f} N before, {rms_n[1]:.3f} N after")
    assert rms_n[0] > 1.0
    assert rms_n[1] < 0.13
