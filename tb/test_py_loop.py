"""The command loop: which robot it takes, what it puts where, and that the result is a weights folder as any other."""

import contextlib
import io
import json

import numpy as np
import pytest

import gravcomp_lab.__main__ as lab
from codes import ROOT
from gravcomp.cli import main
from gravcomp.core.compensation import load_compensation
from gravcomp.loop.loop import RUNS, SAMPLES
from gravcomp.network.weights import load_network
from gravcomp.robot.machine import load_machine
from machines import changed, machine_folder
from measured_samples import holds, write_log

WEIGHTS = ROOT / "weights" / "spheiro"
FC_N = np.array([1.0, 2.0, 1.5])


@pytest.fixture(scope="module")
def heavy(tmp_path_factory):
    """Folder of a machine with another platform, and the log of its holds with Coulomb friction."""
    folder = tmp_path_factory.mktemp("heavy robot")
    machine_folder(folder / "machine", text=changed(("mass_kg = 10.5", "mass_kg = 14.0")))
    data = holds(160, 4)
    statics = load_machine(folder / "machine").robot.forces(data.q)
    force = statics + FC_N * np.sign(data.v) + 0.1 * np.random.default_rng(1).standard_normal(data.shape)
    write_log(folder / "log.csv", data.t_s, data.q, data.v, force)
    return folder


@pytest.fixture(scope="module")
def printed(heavy):
    """What the loop prints, for the robot it is given; the result is kept in weights/mine."""
    kept = ["--save", str(heavy / "weights" / "mine")]
    with contextlib.redirect_stdout(io.StringIO()) as out:
        assert main(["loop", *arguments_for(heavy), *kept, "--out", str(heavy / "out")]) == 0
    return out.getvalue()


def arguments_for(folder, weights="machine"):
    return [str(folder / "log.csv"), "--weights", str(folder / weights)]


def test_loop_takes_the_robot_it_is_given(heavy, printed):
    found = json.loads((heavy / "out" / "report.json").read_text())
    assert [effect["name"] for effect in found["effects"]] == ["coulomb_friction"]
    assert f"compensator: coulomb_friction\n  nowhere: nothing\n  weights: {heavy / 'weights' / 'mine'}" in printed
    with np.load(heavy / "out" / SAMPLES) as samples:
        heavy_n = load_machine(heavy / "machine").robot.forces(samples["q_m"])
        np.testing.assert_allclose(samples["model_n"], heavy_n)


def test_result_is_kept_as_a_weights_folder_with_its_provenance(heavy, printed, tmp_path):
    kept = heavy / "weights" / "mine"
    constants = load_compensation(kept, 3)
    np.testing.assert_allclose([constants.fc_pos, constants.fc_neg], [FC_N, FC_N], atol=0.05)
    np.testing.assert_array_equal(load_network(kept).hidden_weights, load_network(WEIGHTS).hidden_weights)
    provenance = json.loads((kept / "provenance.json").read_text())
    assert provenance["data"]["log"] == "log.csv"
    assert provenance["metrics"]["model_after"]["rms_n"] == pytest.approx(0.1, rel=0.2)
    assert main(["rom", "--weights", str(kept), "--out", str(tmp_path)]) == 0
    for path in tmp_path.iterdir():
        made = (heavy / "out" / "after" / "generated" / path.name).read_text()
        assert path.read_text().replace("weights/mine", "weights/weights") == made


def test_effects_that_the_model_has_stay_in_the_hardware(heavy, printed):
    arguments = arguments_for(heavy, "weights/mine")
    assert main(["loop", *arguments, "--out", str(heavy / "second")]) == 0
    assert json.loads((heavy / "second" / "report.json").read_text())["verdict"] == "nothing_missing"
    first, second = (load_compensation(heavy / run / "after" / "weights", 3) for run in ("out", "second"))
    np.testing.assert_array_equal(second.fc_pos, first.fc_pos)


def test_folder_without_a_machine_is_refused_in_one_line(heavy, capsys):
    assert main(["loop", str(heavy / "log.csv"), "--weights", str(heavy)]) == 2
    error = capsys.readouterr().err
    assert f"{heavy}: no robot.toml; a machine folder needs it" in error
    assert error.count("\n") == 1


def test_errors_before_and_after_are_printed(heavy, printed):
    rows = [line.strip("| ").split(" | ") for line in printed.splitlines() if line.startswith("|")]
    assert rows[0] == ["held-out samples", *(f"{run}: RMS, N" if k == 0 else what
        for run in RUNS for k, what in enumerate(("RMS, N", "max, N", "ave, %")))]  # fmt: skip
    report = json.loads((heavy / "out" / "report.json").read_text())
    by_name = {name: [float(cell) for cell in cells] for name, *cells in rows[2:]}
    assert set(by_name) == {"analytic model", "network", "fixed point"}
    figures = [report[run][key] for run in RUNS for key in ("rms_n", "max_n", "ave_pct")]
    np.testing.assert_allclose(by_name["analytic model"], figures, atol=0.006)
    # Rounding to 18 bits and the twin's tables stay far below the noise.
    np.testing.assert_allclose(by_name["fixed point"], by_name["network"], atol=0.05)


def test_rtl_of_a_loop_that_is_not_there_ends_in_one_line(tmp_path, capsys):
    assert lab.main(["loop-rtl", "--loop", str(tmp_path)]) == 2
    printed = capsys.readouterr()
    assert (printed.out, printed.err.count("\n")) == ("", 1)
