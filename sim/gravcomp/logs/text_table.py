"""Tables as text, as people's tools write them: any usual encoding, separator, decimal mark; lines before the header.

The header is the first line that has a column of time and one of a position; what stands before it is left aside. A
line of units may follow it.
"""

import codecs
import csv
import re
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from gravcomp.errors import InputError
from gravcomp.logs.headers import Column, column, is_unit_row

_SEPARATORS = ",;\t|"
_HEADER_WITHIN = 200  # lines: no scope writes a longer preface
_BYTE_ORDER_MARKS = {codecs.BOM_UTF8: "utf-8", codecs.BOM_UTF16_LE: "utf-16-le", codecs.BOM_UTF16_BE: "utf-16-be"}
_CONTROL = re.compile(r"[\x00-\x08\x0e-\x1f]")
_COMMENT = re.compile(r"[\s\"]*#(?!N/A)")
_MISSING = {"", "nan", "na", "n/a", "#n/a", "null", "none", "-", "--", "1.#qnan", "-nan", "nan(ind)", "-nan(ind)"}
_DATE = re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d")
_WITH_COMMA = re.compile(r"[+-]?\d*,\d+(?:[eE][+-]?\d+)?")
_WITH_POINT = re.compile(r"[+-]?\d*\.\d+(?:[eE][+-]?\d+)?")
_IMPORTED = {".mat": "mat", ".mcap": "mcap", ".db3": "rosbag", ".tdms": "tdms", ".mf4": "mdf", ".mdf": "mdf",
             ".dat": "mdf", ".parquet": "parquet"}  # fmt: skip


@dataclass(frozen=True)
class TextTable:
    """cells[k][j] of row rows[k] of the file and column j; notes: what reading had to put right, a line each."""

    columns: list[Column]
    cells: list[list[str]]
    rows: list[int]
    header_row: int
    notes: list[str]


def read_text_table(path: Path) -> TextTable:
    """The table in a text file. Raises InputError naming file, row, column and what to do."""
    text, notes = _decoded(path)
    lines = [(row, line) for row, line in enumerate(re.split(r"\r\n|\r|\n", text), 1)
             if line.strip(' \t,;|"') and not _COMMENT.match(line)]  # fmt: skip
    if not lines:
        raise InputError(f"{path}: row 1: no header line; give t_s, q1_m, ... and one row per sample")
    start, separator = _header(lines)
    if start:
        notes.append(f"{start} lines before the header in row {lines[start][0]} are left aside")
    header_row, names = lines[start][0], _split(lines[start][1], separator)
    body = [(row, _split(line, separator)) for row, line in lines[start + 1 :]]
    units = [""] * len(names)
    if body and len(body[0][1]) == len(names) and is_unit_row(names, body[0][1]):
        row, units = body.pop(0)
        notes.append(f"row {row} tells the units")
    if not names[-1] and len(names) > 1:
        names, units = names[:-1], units[:-1]
    columns = [column(name, unit, f"{path}: row {header_row}") for name, unit in zip(names, units, strict=True)]
    cells, rows = [_of_width(path, row, parts, columns) for row, parts in body], [row for row, _ in body]
    cells, told = _with_decimal_points(path, cells, rows)
    columns, cells, dated = _with_seconds(path, columns, cells, rows)
    _check_header(f"{path}: row {header_row}", columns, lines[start][1])
    return TextTable(columns, cells, rows, header_row, notes + told + dated)


def is_missing(cell: str) -> bool:
    """Does a cell say that it has no value?"""
    return cell.lower() in _MISSING


def _decoded(path: Path) -> tuple[str, list[str]]:
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); give a CSV text file") from error
    mark, encoding = next(((m, e) for m, e in _BYTE_ORDER_MARKS.items() if data.startswith(m)), (b"", ""))
    data = data[len(mark) :]
    if not encoding:
        zeros = [half.count(0) / max(len(half), 1) for half in (data[1:2000:2], data[0:2000:2])]
        encoding = "utf-16-le" if zeros[0] > 0.5 else "utf-16-be" if zeros[1] > 0.5 else "utf-8"
    try:
        text = data.decode(encoding)
    except UnicodeDecodeError:
        encoding, text = "latin-1", data.decode("latin-1")
    if _CONTROL.search(text):
        kind = _IMPORTED.get(path.suffix.lower())
        remedy = f"convert it with gravcomp import {kind}" if kind else "give a CSV text file"
        raise InputError(f"{path}: cannot be read as text; {remedy}")
    return text, [] if encoding == "utf-8" else [f"the file is read as {encoding.upper()}"]


