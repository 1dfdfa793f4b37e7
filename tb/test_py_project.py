"""`gravcomp new`: a project folder that is whole or not there, and what stands by itself in it.

That an installed gravcomp writes the same: tb/test_py_wheel.py.
"""

import os
import shutil
import subprocess

import numpy as np
import pytest

from codes import ROOT
from gravcomp.cli import main
from gravcomp.core.component import component_text
from gravcomp.core.formats import quantise
from gravcomp.core.vhdl.network_package import stale_rom_files
from gravcomp.network.weights import load_network
from gravcomp.project import project
from gravcomp.robot.machine import load_machine
from gravcomp.twin.network import core
from gravcomp.twin.vectors import random_vectors
from machines import MACHINE, SHIPPED, changed, machine_folder


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A project of the machine that is built in."""
    folder = tmp_path_factory.mktemp("new") / "below" / "project"
    assert main(["new", str(folder), "--robot", "spheiro"]) == 0
    return folder


@pytest.fixture
def copy(written, tmp_path):
    return shutil.copytree(written, tmp_path / "project")


def make(folder, *arguments: str) -> subprocess.CompletedProcess:
    # Without what the make that runs the tests exports: the machine of this clone.
    own = {name: value for name, value in os.environ.items() if name not in ("WEIGHTS", "MAKEFLAGS", "MAKELEVEL")}
    return subprocess.run(["make", *arguments], cwd=folder, env=own, capture_output=True, text=True, check=False)


def test_project_holds_the_machine_and_its_rom(written):
    for path in SHIPPED.iterdir():
        assert (written / "weights" / "mine" / path.name).read_bytes() == path.read_bytes()
    assert not stale_rom_files(written / "weights" / "mine", written / "rtl" / "generated")


def test_project_holds_every_source_and_file_that_its_lists_name(written):
    for name in (written / "rtl" / "sources.f").read_text().split():
        if not name.startswith("generated/"):
            assert (written / "rtl" / name).read_bytes() == (ROOT / "rtl" / name).read_bytes()
    for line in (written / "gravcomp.core").read_text().splitlines():
        if line.startswith("      - rtl/") or line.startswith("      - tb/"):
            assert (written / line.split()[1]).is_file()
    for name in ("gravcomp.c", "gravcomp.h", "gravcomp_registers.h"):
        assert (written / "host" / name).read_bytes() == (ROOT / "host" / name).read_bytes()


def test_project_takes_a_machine_folder(tmp_path):
    text = changed(("counts_per_m = 1000000", "counts_per_m = 2000000"))
    machine = machine_folder(tmp_path / "machine", text=text)
    assert main(["new", str(tmp_path / "project"), "--robot", str(machine)]) == 0
    assert (tmp_path / "project" / "weights" / "mine" / "robot.toml").read_text() == text
    rom = (tmp_path / "project" / "rtl" / "generated" / "gc_network_pkg.vhd").read_text()
    (high, *_) = quantise(load_network(machine), load_machine(machine).drive).count_high
    assert high > 300000
    assert str(high) in rom


@pytest.mark.parametrize("name", sorted(path.name for path in SHIPPED.parent.iterdir()))
def test_project_of_each_machine_that_is_built_in(name, tmp_path, capsys):
    """Those without a network are to be trained in the project; all their files are there for it."""
    assert main(["new", str(tmp_path / "project"), "--robot", name]) == 0
    printed = capsys.readouterr().out
    machine = tmp_path / "project" / "weights" / "mine"
    assert load_machine(machine).trained_on() == load_machine(SHIPPED.parent / name).trained_on()
    assert ("make train" in printed) == (not (machine / "hidden.csv").exists())
    assert (tmp_path / "project" / "rtl" / "generated").exists() == (machine / "hidden.csv").exists()


def test_project_is_written_into_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["new", ".", "--robot", "spheiro"]) == 0
    assert (tmp_path / "Makefile").is_file()
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".")]


def refused(capsys, *arguments: str) -> str:
    assert main(["new", *arguments]) == 2
    printed = capsys.readouterr()
    assert (printed.out, printed.err.count("\n")) == ("", 1)
    return printed.err


def test_project_refuses_a_folder_that_is_not_empty(tmp_path, capsys):
    (tmp_path / "mine.txt").write_text("mine")
    assert "not empty" in refused(capsys, str(tmp_path), "--robot", "spheiro")
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


def test_project_refuses_a_file(tmp_path, capsys):
    (tmp_path / "file").write_text("mine")
    for folder in (tmp_path / "file", tmp_path / "file" / "below"):
        assert "is a file" in refused(capsys, str(folder), "--robot", "spheiro")
    assert (tmp_path / "file").read_text() == "mine"


@pytest.mark.parametrize("robot", ["nothing", "../spheiro", "", "no robot.toml", "half a network", "other masses"])
def test_project_refuses_a_machine_that_is_not_whole(robot, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "no robot.toml").mkdir()
    for file in ("hidden.csv", "half a network/robot.toml", "other masses/robot.toml"):
        (tmp_path / file).parent.mkdir(exist_ok=True)
    (tmp_path / "half a network" / "robot.toml").write_text(MACHINE.text)
    (tmp_path / "half a network" / "hidden.csv").write_text("neuron\n")
    machine_folder(tmp_path / "other masses")
    (tmp_path / "other masses" / "robot.toml").write_text(changed(("mass_kg = 10.5", "mass_kg = 9.5")))
    error = refused(capsys, "project", "--robot", robot)
    assert ".new-" not in error
    assert not (tmp_path / "project").exists()


@pytest.mark.parametrize("is_there", [False, True])
@pytest.mark.parametrize("fault", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_project_that_cannot_be_written_leaves_nothing(fault, is_there, tmp_path, monkeypatch, capsys):
    def fail(*_):
        raise fault

    monkeypatch.setattr(project, "write_rom", fail)
    folder = tmp_path / "below" / "project"
    if is_there:
        folder.mkdir(parents=True)
    if isinstance(fault, OSError):
        assert "No space left" in refused(capsys, str(folder), "--robot", "spheiro")
    else:
        assert main(["new", str(folder), "--robot", "spheiro"]) == 130
    assert list(tmp_path.rglob("*")) == ([folder.parent, folder] if is_there else [])


def test_make_test_compares_the_rtl_with_the_twin(copy):
    done = make(copy, "test", "LANES=4")
    assert "500 lines, every force equal" in done.stdout + done.stderr
    assert done.returncode == 0


@pytest.mark.slow
def test_make_test_finds_another_rom_and_another_force(copy):
    """A ROM that is not the machine's; a line of the vectors that is off by one; none; no result."""
    rom = copy / "rtl" / "generated" / "gc_network_pkg.vhd"
    kept = rom.read_text()
    rom.write_text(kept + "\n")
    done = make(copy, "test")
    assert done.returncode != 0
    assert "not made from weights/mine" in done.stderr
    rom.write_text(kept)
    assert make(copy, "test").returncode == 0
    vectors = copy / "build" / "vectors.txt"
    lines = vectors.read_text().splitlines()
    words = lines[7].split()
    for number, text in (
        (8, "\n".join([*lines[:7], " ".join([*words[:-1], str(int(words[-1]) + 1)]), *lines[8:]]) + "\n"),
        (3, "\n".join([*lines[:2], "1 2"]) + "\n"),
        (None, ""),
    ):
        vectors.write_text(text)
        command = ["ghdl", "--elab-run", "--std=08", "gc_vectors_bench", "-gvectors_g=../vectors.txt"]
        done = subprocess.run(command, cwd=copy / "build" / "ghdl", capture_output=True, text=True, check=False)
        assert done.returncode != 0
        assert ("no line" if number is None else f"line {number}:") in done.stdout + done.stderr


