"""Files as people's tools write them give the same input to the diagnosis as the measured CSV of the same numbers."""

import re

import numpy as np
import pytest

from arm import arm_toml
from gravcomp.cli import main
from gravcomp.errors import InputError
from gravcomp.logs.csv_reader import read_measurement
from gravcomp.logs.units import parse_units, unit_of_symbol
from gravcomp.robot.machine import parse_machine

N = 60
T = 0.05 * np.arange(N)
Q, V = np.sin(T), np.cos(T)
EFFORT, MODEL = 8.0 * np.cos(Q) + 0.5, 8.0 * np.cos(Q)
CONTRACT = ["t_s", "q1_rad", "v1_radps", "f1_nm", "fm1_nm"]
VALUES = np.column_stack([T, Q, V, EFFORT, MODEL])


def written(header=CONTRACT, values=VALUES, separator=",", comma=False, quoted=False, before="", units=None) -> str:
    def line(cells):
        return separator.join(f'"{cell}"' if quoted else cell for cell in cells)

    rows = [[f"{x:.12g}".replace(".", "," if comma else ".") for x in row] for row in values]
    return before + "\n".join(line(cells) for cells in [header, *([units] if units else []), *rows]) + "\n"


def read(tmp_path, content: str | bytes, **options):
    path = tmp_path / "log.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_measurement(path, **options)


def in_degrees(header, **options) -> str:
    return written(header, VALUES * [1e3, 180 / np.pi, 180 / np.pi, 1e3, 1.0], **options)


def dated(separator=",", mark=".") -> str:
    """The same with the time as dates, as loggers write it."""
    lines = written(["timestamp", *CONTRACT[1:]], separator=separator, comma=mark == ",").splitlines()
    stamps = [str(np.datetime64("2026-03-29T00:59:58.500") + np.timedelta64(round(1e3 * t), "ms")) for t in T]
    rows = [[stamp.replace("T", " ").replace(".", mark), *line.split(separator)[1:]]
            for stamp, line in zip(stamps, lines[1:], strict=True)]  # fmt: skip
    return "\n".join([lines[0], *(separator.join(row) for row in rows)]) + "\n"


SCOPE = "Scope project;AX1\nFile name;run 3\nSample time [ms];50\n\n"
BRACKETS = ["time [ms]", "Position 1 [°]", "Velocity 1 [°/s]", "Torque 1 [mNm]", "fm1 (N·m)"]
FILES = {
    "semicolons": written(separator=";"),
    "tabs": written(separator="\t"),
    "decimal commas": written(separator=";", comma=True),
    "decimal commas within quotes": written(comma=True, quoted=True),
    "quoted": written(quoted=True),
    "scope": in_degrees(BRACKETS, separator=";", comma=True, before=SCOPE),
    "brackets": in_degrees(BRACKETS),
    "row of units": in_degrees(["t", "q1", "v1", "f1", "fm1"], units=["ms", "deg", "deg/s", "mNm", "Nm"]),
    "row of units in brackets": written(["time", "q1", "v1", "f1", "fm1"], separator=";", comma=True,
                                        units=["[s]", "[rad]", "[rad/s]", "[Nm]", "[Nm]"]),
    "row of units that says the same": written(units=["s", "rad", "rad/s", "Nm", "Nm"]),
    "unit after a stroke": written(["t / s", "q1 / rad", "v1 / rad/s", "f1 / Nm", "fm1 in Nm"]),
    "revolutions": written(["t_s", "q1_rev", "v1_rpm", "f1_nm", "fm1_nm"], VALUES * [1, 0.5 / np.pi, 30 / np.pi, 1, 1]),
    "separator at the end": written().replace("\n", ",\n"),
    "line of separators": written() + ",,,,\n",
    "UTF-16": written().encode("utf-16"),
    "UTF-16 without a mark": written().encode("utf-16-be"),
    "Latin-1": in_degrees(BRACKETS, separator=";").encode("latin-1"),
    "dates": dated(),
    "dates with decimal commas": dated(";", ","),
    "old Macintosh": written().replace("\n", "\r"),
}  # fmt: skip


@pytest.mark.parametrize("name", FILES)
def test_file_gives_the_same_input_as_the_measured_csv(name, tmp_path):
    data, same = read(tmp_path, FILES[name]), read(tmp_path, written())
    for given, wanted in ((data.t_s, T), (data.q[:, 0], Q), (data.v[:, 0], V), (data.force[:, 0], EFFORT)):
        np.testing.assert_allclose(given, wanted, rtol=1e-10, atol=1e-11)
    np.testing.assert_allclose(data.nominal[:, 0], MODEL, rtol=1e-10)
    assert (data.unit, data.position_units, data.n_dropped) == (same.unit, same.position_units, 0)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("scope", ("3 lines before the header in row 5", "decimal commas", "Position 1 [°]: deg converted")),
        ("row of units", ("row 2 tells the units", "ms converted to s, factor 0.001", "mnm converted to nm")),
        ("UTF-16", ("UTF-16-LE",)),
        ("Latin-1", ("LATIN-1",)),
        ("revolutions", ("q1_rev: rev converted to rad, factor 6.28319",)),
    ],
)
def test_what_was_put_right_is_said(name, words, tmp_path):
    notes = "\n".join(read(tmp_path, FILES[name]).notes)
    assert [word for word in words if word not in notes] == []


def test_plain_file_needs_no_word(tmp_path):
    assert read(tmp_path, written()).notes == ()