def _header(lines: list[tuple[int, str]]) -> tuple[int, str]:
    """Number of the header line, and the separator; the first line and a comma where none looks like a header."""
    for k, (_, line) in enumerate(lines[:_HEADER_WITHIN]):
        kinds = {separator: [found.kind for found in map(column, _split(line, separator)) if found.kind]
                 for separator in _SEPARATORS}  # fmt: skip
        best = max(_SEPARATORS, key=lambda s: len(kinds[s]))
        if "t" in kinds[best] and {"q", "f", "i"} & {*kinds[best]}:
            return k, best
    return 0, max(_SEPARATORS, key=lambda s: len(_split(lines[0][1], s)))


def _split(line: str, separator: str) -> list[str]:
    if '"' not in line:  # as csv reads it, at a fifth of the time
        return [cell.strip() for cell in line.split(separator)]
    return [cell.strip().strip('"').strip() for cell in next(csv.reader([line], delimiter=separator))]


def _check_header(header: str, columns: list[Column], line: str) -> None:
    names = [found.name for found in columns]
    for found in columns:
        if names.count(found.name) > 1:
            raise InputError(f"{header}: column {found.name!r} appears twice; keep one")
    if any(found.kind == "t" and not found.should_be for found in columns):
        return
    bare = next((found.original for found in columns if found.kind == "t"), "")
    hint = "separate columns by commas" if len(columns) == 1 and " " in line.strip() else "add the time in seconds"
    hint = f"name {bare!r} with its unit, t_s or t_ms" if bare else hint
    raise InputError(f"{header}: column t_s is missing in the header; {hint}")


def _of_width(path: Path, row: int, parts: list[str], columns: list[Column]) -> list[str]:
    """One cell per column; a separator that ends the line adds none."""
    n = len(columns)
    while len(parts) > n and not parts[-1]:
        parts = parts[:-1]
    if len(parts) != n:
        comma = ", or semicolons between the columns where the decimal mark is a comma" if len(parts) > n else ""
        raise InputError(f"{path}: row {row}: {len(parts)} values for {n} columns, column "
                         f"{columns[min(len(parts), n - 1)].name}; give one value per column{comma}")  # fmt: skip
    return parts


def _with_seconds(path: Path, columns: list[Column], cells: list[list[str]], rows: list[int]):
    """Columns and cells with seconds since the first row where the time is written as dates, and a word on it."""
    j = next((j for j, found in enumerate(columns) if found.kind == "t"), None)
    if j is None or not cells or not _DATE.match(cells[0][j]):
        return columns, cells, []
    own = columns[j]
    dates = pd.to_datetime([x[j].replace(",", ".") for x in cells], format="ISO8601", utc=True, errors="coerce")
    if dates.isna().any():
        k = int(dates.isna().argmax())
        raise InputError(f"{path}: row {rows[k]}, column {own.original}: {cells[k][j]!r} is no date as in the first "
                         "row; correct or delete that row")  # fmt: skip
    seconds = (dates - dates[0]).total_seconds()
    cells = [[*x[:j], repr(float(s)), *x[j + 1 :]] for x, s in zip(cells, seconds, strict=True)]
    columns = [*columns[:j], Column(own.original, "t_s", "t"), *columns[j + 1 :]]
    return columns, cells, [f"{own.original} holds dates: seconds since the first row are used"]


def _with_decimal_points(path: Path, cells: list[list[str]], rows: list[int]) -> tuple[list[list[str]], list[str]]:
    """Cells with decimal points where the file has commas, and a word on it."""
    with_comma = next(
        ((k, j) for k, row in enumerate(cells) for j, x in enumerate(row) if "," in x and _WITH_COMMA.fullmatch(x)),
        None,
    )
    if with_comma is None:
        return cells, []
    if any(_WITH_POINT.fullmatch(x) for row in cells for x in row):
        k, j = with_comma
        raise InputError(f"{path}: row {rows[k]}: {cells[k][j]!r} has a decimal comma, other cells have points; "
                         "write all numbers with one decimal mark")  # fmt: skip
    return [[x.replace(",", ".") if _WITH_COMMA.fullmatch(x) else x for x in row] for row in cells], [
        "decimal commas are read as points"
    ]
