"""Machine folders: one number that differs gives another ROM with another hash, or a refusal that names it."""

import json
import re

import numpy as np
import pytest

from arm import arm_toml
from gravcomp.cli import main
from gravcomp.core.folder import folder_hash, load_folder
from gravcomp.core.formats import quantise
from gravcomp.core.image import load_image
from gravcomp.core.vhdl.network_package import PACKAGE_FILE, rom_files
from gravcomp.errors import InputError
from gravcomp.network.weights import load_network
from gravcomp.robot.machine import ROBOT_TOML, load_machine
from gravcomp.training.scaling import workspace_scaling
from gravcomp.twin.compensator import friction, period_of
from machines import MACHINE, SHIPPED, changed, machine_folder

FRICTION = "axis,name,value\nall,fc_pos,3\nall,fc_neg,3\nall,b_pos,200\nall,b_neg,200\n" + (
    "all,v_dead,1e-4\nall,v_full,2e-4\n"
)
# Machines that the core can be built for without training again, by what differs.
DRIVES = {
    "step": ("counts_per_m = 1000000", "counts_per_m = 2000000"),
    "step of one axis": ("counts_per_m = 1000000  ", "counts_per_m = 2000000  "),
    "K_t": ("effort_per_ampere = 45.0", "effort_per_ampere = 20.0"),
    "K_t of one axis": ("effort_per_ampere = 45.0  ", "effort_per_ampere = 20.0  "),
    "clock": ("clock_hz = 40e6", "clock_hz = 100e6"),
}
# Machines that the network does not belong to, by what differs, and the key that is named.
STATICS = {
    "mass": (
        ("mass_kg = 10.5", "mass_kg = 10.6"),
        "model.platform.mass_kg = 10.6, but the network was trained with 10.5",
    ),
    "gravity": (
        ("g_mps2 = 9.81", "g_mps2 = 9.80"),
        "model.gravity.g_mps2 = 9.8, but the network was trained with 9.81",
    ),
    "workspace": (("tilt_max_deg = 35.0", "tilt_max_deg = 30.0"), "workspace.tilt_max_deg = 30.0"),
    "range": (("high = 0.161", "high = 0.17"), "axis 1.high = 0.17"),
}


@pytest.fixture
def folder(tmp_path):
    """A copy of the shipped machine with friction."""
    machine_folder(tmp_path / "weights")
    (tmp_path / "weights" / "compensation.csv").write_text(FRICTION)
    return tmp_path / "weights"


def rom_and_hash(folder) -> tuple[str, str]:
    text = rom_files(folder)[PACKAGE_FILE]
    return text, re.search(r'x"([0-9a-f]{64})"', text)[1]


@pytest.mark.parametrize("change", DRIVES)
def test_a_machine_with_another_drive_gets_another_rom_and_hash(folder, change):
    before = rom_and_hash(folder)
    (folder / ROBOT_TOML).write_text(changed(DRIVES[change]))
    after = rom_and_hash(folder)
    assert after[0] != before[0]
    assert after[1] != before[1]
    assert after[1] == folder_hash(folder, load_machine(folder))


@pytest.mark.parametrize("name", ["hidden.csv", "output.csv", "scaling.csv", "compensation.csv"])
def test_hash_covers_every_file_of_the_rom(folder, name):
    before = folder_hash(folder, MACHINE)
    (folder / name).write_text((folder / name).read_text() + "\n")
    assert folder_hash(folder, MACHINE) != before


def test_counts_of_a_finer_encoder_span_the_same_range(folder):
    (folder / ROBOT_TOML).write_text(changed(DRIVES["step of one axis"]))
    content = load_folder(folder)
    fixed = quantise(content.network, content.machine.drive)
    np.testing.assert_array_equal(fixed.count_high, [321995, 160997, 160997])
    np.testing.assert_array_equal(fixed.count_low, [-321995, -160997, -160997])


