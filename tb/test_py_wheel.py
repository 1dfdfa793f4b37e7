"""The wheel in an environment of its own, outside of this tree: what a user installs is enough for what a user does.

The environment sees no package of this one but those that the wheel asks for, by links to where they are installed
here, so that no network is needed and a dependency that is not declared is missed. pip's own work on the wheel is real.
"""

import importlib.metadata
import os
import subprocess
import sys
import venv
from pathlib import Path

import numpy as np
import pytest
from packaging.requirements import Requirement

from codes import ROOT
from gravcomp import __version__
from gravcomp.cli import main
from gravcomp.core.image import load_image

pytestmark = pytest.mark.slow

# Registers that answer with what they hold after a reset.
DRIVE = """
from gravcomp.driver.host import Host, Result
from gravcomp.driver.registers import read_registers
class Bus:
    words = {register.address: register.reset for register in read_registers().values()}
    def read(self, address): return self.words.get(address, 0)
    def write(self, address, word): self.words[address] = word
result, identity = Host(Bus()).open()
assert result == Result.OK, result
print(identity.hidden)
"""


def distributions(requirements: list[str]) -> dict[str, importlib.metadata.Distribution]:
    """What is installed here of requirements and of all that they require, by name; no extra."""
    found, left = {}, list(requirements)
    while left:
        requirement = Requirement(left.pop())
        if requirement.name in found or (requirement.marker and not requirement.marker.evaluate({"extra": ""})):
            continue
        found[requirement.name] = importlib.metadata.distribution(requirement.name)
        left += found[requirement.name].requires or []
    return found


def link(distribution: importlib.metadata.Distribution, site: Path) -> None:
    """Make a distribution of this environment visible in another's site-packages."""
    for name in {file.parts[0] for file in distribution.files} - {"..", "__pycache__"}:
        if not (site / name).exists():
            (site / name).symlink_to(distribution.locate_file(name))


class Installation:
    """A virtual environment with the wheel, and a folder to work in that is not in this tree."""

    def __init__(self, folder: Path):
        self.work = folder / "work"
        self.work.mkdir()
        self.environment = {"PATH": f"{folder / 'venv' / 'bin'}:{os.environ['PATH']}", "HOME": str(folder)}
        self.python = folder / "venv" / "bin" / "python"
        venv.create(folder / "venv")
        build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", folder]
        subprocess.run(build, cwd=ROOT, check=True, capture_output=True)
        pip = [sys.executable, "-m", "pip", "--python", self.python, "install", "--no-index", "--no-deps"]
        subprocess.run([*pip, *folder.glob("*.whl")], check=True, capture_output=True)
        script = "import sysconfig; print(sysconfig.get_path('purelib'))"
        site = Path(self.run("python", "-c", script).stdout.strip())
        (wheel,) = importlib.metadata.distributions(name="gravcomp", path=[str(site)])
        for distribution in distributions(wheel.requires).values():
            link(distribution, site)

    def run(self, *command, status: int = 0, cwd: Path | None = None) -> subprocess.CompletedProcess:
        done = subprocess.run(
            command, cwd=cwd or self.work, env=self.environment, capture_output=True, text=True, check=False
        )
        assert done.returncode == status, f"{command}: {done.returncode}\n{done.stdout}{done.stderr}"
        return done


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    return Installation(tmp_path_factory.mktemp("installed"))


@pytest.fixture(scope="module")
def project(installed):
    installed.run("gravcomp", "new", "project", "--robot", "spheiro")
    return installed.work / "project"


def test_wheel_is_the_users_package_alone(installed):
    assert installed.run("gravcomp", "--version").stdout == f"gravcomp {__version__}\n"
    where = installed.run("python", "-c", "import gravcomp; print(gravcomp.__file__)").stdout
    assert Path(where.strip()).is_relative_to(installed.python.parents[1])
    for module in ("gravcomp_lab", "cocotb", "mujoco", "codes"):
        installed.run("python", "-c", f"import {module}", status=1)


def test_installed_command_without_its_extra_says_what_to_install(installed, project):
    done = installed.run(
        *("gravcomp", "measure", "--robot", "project/weights/mine", "--out", "measured.csv", "--points", "8"), status=2
    )
    assert done.stderr.count("\n") == 1
    assert "pip install mujoco" in done.stderr
    assert not (installed.work / "measured.csv").exists()


def test_installed_gravcomp_writes_the_project_of_the_checkout(installed, project, tmp_path):
    assert main(["new", str(tmp_path / "project"), "--robot", "spheiro"]) == 0
    own, here = (
        {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
        for folder in (project, tmp_path / "project")
    )
    assert own.keys() == here.keys()
    assert [name for name in own if own[name] != here[name]] == ["Makefile"]  # it knows which Python wrote it


def test_project_stands_by_itself(installed, project):
    installed.run("make", "rom", cwd=project)
    assert "every force equal" in installed.run("make", "test", cwd=project).stdout
    installed.run("make", "elaborate", cwd=project)
    installed.run("make", "driver", cwd=project)


def test_installed_driver_knows_the_registers(installed):
    assert installed.run("python", "-c", DRIVE).stdout.strip().isdigit()


def test_installed_train_rom_formats_image(installed, project):
    """A small network, of which every other command then makes its part."""
    arguments = ("--hidden", "1", "--starts", "1", "--poses", "20", "--search", "0.05", "--out", "weights/small")
    installed.run("gravcomp", "train", "--robot", "project/weights/mine", *arguments)
    assert f'"commit": "{__version__}"' in (installed.work / "weights/small/provenance.json").read_text()
    installed.run("gravcomp", "rom", "--weights", "weights/small", "--out", "generated")
    installed.run("gravcomp", "rom", "--weights", "weights/small", "--out", "generated", "--check")
    assert "Fixed point against float" in installed.run("gravcomp", "formats", "--weights", "weights/small").stdout
    machine = str(project / "weights/mine")
    installed.run("gravcomp", "image", "--weights", machine, "--rom", machine, "--out", "image.bin")
    assert (installed.work / "image.bin").read_bytes() == load_image(Path(machine), Path(machine)).data


def test_installed_diagnose_and_loop(installed, project):
    log = installed.work / "log.csv"
    log.write_text("".join((ROOT / "data/prototype.csv").read_text().splitlines(keepends=True)[:150]))
    machine = str(project / "weights/mine")
    installed.run("gravcomp", "diagnose", "log.csv", "--robot", machine, "--out", "report")
    assert {path.name for path in (installed.work / "report").iterdir()} == {"model.toml", "report.html", "report.json"}
    assert "data:image/png" in (installed.work / "report/report.html").read_text()
    installed.run("gravcomp", "loop", "log.csv", "--weights", machine, "--save", "weights/next")
    installed.run("gravcomp", "rom", "--weights", "weights/next", "--out", "generated")


def test_installed_diagnose_takes_a_model_of_the_users_own(installed):
    t = np.linspace(0.0, 20.0, 400)
    rows = np.column_stack([t, np.sin(t), np.cos(t), 2.0 + 0.5 * np.cos(t), np.full_like(t, 2.0)])
    header = "t_s,q1_rad,v1_radps,f1_nm,fm1_nm"
    np.savetxt(installed.work / "own.csv", rows, delimiter=",", header=header, comments="")
    done = installed.run("gravcomp", "diagnose", "own.csv", "--out", "own")
    assert "viscous_friction" in done.stdout
