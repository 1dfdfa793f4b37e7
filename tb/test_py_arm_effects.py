"""Effects of real arms: moments of bodies, cables that stiffen, time that a position tells; the arm of a public log."""

from dataclasses import replace

import numpy as np
import pytest

from gravcomp.diagnosis.diagnosis import diagnose
from gravcomp.diagnosis.effects import effect_named
from gravcomp.diagnosis.model import Model
from gravcomp.logs.csv_reader import read_measurement
from gravcomp.logs.measurement import Measurement
from gravcomp.loop.placement import compensation_from_effects
from gravcomp.robot.machine import load_machine
from mechanisms import WEIGHTS
from support.published import published

NOISE_NM = 0.05
# Of the arm's users: alpha deg, a m, d m, theta offset deg, mass kg, centre of mass m in the link's frame.
DH = [
    (90, 0, 0, -90, 0, (0, 0, 0)),
    (0, 0.2794, 0, -90, 0.65, (-0.38, 0, 0)),
    (-90, 0.3645, 0, 90, 0.04, (-0.25, 0, 0)),
    (90, 0, 0.1506, 0, 0.14, (0, -0.084, -0.12)),
    (-90, 0, 0, 0, 0.04, (0, 0.036, -0.065)),
    (90, 0, 0, -90, 0.05, (0, -0.025, 0.05)),
]


def energy(q) -> float:
    """Potential of the arm by its Denavit-Hartenberg steps, J; joint 1 is vertical."""
    frame, total = np.eye(4), 0.0
    for angle, (alpha, a, d, offset, mass, centre) in zip(q, DH, strict=True):
        c, s = np.cos(angle + np.deg2rad(offset)), np.sin(angle + np.deg2rad(offset))
        ca, sa = np.cos(np.deg2rad(alpha)), np.sin(np.deg2rad(alpha))
        frame = frame @ np.array(
            [[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1]]
        )
        total += 9.81 * mass * (frame @ [*centre, 1.0])[2]
    return total


def test_master_arm_is_its_table_of_frames_and_masses():
    robot = load_machine(WEIGHTS / "dvrk_mtm").robot
    step = 1e-6 * np.eye(6)
    for q in robot.workspace(20, 3):
        gradient = [(energy(q + e) - energy(q - e)) / 2e-6 for e in step]
        np.testing.assert_allclose(robot.forces(q[None])[0], gradient, atol=1e-8)


def test_crank_of_the_parallelogram_loads_the_elbow_alone():
    robot = load_machine(WEIGHTS / "dvrk_mtm").robot
    q = robot.workspace(20, 4)
    moved = robot.moment_regressors(q)[:, :, robot.body_names.index("crank"), :]
    np.testing.assert_allclose(moved[:, 2, 0], 9.81 * np.cos(q[:, 2]), atol=1e-9)
    np.testing.assert_allclose(moved[:, 2, 1], -9.81 * np.sin(q[:, 2]), atol=1e-9)
    assert np.abs(np.delete(moved, 2, axis=1)).max() < 1e-12


def test_public_log_of_the_master_arm_has_its_model():
    data = read_measurement(published("dvrk_mtm/holds.csv"))
    robot = load_machine(WEIGHTS / "dvrk_mtm").robot
    np.testing.assert_allclose(robot.forces(data.q), data.nominal, atol=1e-5)  # the log has six digits
    assert data.axis_as_time == 1  # joint 2 was taken through its places once up and once down
    assert effect_named("thermal_drift").unavailable(data)
    assert effect_named("friction_step").unavailable(data)


def arm2(force, n=300, seed=2) -> Measurement:
    """Scattered holds of the arm of two links with an extra force(q, v), approached from either side."""
    robot = load_machine(WEIGHTS / "arm2").robot
    rng = np.random.default_rng(seed)
    q, v = robot.workspace(n, seed), rng.choice([-0.1, 0.1], (n, 2))
    f = robot.forces(q)
    measured = f + force(q, v, robot) + NOISE_NM * rng.standard_normal(q.shape)
    return Measurement("arm2", 2.0 * np.arange(n), q, v, measured, f, "Nm", ("rad",) * 2, None, robot.forces, robot)


def named(data: Measurement) -> set[str]:
    return {entry.name for entry in diagnose(data, Model(), 0).fit.effects}


def counterweight(q, v, robot):
    return -0.3 * robot.moment_regressors(q)[:, :, robot.body_names.index("upper_arm"), 0]


def stiff_cable(q, v):
    """On the elbow alone, one way harder than the other."""
    x = q[:, 1] / 2.0
    bent = 0.4 * x - 0.5 * x**2 + 0.6 * x**3 + 0.7 * x**4
    return np.column_stack([0 * x, bent * (1.0 + 0.4 * np.sign(v[:, 1]))])


