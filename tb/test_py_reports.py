"""The reports on simulated runs: what is missing or damaged is one line, and nothing is printed or written."""

import pytest

from codes import ROOT
from gravcomp.core.formats import FORCE_BITS
from gravcomp.errors import InputError
from gravcomp_lab.__main__ import main
from gravcomp_lab.simulated.pictures import run_picture

WEIGHTS = ["--weights", str(ROOT / "weights" / "spheiro")]


@pytest.mark.parametrize(
    ("command", "name", "damaged"),
    [
        (["budget", *WEIGHTS, "--rtl", "budget.json"], "budget.json", ["{", "[1]", '[{"kind": "sums"}]']),
    ],
)
def test_report_refuses_a_missing_or_damaged_run_in_one_line(command, name, damaged, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for text in [None, *damaged]:
        if text is not None:
            (tmp_path / name).write_text(text)
        assert main(command) == 2
        printed = capsys.readouterr()
        assert printed.out == ""
        assert printed.err.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_picture_of_a_damaged_waveform_is_refused(tmp_path):
    (tmp_path / "run.vcd").write_text("nonsense")
    with pytest.raises(InputError, match=r"run.vcd: no waveform of a run, or a damaged one"):
        run_picture(tmp_path / "run.vcd", 3, FORCE_BITS, "N")


def test_simulation_without_rtl_is_refused_in_one_line(tmp_path, capsys):
    assert main(["sim-report", *WEIGHTS, "--rtl", str(tmp_path), "--build", str(tmp_path)]) == 2
    printed = capsys.readouterr()
    assert (printed.out, printed.err.count("\n")) == ("", 1)
    assert not list(tmp_path.iterdir())


def test_latency_of_a_core_is_measured_by_the_command(tmp_path, capsys):
    assert main(["latency", *WEIGHTS, "--rtl", str(ROOT / "rtl"), "--lanes", "4", "--build", str(tmp_path)]) == 0
    assert "| 4 | 5 | 23 | 0.575 |" in capsys.readouterr().out
