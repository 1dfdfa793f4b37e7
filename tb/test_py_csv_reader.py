"""The measured CSV: what it gives to the diagnosis, and one line naming file, row, column and remedy for bad input."""

import re

import numpy as np
import pytest

from arm import arm_toml
from gravcomp.errors import InputError
from gravcomp.logs.csv_reader import MIN_SAMPLES, read_measurement
from gravcomp.robot.machine import parse_machine
from machines import MACHINE
from measured_samples import MOTION_M, MOTION_RAD_PER_S, holds, motion

DATA = holds(40, 1)
HEADER = ["t_s", *(f"{stem}{i}_{unit}" for stem, unit in (("q", "m"), ("v", "mps"), ("f", "n")) for i in (1, 2, 3))]
ROWS = [[f"{x:.9g}" for x in row] for row in np.column_stack([DATA.t_s, DATA.q, DATA.v, DATA.force])]


def text(header=HEADER, rows=ROWS) -> str:
    return "\n".join(",".join(cells) for cells in [header, *rows]) + "\n"


def cell(row: int, column: str, value: str) -> str:
    """The file with one cell changed; row as in the file, its header being row 1."""
    k, j = row - 2, HEADER.index(column)
    return text(rows=[*ROWS[:k], [*ROWS[k][:j], value, *ROWS[k][j + 1 :]], *ROWS[k + 1 :]])


def renamed(**names: str) -> str:
    return text([names.get(name, name) for name in HEADER])


def only(*columns: str, **names: str) -> str:
    keep = [HEADER.index(name) for name in columns]
    return text([names.get(c, c) for c in columns], [[row[j] for j in keep] for row in ROWS])


def added(names: list[str], values: list[str]) -> str:
    return text(HEADER + names, [row + values for row in ROWS])


def read(tmp_path, content):
    path = tmp_path / "log.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_measurement(path, MACHINE)