@pytest.mark.slow
def test_project_of_the_serial_form_runs_its_own_core(copy):
    robot = copy / "weights" / "mine" / "robot.toml"
    robot.write_text(load_machine(robot.parent).with_form("serial").text)
    assert make(copy, "rom").returncode == 0
    for target, told in (("test", "every force equal"), ("sim", "force 1: ")):
        done = make(copy, target)
        assert told in done.stdout + done.stderr, done.stderr


@pytest.mark.slow
def test_make_elaborates_the_whole_system_and_compiles_the_driver(copy):
    assert make(copy, "elaborate").stdout.strip().endswith("gc_system: elaborated")
    assert make(copy, "driver").returncode == 0
    assert make(copy, "elaborate", "LANES=0").returncode != 0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["slide", "so101", "ur5"])
def test_project_of_other_axes_holds_what_they_can_use(name, tmp_path):
    """GHDL analyses every source, elaborates the largest top, computes the twin's forces; the driver compiles."""
    project = tmp_path / "project"
    assert main(["new", str(project), "--robot", name]) == 0
    assert make(project, "elaborate").stdout.strip().endswith("gc_system: elaborated")
    done = make(project, "test")
    assert "500 lines, every force equal" in done.stdout + done.stderr
    assert "metavalue" not in done.stdout + done.stderr  # lines that a stranger takes for faults
    listed = {project / "rtl" / name for name in (project / "rtl" / "sources.f").read_text().split()}
    assert set((project / "rtl").rglob("*.vhd")) == listed
    assert make(project, "driver").returncode == 0
    n_axes = load_machine(project / "weights" / "mine").n_axes
    assert (project / "rtl" / "component.xml").read_text() == component_text(n_axes)


def test_project_without_a_network_says_how_to_train_it(tmp_path, capsys):
    """In a folder with a space, too; the advice is a command of the user's shell."""
    project = tmp_path / "my project"
    assert main(["new", str(project), "--robot", "dvrk_mtm"]) == 0
    assert f"cd '{project}'" in capsys.readouterr().out
    done = make(project, "test")
    assert done.returncode != 0
    assert "`gravcomp train --robot weights/mine --out weights/mine`" in done.stderr.splitlines()[0]


def test_make_sim_tells_the_forces_of_the_twin(copy):
    fixed = quantise(load_network(SHIPPED), MACHINE.drive)
    done = make(copy, "sim", "COUNT=12345")
    for axis, force_mn in enumerate(core(np.full(3, 12345), fixed).force_mn, start=1):
        assert f"force {axis}: {force_mn} mN" in done.stdout + done.stderr


def test_vectors_reach_inside_and_outside_of_the_trained_range():
    fixed = quantise(load_network(SHIPPED), MACHINE.drive)
    vectors = random_vectors(fixed, 400, 3)
    count, force_mn = vectors[:, :3], vectors[:, 3:]
    np.testing.assert_array_equal(force_mn, core(count, fixed).force_mn)
    is_clamped = core(count, fixed).clamped.any(axis=1)
    assert 150 < is_clamped.sum() < 250
    assert {-(2**31) + 1, 2**31 - 1, 0, -1} <= set(count.ravel().tolist())


def test_makefile_of_a_project_lists_what_it_does(copy):
    printed = make(copy).stdout
    for target in ("rom", "test", "sim", "elaborate", "train", "loop", "driver"):
        assert f"\n{target} " in printed