def test_currents_follow_the_thrust_constant_of_each_axis(folder):
    (folder / ROBOT_TOML).write_text(changed(DRIVES["K_t of one axis"]))
    content = load_folder(folder)
    fixed = quantise(content.network, content.machine.drive)
    ua_per_mn = fixed.current_scale / 2.0**fixed.current_scale_fraction
    np.testing.assert_allclose(ua_per_mn, 1e3 / np.array([20.0, 45.0, 45.0]), rtol=1e-4)


@pytest.mark.parametrize("change", DRIVES)
def test_friction_is_that_of_the_speed_whatever_encoder_and_clock(folder, change):
    """618 mN of it is what a loop for another clock took for 1384."""
    (folder / ROBOT_TOML).write_text(changed(DRIVES[change]))
    content = load_folder(folder)
    from gravcomp.core.compensator_tables import quantise_compensation

    drive, v = content.machine.drive, np.full((1, 3), 4e-3)
    fixed = quantise_compensation(content.compensation, drive, folder)
    found_mn = friction(np.zeros((1, 3), int), period_of(v, drive), fixed)
    np.testing.assert_allclose(found_mn, 1e3 * content.compensation.friction(v), atol=10)


@pytest.mark.parametrize("change", STATICS)
@pytest.mark.parametrize("command", ["rom", "image", "formats"])
def test_a_network_of_another_machine_is_refused_by_the_key(folder, change, command, capsys):
    edit, named = STATICS[change]
    (folder / ROBOT_TOML).write_text(changed(edit))
    more = {"rom": ["--out"], "image": ["--rom", str(SHIPPED), "--out"], "formats": []}[command]
    more += [str(folder / "out")] if more else []
    assert main([command, "--weights", str(folder), *more]) == 2
    complaint = capsys.readouterr().err
    assert complaint.count("\n") == 1
    assert named in complaint
    assert "gravcomp train" in complaint
    assert not (folder / "out").exists()


@pytest.mark.parametrize("command", ["rom", "image", "formats"])
def test_an_activation_that_the_hardware_does_not_run_is_refused(folder, command, capsys):
    (folder / ROBOT_TOML).write_text(changed(('activation = "gamma"', 'activation = "tanh"')))
    more = {"rom": ["--out"], "image": ["--rom", str(SHIPPED), "--out"], "formats": []}[command]
    more += [str(folder / "out")] if more else []
    assert main([command, "--weights", str(folder), *more]) == 2
    complaint = capsys.readouterr().err
    assert "activation = 'tanh', but the hardware runs gamma; `gravcomp train --from" in complaint
    assert not (folder / "out").exists()


def test_a_folder_without_a_machine_or_its_provenance_is_refused(folder):
    (folder / "provenance.json").unlink()
    with pytest.raises(InputError, match=r"provenance.json: does not say .* `gravcomp adopt "):
        load_folder(folder)
    (folder / ROBOT_TOML).unlink()
    with pytest.raises(InputError, match=r"no robot.toml; a machine folder needs it"):
        load_folder(folder)


def test_image_for_a_core_of_another_clock_is_refused(folder):
    (folder / ROBOT_TOML).write_text(changed(DRIVES["clock"]))
    with pytest.raises(InputError, match=r"clock_hz = 1e\+08, but the core of .* runs at 4e\+07"):
        load_image(folder, SHIPPED)


def test_a_network_of_another_tool_is_adopted_when_it_fits(folder, capsys):
    (folder / "provenance.json").unlink()
    assert main(["adopt", str(folder)]) == 0
    assert "0.0594 N RMS off its statics, 0.11 %" in capsys.readouterr().out
    load_folder(folder)
    (folder / ROBOT_TOML).write_text(changed(("mass_kg = 10.5", "mass_kg = 21")))
    before = (folder / "provenance.json").read_text()
    assert main(["adopt", str(folder)]) == 2
    assert "off the statics of robot.toml" in capsys.readouterr().err
    assert (folder / "provenance.json").read_text() == before


