"""Really measured data. Looked for in ../shared/data or the folder named by GRAVCOMP_DATA."""

import json

import pytest

from gravcomp.cli import main
from support.published import published


def diagnosed(tmp_path, kind, name, *options):
    csv, out = str(tmp_path / "log.csv"), tmp_path / "out"
    assert main(["import", kind, published(name), "--out", csv]) == 0
    assert main(["diagnose", csv, "--out", str(out), *options]) == 0
    return json.loads((out / "report.json").read_text())


@pytest.mark.slow
def test_emps_names_friction_by_direction_within_the_published_error(tmp_path):
    found = diagnosed(tmp_path, "emps", "emps/DATA_EMPS.mat")
    coulomb = next(effect for effect in found["effects"] if effect["name"] == "coulomb_friction")
    assert coulomb["params"]["fc_neg_1"] > coulomb["params"]["fc_pos_1"] > 0
    assert "viscous_friction" in [effect["name"] for effect in found["effects"]]
    assert found["after_rel_pct"] <= 3.11


@pytest.mark.slow
def test_anticogging_finds_the_orders_from_the_forward_turn_alone(tmp_path):
    found = diagnosed(tmp_path, "anticogging", "laas_anticogging/stopped_data.txt", "--holdout", "reverse")
    names = {effect["name"]: effect["params"] for effect in found["effects"]}
    assert set(names) == {"cogging", "coulomb_friction"}
    orders = {int(key.split("_h")[1]) for key in names["cogging"] if key.startswith("amplitude")}
    assert {72, 18, 12, 144, 24, 36} <= orders
    assert found["before"]["rms_n"] > 0.13
    assert found["after"]["rms_n"] <= 0.029


def test_import_refuses_another_file_in_one_line(tmp_path, capsys):
    (tmp_path / "x.mat").write_text("no data")
    assert main(["import", "emps", str(tmp_path / "x.mat"), "--out", str(tmp_path / "x.csv")]) == 2
    assert "x.mat" in capsys.readouterr().err
    assert not (tmp_path / "x.csv").exists()
