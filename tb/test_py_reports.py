"""The reports on simulated runs: what is missing or damaged is one line, and nothing is printed or written."""

import pytest

from codes import ROOT
from gravcomp_lab.__main__ import main

WEIGHTS = ["--weights", str(ROOT / "weights" / "spheiro")]
RUN_HEADER = "set,count1,count2,count3,f1_mn,f2_mn,f3_mn\n"


@pytest.mark.parametrize(
    ("command", "name", "damaged"),
    [
        (["budget", *WEIGHTS, "--rtl", "budget.json"], "budget.json", ["{", "[1]", '[{"kind": "sums"}]']),
        (["sim-report", *WEIGHTS, "--run", "."], "poses.csv", ["", RUN_HEADER, RUN_HEADER + "a,b,c,d,e,f,g\n"]),
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


def test_report_refuses_a_damaged_waveform_before_it_draws(tmp_path, capsys):
    (tmp_path / "poses.csv").write_text(RUN_HEADER + "home,0,0,0,50294,50294,50294\n")
    (tmp_path / "run.vcd").write_text("nonsense")
    assert main(["sim-report", *WEIGHTS, "--run", str(tmp_path)]) == 2
    printed = capsys.readouterr()
    assert (printed.out, printed.err.count("\n")) == ("", 1)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["poses.csv", "run.vcd"]


def test_latency_of_a_core_is_measured_by_the_command(tmp_path, capsys):
    assert main(["latency", *WEIGHTS, "--rtl", str(ROOT / "rtl"), "--lanes", "4", "--build", str(tmp_path)]) == 0
    assert "| 4 | 5 | 23 | 0.575 |" in capsys.readouterr().out
