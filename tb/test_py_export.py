"""Tables for drives: read back as each drive reads them, they are the compensator's twin at every place and speed."""

import re

import numpy as np
import pytest
import yaml

from compensated import CSV, N_AXES, compensated_weights, constants
from gravcomp import cli
from gravcomp.core.compensator_tables import N_POSITIONS, node_speeds
from gravcomp.export.formats import TF5200_ENTRIES
from gravcomp.robot.machine import load_machine
from gravcomp.twin.compensator import friction, period_of, position_table

# One motor against its axis and off its zero; whole pitches a turn: 2 and 3.
TURNS, ZEROS = (0.01, -0.064, 0.01539), (0.0, 0.011, -0.002)
COGGING = (1, 2)  # axes
ARGUMENTS = ["--turn", *map(str, TURNS), "--zero", *map(str, ZEROS), "--speed", "0.02", "0.05", "0.05"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return compensated_weights(tmp_path_factory.mktemp("machine"))


@pytest.fixture(scope="module")
def twin(folder):
    return (*constants(folder), load_machine(folder))


def exported(folder, out, kind, *arguments):
    assert cli.main(["export", kind, "--weights", str(folder), "--out", str(out), *ARGUMENTS, *arguments]) == 0
    return out


def places(machine, axis):
    """Counts over the axis' range, and turns of its motor there."""
    counts = np.linspace(-150_000, 150_000, 40_001).astype(np.int64)
    q = machine.drive.positions(counts[:, None] * np.ones(N_AXES))[:, axis]
    return counts, (q - ZEROS[axis]) / TURNS[axis]


def cogging_n(fixed, axis, counts):
    return position_table(np.repeat(counts[:, None], N_AXES, axis=1), fixed)[:, axis] / 1e3


def waves(compensation, axis):
    harmonic = np.flatnonzero(compensation.amplitude[axis]) + 1
    return harmonic, np.abs(compensation.amplitude[axis, harmonic - 1])


def twin_bound_n(compensation, axis, machine):
    """Of the twin against the sine: half an LSB of node and sum, the chord, phase steps of 2**-32 turns a count."""
    harmonic, amplitude = waves(compensation, axis)
    chord = (2 * np.pi * harmonic / N_POSITIONS) ** 2 / 8
    step = 2 * np.pi * harmonic * 150_000 * 2.0**-33
    return 1e-3 + np.sum(amplitude * (chord + step))


@pytest.mark.parametrize("axis", COGGING)
def test_moteus_table_read_as_its_firmware_does_is_the_twins(axis, folder, twin, tmp_path):
    compensation, fixed, machine = twin
    text = (exported(folder, tmp_path, "moteus") / f"axis{axis + 1}_moteus.cfg").read_text()
    scale = float(re.search(r"^conf set motor\.cogging_dq_scale (\S+)$", text, re.M)[1])
    codes = np.array([(int(n), int(code)) for n, code in re.findall(r"cogging_dq_comp\.(\d+) (-?\d+)$", text, re.M)])
    assert text.endswith("conf write\n")
    np.testing.assert_array_equal(codes[:, 0], np.arange(1024))
    assert np.abs(codes[:, 1]).max() == 127  # no resolution is given away, and int8 holds it
    counts, theta = places(machine, axis)
    table = np.append(codes[:, 1], codes[0, 1]) * scale
    current_a = np.interp(theta % 1 * 1024, np.arange(1025), table)
    effort_n = np.sign(TURNS[axis]) * machine.axes[axis].effort_per_ampere * current_a
    harmonic, amplitude = waves(compensation, axis)
    order = harmonic * round(abs(TURNS[axis]) / compensation.pitch[axis])
    chord = np.sum(amplitude * (2 * np.pi * order / 1024) ** 2 / 8)
    bound = twin_bound_n(compensation, axis, machine) + chord + scale / 2 * machine.axes[axis].effort_per_ampere
    assert np.abs(effort_n - cogging_n(fixed, axis, counts)).max() <= bound < 0.02 * amplitude.sum()


@pytest.mark.parametrize("axis", COGGING)
def test_odrive_map_read_as_its_firmware_does_is_the_twins(axis, folder, twin, tmp_path):
    compensation, fixed, machine = twin
    path = exported(folder, tmp_path, "odrive") / f"axis{axis + 1}_odrive.csv"
    index, torque_nm = np.loadtxt(path, delimiter=",", skiprows=1, unpack=True)
    np.testing.assert_array_equal(index, np.arange(3600))
    counts, theta = places(machine, axis)
    held_nm = torque_nm[np.trunc(theta * 3600).astype(int) % 3600]
    harmonic, amplitude = waves(compensation, axis)
    order = harmonic * round(abs(TURNS[axis]) / compensation.pitch[axis])
    bound = twin_bound_n(compensation, axis, machine) + np.sum(amplitude * 2 * np.pi * order / 3600)
    effort_n = held_nm * 2 * np.pi / TURNS[axis]
    assert np.abs(effort_n - cogging_n(fixed, axis, counts)).max() <= bound < 0.02 * amplitude.sum()


@pytest.mark.parametrize("axis", COGGING)
def test_beckhoff_coefficients_are_the_twins(axis, folder, twin, tmp_path):
    compensation, fixed, machine = twin
    lines = (exported(folder, tmp_path, "beckhoff") / f"axis{axis + 1}_ax8000.csv").read_text().splitlines()[1:]
    fields = [line.split(",") for line in lines]
    assert [int(f[1], 16) for f in fields] == list(range(7, 7 + len(fields)))
    order, phase_deg, amplitude_nm = np.array([float(f[3]) for f in fields]).reshape(-1, 3).T
    assert ((phase_deg >= 0) & (phase_deg < 360)).all()
    assert (amplitude_nm > 0).all()
    counts, theta = places(machine, axis)
    angle = 2 * np.pi * theta[:, None] * order + np.radians(phase_deg)
    effort_n = np.sum(amplitude_nm * np.sin(angle), axis=1) * 2 * np.pi / TURNS[axis]
    bound = twin_bound_n(compensation, axis, machine)
    assert np.abs(effort_n - cogging_n(fixed, axis, counts)).max() <= bound


def test_beckhoff_friction_is_the_mean_of_the_twins_directions(folder, twin, tmp_path, capsys):
    compensation, fixed, machine = twin
    unit_a = 0.01
    text = (exported(folder, tmp_path, "beckhoff", "--current-unit", str(unit_a)) / "axis1_tf5200.txt").read_text()
    assert (
        "axis 1: the mean of both directions; Coulomb friction differs by 0.3 N either way" in capsys.readouterr().out
    )
    um_per_s, out = (
        np.array(re.findall(rf"frict_comp\.table\[\d+\]\.{name} (\S+)", text), dtype=float) for name in ("in", "out")
    )
    assert len(um_per_s) == TF5200_ENTRIES
    assert (np.diff(um_per_s) > 0).all()
    period = period_of(1e-6 * um_per_s[:, None] * np.ones(N_AXES), machine.drive)[:, 0]
    v = 4 * machine.drive.clock_hz * machine.drive.unit_per_count[0] / period
    at, rest = np.zeros((2, len(v), N_AXES), dtype=np.int64)
    at[:, 0] = period
    up, down = (friction(rest, sign * at, fixed)[:, 0] / 1e3 for sign in (1, -1))
    slope = compensation.b_pos[0] + compensation.stribeck[0] / compensation.vs[0]  # at most, per speed
    bound = 3e-3 + slope * np.abs(v - 1e-6 * um_per_s) + 2 / 512 * compensation.b_pos[0] * v * 9 / 8 + 1.22 / 512 * 0.9
    effort_n = out * unit_a * machine.axes[0].effort_per_ampere
    assert (np.abs(effort_n - (up - down) / 2)[1:] <= bound[1:]).all()  # the first is the corner of the ramp
    assert effort_n[1:].min() > 1.0


def test_csv_and_yaml_hold_the_nodes_of_the_compensator(folder, twin, tmp_path):
    _, fixed, machine = twin
    content = yaml.safe_load((exported(folder, tmp_path, "yaml") / "compensation.yaml").read_text())
    exported(folder, tmp_path, "csv")
    rows = {name: [line.split(",") for line in (tmp_path / f"{name}.csv").read_text().splitlines()[1:]]
            for name in ("cogging", "friction")}  # fmt: skip
    for axis, entry in enumerate(content["axes"]):
        assert ("cogging" in entry) == (axis in COGGING)
        assert entry["effort_unit"] == "N"
        for name, table in ((name, entry[name]) for name in rows if name in entry):
            of_axis = np.array(
                [[*row[1:2], row[3], row[5]] for row in rows[name] if row[0] == str(axis + 1)], dtype=float
            )
            np.testing.assert_allclose(of_axis[:, 0], table["position" if name == "cogging" else "speed"], rtol=1e-8)
            np.testing.assert_allclose(of_axis[:, 1], table["effort"], rtol=1e-8, atol=1e-9)
            np.testing.assert_allclose(
                of_axis[:, 2] * entry["effort_per_ampere"], table["effort"], rtol=1e-7, atol=1e-7
            )
        if "cogging" in entry:
            nodes = np.rint(1e3 * np.array(entry["cogging"]["effort"])).astype(int)
            np.testing.assert_array_equal(nodes[:-1], fixed.position[axis, :, 0])
            assert nodes[-1] == nodes[0]
        if "friction" in entry:
            speed, effort = (np.array(entry["friction"][name]) for name in ("speed", "effort"))
            grid = node_speeds(machine.drive)[:, axis]
            is_node = np.isclose(np.abs(speed)[:, None], grid, rtol=1e-9, atol=0.0).any(axis=1)
            assert set(np.abs(speed[~is_node])) <= {0.0, speed[-1]}  # rest, and the end of either direction
            node = np.argmin(np.abs(np.abs(speed)[is_node][:, None] - grid), axis=1)
            address = node + np.where(speed[is_node] < 0, len(grid), 0)
            np.testing.assert_array_equal(np.rint(1e3 * effort[is_node]), fixed.friction[axis, address, 0])
            mu = np.rint(np.array(entry["friction"]["effort_per_load"])[is_node] * 2.0**17)
            assert np.abs(mu - fixed.mu[axis, address, 0]).max() <= 1
            assert (np.diff(speed) > 0).all()


def without(csv, *axes):
    return "\n".join(line for line in csv.splitlines() if line[0] not in axes) + "\n"


@pytest.mark.parametrize(
    ("kind", "changes", "complaint"),
    [
        ("moteus", ["--turn", "0.01", "0.05", "0.01539"], "axis 2: its pitch of 0.032 m is no whole part of 0.05 m"),
        ("moteus", ["--turn", "0.01", "0.064", "0.001"], "axis 3: its pitch of 0.00513 m is no whole part"),
        ("moteus", ["--turn", "0.01"], "--turn: 1 values for 3 axes"),
        ("moteus", ["--turn", "0.01", "0", "0.01"], "--turn must not be 0"),
        ("moteus", ["--zero", "nan", "0", "0"], "--zero: 3 values for 3 axes; give one finite number"),
        ("beckhoff", ["--speed", "1e-5", "1", "1"], "--speed: of axis 1 1e-05 is not above v_full"),
        ("beckhoff", ["--current-unit", "0"], "--current-unit must be above 0"),
        ("odrive", ["--turn", "0.01", "0.064", str(0.00513 * 500)], "axis 3: 1000 waves a turn of the motor"),
        ("beckhoff", ["--turn", "0.01", "0.064", str(0.00513 * 150)], "300 waves a turn of the motor, an AX8000 holds"),
    ],
)  # fmt: skip
def test_bad_order_is_one_line_and_nothing_written(kind, changes, complaint, folder, tmp_path, capsys):
    out = tmp_path / "out"
    assert cli.main(["export", kind, "--weights", str(folder), "--out", str(out), *ARGUMENTS, *changes]) == 2
    told = capsys.readouterr().err
    assert complaint in told
    assert told.count("\n") == 1
    assert not out.exists()


def test_turn_of_a_linear_axis_and_a_top_speed_have_no_default(folder, tmp_path, capsys):
    for kind, asked in (("odrive", "--turn: of axis 2 is missing"), ("csv", "--speed: of axis 2 is missing")):
        assert cli.main(["export", kind, "--weights", str(folder), "--out", str(tmp_path / kind)]) == 2
        assert asked in capsys.readouterr().err


def test_machine_with_nothing_for_the_drive_is_refused(tmp_path, capsys):
    frictionless = compensated_weights(tmp_path / "a", "axis,name,value\n")
    only_friction = compensated_weights(tmp_path / "b", without(CSV, "2", "3"))
    for folder, complaint in (
        (frictionless, "names no friction and no cogging"),
        (only_friction, "has no cogging, and"),
    ):
        assert cli.main(["export", "moteus", "--weights", str(folder), "--out", str(tmp_path / "out")]) == 2
        assert complaint in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
