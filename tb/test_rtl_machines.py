"""gc_core of every machine that is shipped equals its model bit for bit, at its interval and latency."""

import numpy as np
import pytest

from gravcomp.core.compensator_tables import quantise_compensation
from gravcomp.core.folder import load_folder
from gravcomp.core.formats import FORCE_BITS, quantise
from gravcomp.core.vhdl.network_package import write_rom
from gravcomp.twin.network import core
from gravcomp_lab.benches.force_path import motion_run
from gravcomp_lab.simulated.pictures import run_picture
from gravcomp_lab.simulated.poses import MOST_COUNTS
from machines import rtl_of
from runner import ROOT
from support.core import check_core


@pytest.mark.slow
@pytest.mark.parametrize(("name", "lanes"), [("fivebar", 4), ("arm2", 3), ("ur5", 8), ("panda", 8)])
def test_core_of_a_shipped_machine_equals_its_model(name, lanes, tmp_path):
    """Of the others, and of lanes that divide the neurons, see test_rtl_axes.py."""
    weights = ROOT / "weights" / name
    write_rom(weights, tmp_path)
    options = {"generated": tmp_path, "label": name, "tests": r"\.back_to_back$"}
    check_core(lanes, environment={"WEIGHTS": str(weights)}, **options)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["slide", "ur5"])
def test_motion_of_a_shipped_machine_through_its_encoder_pins_equals_the_model(name, tmp_path):
    """The motion of `make sim` moves every axis within what the pins take, and within its range."""
    weights = ROOT / "weights" / name
    content = load_folder(weights)
    drive = content.machine.drive
    run = motion_run(rtl_of(weights, tmp_path / "rtl"), tmp_path, weights, tmp_path / "run.vcd", n_poses=6)
    compensation = quantise_compensation(content.compensation, drive, weights)
    assert not run.lsb(quantise(content.network, drive, weights), compensation).any()
    steps = np.abs(np.diff(run.count, axis=0))
    assert steps.max(axis=0).min() > 0
    assert steps.max() <= MOST_COUNTS
    figure = run_picture(tmp_path / "run.vcd", content.machine.n_axes, FORCE_BITS, content.machine.effort_unit)
    units = {"slide": "mN", "ur5": "mNm"}
    assert figure.axes[1].get_ylabel() == f"change of the forces, {units[name]}"
    labels = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert labels == [f"axis {k}" for k in range(1, content.machine.n_axes + 1)]


def test_ur5_misses_the_statics_by_less_than_0_07_percent_in_the_hardware_too():
    """Over 8000 poses of all ranges that training did not see: RMS of the error by RMS of the efforts, from counts."""
    folder = ROOT / "weights" / "ur5"
    content = load_folder(folder)
    fixed, drive = quantise(content.network, content.machine.drive, folder), content.machine.drive
    q_rad = content.machine.robot.workspace(8000, 2)
    exact_nm = content.machine.robot.forces(q_rad)
    for what, found_nm in (
        ("float", content.network.forces(q_rad)),
        ("core", core(drive.counts(q_rad), fixed).force_mn / 1e3),
    ):
        percent = 100 * np.sqrt(np.mean((found_nm - exact_nm) ** 2) / np.mean(exact_nm**2))
        print(f"MEASURED ur5, {what}: {percent:.4f} % RMS of RMS effort, {np.abs(found_nm - exact_nm).max():.4f} Nm")
        assert percent <= 0.07