BAD = {
    "cell of text": (cell(7, "f3_n", "off"), "row 7, column f3_n: 'off' is not a finite number"),
    "cell infinite": (cell(9, "v1_mps", "-inf"), "row 9, column v1_mps: '-inf' is not a finite number"),
    "cell too large": (cell(8, "f1_n", "1e300"), "row 8, column f1_n: '1e300' is not a finite number up to 1e+15"),
    "header again": (text(rows=[*ROWS[:5], HEADER, *ROWS[5:]]), "row 7, column t_s: 't_s' is not a finite number"),
    "prediction missing": (added(["fm1_n", "fm2_n", "fm3_n"], ["1", "1", ""]), "column fm3_n has no value in any row"),
    "one velocity missing": (text(rows=[[*row[:4], "", *row[5:]] for row in ROWS]), "column v1_mps has no value in"),
    "few rows whole": (text(rows=[[*r[:3], "" if k % 10 else r[3], *r[4:]] for k, r in enumerate(ROWS)]),
                       "cells without a value (q3_m 36): 36 rows are left out, fewer than 30 are left; log all"),
    "blanks": (text().replace(",", " "), "row 1: column t_s is missing in the header; separate columns by commas"),
    "time without a unit": (renamed(t_s="time"), "column t_s is missing in the header; name 'time' with its unit"),
    "unit between brackets": (renamed(q1_m="q1 [ell]"), "row 1: column q1 [ell]: 'ell' is no known unit; convert it"),
    "two decimal marks": (cell(4, "q1_m", '"0,01"'), "row 4: '0,01' has a decimal comma, other cells have points;"),
    "decimal comma": (cell(4, "q1_m", "0,01"), "row 4: 11 values for 10 columns, column f3_n; give one value"),
    "row cut": (text(rows=[*ROWS[:3], ROWS[3][:4], *ROWS[4:]]), "row 5: 4 values for 10 columns, column v1_mps"),
    "too short": (text(rows=ROWS[: MIN_SAMPLES - 1]), "row 30, column t_s: only 29 samples; give at least 30"),
    "header alone": (text(rows=[]), "row 1, column t_s: only 0 samples; give at least 30"),
    "comments alone": ("# nothing\n\n", "row 1: no header line"),
    "no header": ("\n".join(map(",".join, ROWS)), "row 1: column t_s is missing in the header; add the time"),
    "time backwards": (cell(6, "t_s", "1"), "row 6, column t_s: time runs backwards; sort the rows"),
    "all rows alike": (text(rows=[ROWS[0]] * 40), "all 40 rows are alike; log holds at several poses"),
    "column twice": (renamed(q2_m="q1_m"), "row 1: column 'q1_m' appears twice; keep one"),
    "two units of one axis": (renamed(q2_m="q1_rad"), "row 1: column q1_rad: axis 1 has two columns of this kind"),
    "axis left out": (renamed(q3_m="q4_m"), "row 1: column q3_m is missing in the header; axes are 1..3"),
    "velocity left out": (renamed(v3_mps="speed"), "row 1: column v3_mps is missing in the header"),
    "effort left out": (renamed(f2_n="force"), "row 1: column f2_n is missing in the header"),
    "prediction left out": (added(["fm1_n", "fm3_n"], ["1", "1"]), "row 1: column fm2_n is missing in the header"),
    "no position": (only("t_s", "f1_n"), "row 1: column q1_m or q1_rad is missing in the header"),
    "no effort": (only(*HEADER[:7]), "row 1: no effort; give one of column f1_n, f1_nm or i1_a"),
    "two efforts": (added(["i1_a", "i2_a", "i3_a"], ["1"] * 3), "row 1: two kinds of effort; give one of column f1_n"),
    "effort of more axes": (added(["f4_n"], ["1"]), "row 1: column f4_n has no position column; add q4_m"),
    "efforts in two units": (renamed(f3_n="f3_nm"), "row 1: column f3_nm: "),
    "effort zero": (text(rows=[[*row[:7], "0", "0", "0"] for row in ROWS]), "columns f1_n, f2_n, f3_n are zero"),
    "effort in Nm": (renamed(f1_n="f1_nm", f2_n="f2_nm", f3_n="f3_nm"),
                     "has it in N; add fm columns or give that unit"),
    "prediction in Nm": (added(["fm1_nm", "fm2_nm", "fm3_nm"], ["1"] * 3), "row 1: column fm1_nm is in Nm, the effort"),
    "angles": (only("t_s", "q1_m", "q2_m", "q3_m", "f1_n", "f2_n", "f3_n", q1_m="q1_rad", q2_m="q2_rad", q3_m="q3_rad"),
               "row 1: columns q1_rad, q2_rad, q3_rad without fm columns, but "),
    "two axes": (only("t_s", "q1_m", "q2_m", "f1_n", "f2_n"), "row 1: columns q1_m, q2_m without fm columns, but "),
    "velocity of an angle": (renamed(v3_mps="v3_radps"), "row 1: column v3_radps doesn't go with q3_m; give v3_mps"),
    "unit misspelt": (renamed(v1_mps="v1_ms"), "row 1: column v1_ms is not known; name it v1_mps or v1_radps"),
    "capital": (added(["temp_C"], ["20"]), "row 1: column temp_C is not known; name it temp_c, or delete it"),
    "axis 0": (renamed(q1_m="q0_m"), "row 1: column q0_m is not known; name it q1_m or q1_rad"),
    "millimetres": (text(rows=[[*row[:3], "50", *row[4:]] for row in ROWS]), "row 2, columns q1_m..q3_m: outside"),
    "singular pose": (cell(11, "q2_m", "0.25"), "row 11, columns q1_m..q3_m: outside the robot's joint space; check"),
    "not text": (b"\x89PNG\r\n\x1a\n\x00\x00", "cannot be read as text; give a CSV text file"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line_with_file_row_column_and_remedy(case, tmp_path):
    content, told = BAD[case]
    with pytest.raises(InputError, match=re.escape(told)) as caught:
        read(tmp_path, content)
    message = str(caught.value)
    assert message.startswith(f"{tmp_path / 'log.csv'}: ")
    assert "\n" not in message
    assert ";" in message  # what is wrong; what to do


@pytest.mark.parametrize("name", ["absent.csv", "."])
def test_file_that_cannot_be_opened_is_named(name, tmp_path):
    with pytest.raises(InputError, match=r"cannot be read.*; give a CSV text file") as caught:
        read_measurement(tmp_path / name, MACHINE)
    assert str(tmp_path / name) in str(caught.value)


def test_rows_are_counted_with_comments_and_empty_lines(tmp_path):
    lines = cell(5, "q2_m", "?").splitlines()
    with pytest.raises(InputError, match="row 8, column q2_m"):
        read(tmp_path, "\n".join(["# robot", "", *lines[:3], "# pause", *lines[3:]]))


@pytest.mark.parametrize("change", [
    lambda s: s, lambda s: "\ufeff" + s, lambda s: s.replace("\n", "\r\n"), lambda s: "# note\n" + s + "\n# end\n\n",
    lambda s: s.replace(",", " , "), lambda s: "\n".join(f"{line},{k}" for k, line in enumerate(s.splitlines())),
], ids=["plain", "byte order mark", "Windows", "comments", "spaces", "column of another name"])  # fmt: skip
def test_columns_arrive_in_their_places(change, tmp_path):
    data = read(tmp_path, change(text()))
    for given, wanted in ((data.t_s, DATA.t_s), (data.q, DATA.q), (data.v, DATA.v), (data.force, DATA.force)):
        np.testing.assert_allclose(given, wanted, rtol=1e-8)
    np.testing.assert_allclose(data.nominal, DATA.nominal, atol=1e-5)
    assert (data.unit, data.position_units, data.temp_c) == ("N", ("m", "m", "m"), None)


def test_columns_may_stand_in_any_order(tmp_path):
    order = np.random.default_rng(3).permutation(len(HEADER))
    data = read(tmp_path, text([HEADER[j] for j in order], [[row[j] for j in order] for row in ROWS]))
    np.testing.assert_allclose(np.c_[data.t_s, data.q, data.v, data.force], np.array(ROWS, float))


def test_amperes_become_newtons_by_the_thrust_constant(tmp_path):
    data = read(tmp_path, renamed(f1_n="i1_a", f2_n="i2_a", f3_n="i3_a"))
    np.testing.assert_allclose(data.force, 45.0 * DATA.force, rtol=1e-8)
    assert data.unit == "N"


@pytest.mark.parametrize(("effort", "model", "unit", "gains"), [
    ("f1_n", "fm1_n", "N", (1, 1)), ("f1_nm", "fm1_nm", "Nm", (1, 1)), ("i1_a", "fm1_a", "A", (1, 1)),
    ("i1_a", "fm1_nm", "Nm", (40, 1)), ("f1_nm", "fm1_a", "Nm", (1, 40)),
])  # fmt: skip
def test_users_own_model_is_compared_in_one_unit(effort, model, unit, gains, tmp_path):
    path, rows = tmp_path / "log.csv", [[*row[:2], row[7], row[8]] for row in ROWS]
    path.write_text(text(["t_s", "q1_rad", effort, model], rows))
    data = read_measurement(path, parse_machine(arm_toml(1), "arm"))
    np.testing.assert_allclose(data.force[:, 0], gains[0] * DATA.force[:, 0], rtol=1e-8)
    np.testing.assert_allclose(data.nominal[:, 0], gains[1] * DATA.force[:, 1], rtol=1e-8)
    assert (data.unit, data.position_units, data.robot) == (unit, ("rad",), None)


def test_amperes_need_the_machine(tmp_path):
    path, rows = tmp_path / "log.csv", [[*row[:2], row[7], row[8]] for row in ROWS]
    path.write_text(text(["t_s", "q1_rad", "i1_a", "fm1_nm"], rows))
    with pytest.raises(InputError, match=r"row 1: column i1_a is in amperes; give the machine folder with --robot"):
        read_measurement(path)


def test_a_log_without_a_model_needs_the_machine(tmp_path):
    (tmp_path / "log.csv").write_text(text())
    with pytest.raises(InputError, match=r"without fm columns; add fm1_.* or give the machine folder with --robot"):
        read_measurement(tmp_path / "log.csv")


def test_velocity_of_a_motion_follows_from_its_positions_and_that_of_holds_is_unknown(tmp_path):
    moved = motion(400)
    rows = [[f"{x:.9g}" for x in row] for row in np.column_stack([moved.t_s, moved.q, moved.force])]
    found = read(tmp_path, text([HEADER[j] for j in (0, 1, 2, 3, 7, 8, 9)], rows)).v
    np.testing.assert_allclose(found[10:-10], moved.v[10:-10], atol=0.01 * MOTION_M * MOTION_RAD_PER_S.max())
    assert read(tmp_path, only("t_s", "q1_m", "q2_m", "q3_m", "f1_n", "f2_n", "f3_n")).v is None


def test_log_of_a_single_pose_has_a_model_of_positions(tmp_path):
    data = read(tmp_path, text(rows=[[row[0], *ROWS[0][1:4], *row[4:]] for row in ROWS]))
    assert np.isfinite(data.sensitivity).all()