@pytest.mark.parametrize("cell", ["", "NaN", "n/a", "null", "-", "#N/A"])
def test_cells_without_a_value_are_left_out_and_counted(cell, tmp_path):
    lines = written().splitlines()
    for row, column in ((4, 1), (9, 3), (9, 4), (30, 0)):
        cells = lines[row].split(",")
        lines[row] = ",".join([*cells[:column], cell, *cells[column + 1 :]])
    data = read(tmp_path, "\n".join(lines))
    kept = np.delete(np.arange(N), [3, 8, 29])
    np.testing.assert_allclose(data.q[:, 0], Q[kept], rtol=1e-10, atol=1e-11)
    assert data.n_dropped == 3
    assert any("(t_s 1, q1_rad 1, f1_nm 1, fm1_nm 1): 3 rows are left out" in note for note in data.notes)


def test_column_without_any_value_is_none(tmp_path):
    lines = [line.split(",") for line in written().splitlines()]
    rows = [",".join([*cells[:2], "", *cells[3:], ""]) for cells in lines[1:]]
    data = read(tmp_path, "\n".join([",".join([*CONTRACT, "temp_c"]), *rows]))
    assert data.temp_c is None
    np.testing.assert_allclose(data.v[5:-5, 0], V[5:-5], atol=0.01)  # from the positions, as without the column
    assert {"v1_radps has no value in any row: left aside", "temp_c has no value in any row: left aside"} <= {
        *data.notes
    }


def test_slow_temperature_costs_no_rows(tmp_path):
    lines = written().splitlines()
    rows = [f"{line},{20 + k / 10 if k % 10 == 0 else ''}" for k, line in enumerate(lines[1:])]
    data = read(tmp_path, "\n".join([f"{lines[0]},temp_c", *rows]))
    assert data.n_dropped == 0
    np.testing.assert_allclose(data.temp_c[:51], 20 + 0.1 * np.arange(51))


def test_row_of_units_that_contradicts_the_header_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"column q1_rad: the row of units says deg; keep one of the two"):
        read(tmp_path, written(units=["s", "deg", "rad/s", "Nm", "Nm"]))


def test_date_that_is_none_is_named(tmp_path):
    lines = dated().splitlines()
    lines[7] = "2026-13-40 00:00:00" + lines[7][lines[7].index(",") :]
    with pytest.raises(InputError, match=r"row 8, column timestamp: '2026-13-40 00:00:00' is no date"):
        read(tmp_path, "\n".join(lines))


def test_column_whose_unit_is_missing_is_named(tmp_path):
    with pytest.raises(InputError, match=r"column q1_m or q1_rad is missing in the header; name 'q1' with its unit"):
        read(tmp_path, written(["t_s", "q1", "v1", "f1_nm", "fm1_nm"]))


TWO = ["t_s", "q1_rad", "q2_m", "i1_a", "i2_a", "fm1_nm", "fm2_n"]
TWO_VALUES = np.column_stack([T, Q, 0.1 * Q, EFFORT / 4.0, EFFORT / 20.0, EFFORT, EFFORT])


@pytest.mark.parametrize("sizes", [["a1=4nm", "a2=20n"], ["a=20n", "a1=4nm"]])
def test_amperes_beside_newtons_and_newton_metres_take_the_constant_of_their_axis(sizes, tmp_path):
    data = read(tmp_path, written(TWO, TWO_VALUES), units=parse_units(sizes))
    np.testing.assert_allclose(data.force, data.nominal, rtol=1e-10)
    assert (data.effort_units, data.position_units) == (("Nm", "N"), ("rad", "m"))


def test_amperes_of_two_axes_take_the_constants_of_the_machine(tmp_path):
    machine = parse_machine(arm_toml(2), "arm")
    header = ["t_s", "q1_rad", "q2_rad", "i1_a", "i2_a", "fm1_nm", "fm2_nm"]
    data = read(tmp_path, written(header, TWO_VALUES), machine=machine)
    np.testing.assert_allclose(data.force, TWO_VALUES[:, 3:5] * [40.0, 20.0], rtol=1e-10)


def test_amperes_without_a_constant_ask_for_it(tmp_path):
    with pytest.raises(InputError, match=r"column i1_a is in amperes; give .*--robot, the size with --units a=0.1nm"):
        read(tmp_path, written(TWO, TWO_VALUES))


@pytest.mark.parametrize(
    ("symbol", "unit"),
    [("N·m", "nm"), ("N m", "nm"), ("mNm", "mnm"), ("MNm", None), ("kN", "kn"), ("1/min", "rpm"), ("U/min", "rpm"),
     ("°/s", "degps"), ("mm/s", "mmps"), ("MM", "mm"), ("m/min", "mpmin"), ("µm", "um"), ("μs", "us"),
     ("rad/s", "radps"), ("m s^-1", "mps"), ("°C", "c"), ("[A]", "a"), ("furlong", None), ("", None), ("M", "m")],
)  # fmt: skip
def test_symbols_of_units_are_known(symbol, unit):
    assert unit_of_symbol(symbol) == unit


@pytest.mark.parametrize("pair", ["a=0.1m", "a0=1n", "b=1n", "permille2=n", "counts=0m", "a1"])
def test_size_that_is_none_is_refused(pair):
    with pytest.raises(InputError, match=re.escape(f"--units {pair}: not NAME=FACTOR and unit")):
        parse_units([pair])


@pytest.mark.parametrize(("name", "kind"), [("log.mat", "mat"), ("log.mf4", "mdf"), ("log.parquet", "parquet")])
def test_binary_log_is_sent_to_its_importer(name, kind, tmp_path, capsys):
    (tmp_path / name).write_bytes(b"PAR1\x00\x01\x02")
    assert main(["diagnose", str(tmp_path / name), "--out", str(tmp_path / "out")]) == 2
    assert f"convert it with gravcomp import {kind}" in capsys.readouterr().err