def test_counterweight_is_a_moment_on_its_body():
    found = diagnose(arm2(counterweight), Model(), 0)
    (entry,) = found.fit.effects
    assert entry.name == "body_moment"
    low, high = entry.intervals["moment_upper_arm_x"]
    assert low < -0.3 < high
    assert high - low < 0.05
    assert found.verdict == "explained"


def test_tool_of_unknown_weight_is_a_payload_with_its_mass():
    """0.6 kg at (0.1, 0, 0.05) m of the tool, 0.3 m behind the elbow, which is 0.4 m behind the shoulder."""

    def tool(q, v, robot):
        q1, q2 = q.T
        elbow = 0.4 * np.cos(q1 + q2) - 0.05 * np.sin(q1 + q2)
        return 9.81 * 0.6 * np.stack([0.4 * np.cos(q1) + elbow, elbow], axis=1)

    (entry,) = diagnose(arm2(tool), Model(), 0).fit.effects
    assert entry.name == "payload"
    assert entry.parameters["mass"] == pytest.approx(0.6, rel=0.02)
    assert entry.parameters["moment_x"] == pytest.approx(0.06, abs=0.01)


def test_cable_on_one_joint_is_named_there_beside_friction_of_both():
    data = arm2(lambda q, v, robot: stiff_cable(q, v) + 0.2 * np.sign(v))
    found = diagnose(data, Model(), 0)
    by_name = {entry.name: entry for entry in found.fit.effects}
    assert by_name.keys() == {"nonlinear_cable_spring", "coulomb_friction"}
    assert {name.axis for name in by_name["nonlinear_cable_spring"].parameters} == {1}
    after = found.after[found.is_test]
    assert np.sqrt(np.mean(after**2)) < 1.15 * NOISE_NM


def test_what_of_a_cable_goes_with_the_direction_is_friction_in_hardware():
    data = arm2(lambda q, v, robot: 0.0 * q)
    effects = [{"name": "nonlinear_cable_spring", "params": {"k1_2": 0.3, "h0_2": 0.1, "h2_2": 0.05}}]
    placed = compensation_from_effects(effects, data, load_machine(WEIGHTS / "arm2").drive)
    mean = 0.1 + 0.05 * np.mean(data.q[:, 1] ** 2)
    np.testing.assert_allclose(placed.compensation.fc_pos, [0.0, mean])
    np.testing.assert_allclose(placed.compensation.fc_neg, [0.0, mean])
    assert placed.in_network == ["nonlinear_cable_spring"]


@pytest.mark.parametrize("in_order", [True, False])
def test_drift_is_not_looked_for_where_time_follows_a_position(in_order):
    """Holds at places of two joints: the first goes through its places once up and once down, or at random."""
    first, second = (x.ravel() for x in np.meshgrid(np.linspace(0, 1, 6), np.linspace(-1, 1, 25), indexing="ij"))
    q = np.concatenate([np.c_[first, second], np.c_[first, second][::-1]])
    v = np.repeat([[0.1, 0.1], [-0.1, -0.1]], len(first), axis=0)
    order = np.arange(len(q)) if in_order else np.random.default_rng(1).permutation(len(q))
    f = 5.0 * np.cos(q)
    data = Measurement("raster", np.arange(float(len(q))), q[order], v[order], f[order], f[order], "Nm", ("rad",) * 2)
    assert data.axis_as_time == (0 if in_order else None)
    assert bool(effect_named("thermal_drift").unavailable(data)) == in_order
    warmer = replace(data, temp_c=np.linspace(20.0, 30.0, len(q)))
    assert effect_named("thermal_drift").unavailable(warmer) == ""  # the temperature is told


def test_bending_by_a_tenth_of_the_range_is_no_compliance():
    data = arm2(lambda q, v, robot: 0.0 * q)
    limits = effect_named("link_compliance").limits_in(data)
    most = 0.1 * np.ptp(data.q, axis=0) / np.abs(data.nominal).max(axis=0)
    assert list(limits.values()) == pytest.approx(most)


def test_a_linear_axis_feels_no_moment_of_a_body(tmp_path):
    """A slide bears masses alone: where they are on it, no log can show, and none is sought."""
    machine, rng = load_machine(WEIGHTS / "slide"), np.random.default_rng(3)
    q = rng.uniform(0.05, 0.45, (80, 1))
    force = machine.robot.forces(q) + 0.5 * np.sign(q - 0.25) + 0.05 * rng.standard_normal(q.shape)
    rows = np.column_stack([np.arange(80.0), q, 0.01 * np.sign(q - 0.25), force])
    log = tmp_path / "slide.csv"
    np.savetxt(log, rows, delimiter=",", header="t_s,q1_m,v1_mps,f1_n", comments="")
    found = diagnose(read_measurement(log, machine), Model(machine))
    assert "no axis feels" in found.untestable["body_moment"]
    assert found.fit.effects
