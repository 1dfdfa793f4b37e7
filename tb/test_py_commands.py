"""The command line: what it lists, and that no command imports what it does not use."""

import errno
import os
import pkgutil
import shutil
import subprocess
import sys

import numpy as np
import pytest

import gravcomp.commands
from gravcomp import __version__, cli
from gravcomp.commands import rom
from gravcomp.errors import InputError, optional
from gravcomp_lab.shipped import SPHEIRO

# numpy, and what is larger.
HEAVY = {"numpy", "scipy", "pandas", "sklearn", "joblib", "jinja2", "matplotlib", "mujoco", "cocotb", "cocotb_tools"}


def loaded(program: str, *arguments: str) -> set[str]:
    """The top-level modules that a fresh Python has loaded at the end of a program."""
    script = (
        "import atexit, sys; atexit.register(lambda: print('LOADED', *{name.split('.')[0] for name in sys.modules}))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script + program, *arguments], capture_output=True, text=True, check=True
    )
    return set(done.stdout.rpartition("LOADED")[2].split())


@pytest.mark.parametrize("package", ["gravcomp.cli", "gravcomp_lab.__main__"])
def test_help_imports_nothing_heavy(package):
    assert not HEAVY & loaded(f"from {package} import main; main(['--help'])")


@pytest.mark.parametrize("command", cli.COMMANDS)
def test_help_of_a_command_imports_nothing_heavy(command):
    assert not HEAVY & loaded(f"from gravcomp.cli import main; main(['{command}', '--help'])")


def test_diagnosis_without_report_html_imports_no_simulator_and_no_plots(tmp_path):
    t = np.linspace(0.0, 20.0, 400)
    rows = np.column_stack([t, np.sin(t), np.cos(t), 2.0 + np.cos(t), np.full_like(t, 2.0)])
    log = tmp_path / "log.csv"
    np.savetxt(log, rows, delimiter=",", header="t_s,q1_rad,v1_radps,f1_nm,fm1_nm", comments="")
    program = (
        "from gravcomp.diagnosis.diagnosis import diagnose\n"
        "from gravcomp.diagnosis.model import Model\n"
        "from gravcomp.diagnosis.report import report_html\n"
        "from gravcomp.logs.csv_reader import read_measurement\n"
        "diagnose(read_measurement(sys.argv[1], None), Model())\n"
    )
    modules = loaded(program, str(log))
    assert "sklearn" in modules
    assert not {"matplotlib", "mujoco", "cocotb", "cocotb_tools"} & modules


def test_every_command_is_listed(capsys):
    modules = {info.name.rstrip("_").replace("_", "-") for info in pkgutil.iter_modules(gravcomp.commands.__path__)}
    assert modules == set(cli.COMMANDS)
    with pytest.raises(SystemExit):
        cli.main(["--help"])
    printed = capsys.readouterr().out
    places = [printed.index(f"\n    {command}") for command in cli.COMMANDS]
    assert places == sorted(places)


def test_version(capsys):
    with pytest.raises(SystemExit) as stop:
        cli.main(["--version"])
    assert (stop.value.code, capsys.readouterr().out) == (0, f"gravcomp {__version__}\n")


@pytest.mark.parametrize("arguments", [[], ["nothing"], ["--", "nothing"], ["rom"], ["--", "rom"], ["-x", "rom"]])
def test_wrong_arguments_are_one_line(arguments, capsys):
    with pytest.raises(SystemExit) as stop:
        cli.main(arguments)
    assert stop.value.code == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_missing_extra_is_one_line_that_tells_the_package(monkeypatch):
    monkeypatch.setitem(sys.modules, "cocotb_tools.runner", None)
    with pytest.raises(
        InputError, match=r"^cocotb is not installed, and a simulation needs it; start `\S+ -m pip install cocotb`$"
    ):
        optional("cocotb_tools.runner", "cocotb", "a simulation")


def started(*arguments: str, **streams) -> subprocess.CompletedProcess:
    """The command line in a process of its own, as its streams and signals are."""
    return subprocess.run([sys.executable, "-m", "gravcomp", *arguments], stderr=subprocess.PIPE, text=True,
                          check=False, **streams)  # fmt: skip