@pytest.mark.slow
def test_a_tanh_network_is_trained_further_to_the_hardware(folder, tmp_path, capsys):
    """Run as it is it errs by newtons; trained further it is a network as any other."""
    (folder / ROBOT_TOML).write_text(changed(('activation = "gamma"', 'activation = "tanh"')))
    train = ["--hidden", "12", "--starts", "1", "--poses", "600", "--out", str(tmp_path / "tanh")]
    assert main(["train", "--robot", str(folder), *train]) == 0
    out = tmp_path / "gamma"
    assert main(["train", "--from", str(tmp_path / "tanh"), "--poses", "600", "--out", str(out)]) == 0
    assert load_machine(out).activation == "gamma"
    q = MACHINE.robot.workspace(2000, 9)
    wrong, right = (
        float(np.sqrt(np.mean((load_network(name).forces(q) - MACHINE.robot.forces(q)) ** 2)))
        for name in (tmp_path / "tanh", out)
    )
    print(f"MEASURED tanh run with Gamma {wrong:.2f} N RMS, trained further {right:.2f} N")
    assert wrong > 0.8
    assert right < 0.4
    assert main(["rom", "--weights", str(out), "--out", str(tmp_path / "generated")]) == 0


def test_workspace_beyond_the_range_of_an_axis_is_refused():
    from gravcomp.robot.machine import parse_machine

    machine = parse_machine(changed(("high = 0.161", "high = 0.15")), "here")
    with pytest.raises(InputError, match=r"here: axis 1: low .. high = -0.161 .. 0.15 is narrower than the workspace"):
        workspace_scaling(machine)


def test_provenance_holds_hash_and_keys_of_what_was_trained_on():
    known = json.loads((SHIPPED / "provenance.json").read_text())["machine"]
    assert known["trained_on"]["network.activation"] == "gamma"
    assert known["trained_on"] == json.loads(json.dumps(MACHINE.trained_on()))


def test_older_scaling_header_is_read_as_metres_and_newtons(folder):
    network = load_network(folder)
    rows = np.stack([network.q_offset, network.q_scale, network.f_offset, network.f_scale], axis=1)
    lines = [",".join(map(repr, map(float, row))) for row in rows]
    header = "axis,q_offset_m,q_scale_per_m,f_offset_n,f_scale_n"
    (folder / "scaling.csv").write_text("\n".join([header, *(f"{k},{line}" for k, line in enumerate(lines, 1))]) + "\n")
    again = load_network(folder)
    for name, value in vars(network).items():
        np.testing.assert_array_equal(getattr(again, name), value)


@pytest.mark.parametrize("command", ["adopt", "rom", "train"])
def test_weights_of_another_number_of_axes_are_refused_by_their_file(folder, command, capsys):
    text = load_machine(folder).text
    (folder / ROBOT_TOML).write_text(arm_toml(2))
    out = str(folder / "out")
    how = {"adopt": [str(folder)], "rom": ["--weights", str(folder), "--out", out]}
    assert main([command, *how.get(command, ["--from", str(folder), "--out", out])]) == 2
    complaint = capsys.readouterr().err
    assert complaint.count("\n") == 1
    assert "scaling.csv: " in complaint
    assert not (folder / "out").exists()
    (folder / ROBOT_TOML).write_text(text)
    load_folder(folder)


def test_a_kind_that_comes_onto_the_path_later_is_found(tmp_path, monkeypatch):
    """As in a notebook that installs a robot's package after it was told that it needs it."""
    (tmp_path / ROBOT_TOML).write_text(arm_toml(2).replace('kind = "arm"', 'kind = "other_arm"'))
    with pytest.raises(InputError, match="'other_arm' is not installed"):
        load_machine(tmp_path)
    package = tmp_path / "late-1.0.dist-info"
    package.mkdir()
    (package / "METADATA").write_text("Metadata-Version: 2.1\nName: late\nVersion: 1.0\n")
    (package / "entry_points.txt").write_text("[gravcomp.robots]\nother_arm = arm:from_table\n")
    monkeypatch.syspath_prepend(tmp_path)
    assert load_machine(tmp_path).n_axes == 2
