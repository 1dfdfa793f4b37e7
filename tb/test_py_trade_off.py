"""The page of largest errors: its rows, measured anew for the shipped networks, and its picture."""

import numpy as np
import pytest

from gravcomp.core.folder import load_folder
from gravcomp.errors import InputError
from gravcomp_lab.__main__ import main
from gravcomp_lab.commands.largest_error import PAGE, PART, SEEDS, SHIPPED, Row, measured, picture, rows_of, text_of
from gravcomp_lab.pages import read
from gravcomp_lab.shipped import ROOT

TABLE = read(ROOT / "docs" / "measured" / PAGE, PART)


def test_rows_are_read_back_as_they_are_written():
    assert text_of(rows_of(TABLE)) == TABLE


def test_row_of_a_network_is_its_errors_over_workspace_and_boundary():
    weights = ROOT / "weights" / "spheiro_minimax"
    found = measured(weights, Row("asked", "how", 0.0, 0.0, 0.0), 500)
    content = load_folder(weights)
    robot = content.machine.robot
    inside, boundary = robot.workspace(500, SEEDS[0]), robot.boundary(500, SEEDS[1])
    error = [content.network.forces(q) - robot.forces(q) for q in (inside, boundary)]
    assert found.mean_square == pytest.approx((error[0] ** 2).sum() / error[0].size)
    assert (found.inside, found.boundary) == pytest.approx([max(e.max(), -e.min()) for e in error])


def test_shipped_networks_stand_in_the_page_and_the_picture_is_a_png():
    rows = rows_of(TABLE)
    assert {row.asked for row in rows} >= set(SHIPPED.values())
    assert picture(rows).startswith(b"\x89PNG")


def test_row_that_is_none_is_refused():
    with pytest.raises(InputError, match="is no row of"):
        rows_of(TABLE + "\n| 0.3 | 6000, 30 | little | 0.2 | 0.3 |")


def test_sweep_goes_into_the_page_whole_or_not_at_all(tmp_path, capsys):
    sweep, docs = tmp_path / "sweep", tmp_path / "docs"
    (docs / "figures").mkdir(parents=True)
    sweep.mkdir()
    page = docs / "machines.md"
    page.write_text("before\n<!-- sweep -->\nold\n<!-- /sweep -->\nafter\n")
    (sweep / "sweep.md").write_text("| neurons |\n")
    assert main(["sweep", str(sweep), "--docs", str(docs)]) == 2
    assert "sweep.png: not there" in capsys.readouterr().err
    assert read(page, "sweep") == "old"
    (sweep / "sweep.png").write_bytes(b"\x89PNG")
    assert main(["sweep", str(sweep), "--docs", str(docs)]) == 0
    assert read(page, "sweep") == "| neurons |"
    assert (docs / "figures" / "sweep.png").read_bytes() == b"\x89PNG"


def test_minimax_network_trades_mean_square_for_the_largest_error():
    by_asked = {row.asked: row for row in rows_of(TABLE)}
    usual, least = (by_asked[SHIPPED[name]] for name in ("spheiro", "spheiro_minimax"))
    assert max(least.inside, least.boundary) < 0.25 * max(usual.inside, usual.boundary)
    assert least.mean_square > usual.mean_square
    assert np.isfinite([least.mean_square, least.inside, least.boundary]).all()