@pytest.mark.parametrize("arguments", [("--help",), ("formats", "--weights", str(SPHEIRO))])
def test_full_disk_behind_standard_output_is_one_line(arguments):
    with open("/dev/full", "w", encoding="utf-8") as full:
        done = started(*arguments, stdout=full)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "standard output: No space left on device; check" in done.stderr


@pytest.mark.parametrize("arguments", [("--help",), ("formats", "--weights", str(SPHEIRO))])
def test_reader_that_has_had_enough_is_no_error(arguments):
    read, write = os.pipe()
    os.close(read)
    done = started(*arguments, stdout=write)
    os.close(write)
    assert (done.returncode, done.stderr) == (0, "")


def test_interrupt_is_one_line_with_the_status_of_a_shell(monkeypatch, capsys):
    def interrupted(_):
        raise KeyboardInterrupt

    monkeypatch.setattr(rom, "run", interrupted)
    assert cli.main(["rom", "--weights", str(SPHEIRO)]) == 130
    assert capsys.readouterr().err == "gravcomp rom: stopped; a file is written whole or not at all\n"


def test_error_of_a_file_that_no_command_expects_is_one_line(monkeypatch, capsys):
    def refused(_):
        raise PermissionError(errno.EACCES, "Permission denied", "mine.csv")

    monkeypatch.setattr(rom, "run", refused)
    assert cli.main(["rom", "--weights", str(SPHEIRO)]) == 2
    assert capsys.readouterr().err.startswith("gravcomp rom: mine.csv: Permission denied; check ")


@pytest.mark.parametrize(
    ("name", "told"), [("a b", "a b"), ("größe 机", "größe 机"), ("a\nb", "a\\nb"), (b"a\xffb", "a\\udcffb")]
)
def test_machine_folder_may_have_any_name(name, told, tmp_path, capsys):
    folder = tmp_path / os.fsdecode(name)
    shutil.copytree(SPHEIRO, folder)
    assert cli.main(["rom", "--weights", str(folder), "--out", str(tmp_path / "out")]) == 0
    for file in ("gc_network_pkg.vhd", "gc_compensation_pkg.vhd", "gravcomp_machine.h"):
        lines = (tmp_path / "out" / file).read_text(encoding="utf-8").splitlines()
        assert [line for line in lines if f"from weights/{told}" in line and "edit." in line]
    assert cli.main(["rom", "--weights", str(folder), "--out", str(tmp_path / "out"), "--check"]) == 0
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    "provenance", ["[" * 100_000, '{"machine": {"trained_on": 5}}', '{"machine": {"trained_on": [5]}}']
)
def test_provenance_that_is_none_is_one_line(provenance, tmp_path, capsys):
    shutil.copytree(SPHEIRO, tmp_path / "mine")
    (tmp_path / "mine" / "provenance.json").write_text(provenance)
    assert cli.main(["rom", "--weights", str(tmp_path / "mine"), "--out", str(tmp_path / "out")]) == 2
    assert "provenance.json: does not say what the network was trained on" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("work", "arguments"),
    [
        ("gravcomp.training.training.training_and_test_set", ("train", "--robot", SPHEIRO, "--out", "file/mine")),
        ("gravcomp.training.training.training_and_test_set", ("train", "--robot", SPHEIRO, "--out", "file")),
        ("gravcomp.prototype.experiment.measure", ("measure", "--robot", SPHEIRO, "--out", "file/log.csv")),
        ("gravcomp.prototype.experiment.measure", ("measure", "--robot", SPHEIRO, "--out", "folder")),
        ("gravcomp.logs.csv_reader.read_measurement", ("loop", "file", "--weights", SPHEIRO, "--out", "file")),
        ("gravcomp.logs.csv_reader.read_measurement", ("loop", "file", "--weights", SPHEIRO, "--save", "file/mine")),
    ],
)
def test_place_that_cannot_be_written_is_refused_before_the_work(work, arguments, tmp_path, monkeypatch, capsys):
    def begun(*_, **__):
        raise AssertionError("begun")

    monkeypatch.setattr(work, begun)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("mine")
    (tmp_path / "folder").mkdir()
    assert cli.main([str(word) for word in arguments]) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert "is a folder; give a file" in told if "folder" in arguments else "file: is a file; give a folder" in told
    assert (tmp_path / "file").read_text() == "mine"
