"""Branch coverage of the VHDL: every condition seen true and seen false, in any simulator.

A copy of rtl/ in which each condition of an if, an elsif or a when passes through a function that gives it back and
notes what it was, in a file of the simulation's folder. So a branch that is not written, the else of an if without one,
counts as well. Not counted: conditions of generates, and those of functions, which make constants at elaboration. What
is seen before time passes is the start of a simulation, and does not count either.
"""

import os
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from gravcomp.errors import InputError
from gravcomp_lab.mutation.trial import LEFT_OUT
from gravcomp_lab.synthesis.verilog import handwritten_sources

INTRODUCTION = """\
# Branch coverage of the VHDL

Written by `make branches` from the simulations of `tb/test_rtl_*.py`, on a copy of the VHDL in which each condition of
an `if`, an `elsif` and a `when` notes what it was: two branches each, so the `else` that is not written counts, too.
Left out are conditions of `generate` and those in functions, which make constants, and what is only seen before time
passes.
All instances of an entity count together.

"""
SEEN = "branches_seen.txt"
_PACKAGE = """\
use std.textio.all;

package gc_branch_pkg is

  impure function seen (n : natural; condition : boolean) return boolean;

end package gc_branch_pkg;

package body gc_branch_pkg is

  type outcomes_t is array (boolean) of boolean;

  type all_t is array (0 to {last}) of outcomes_t;

  type memory_t is protected

    impure function is_new (n : natural; condition : boolean) return boolean;

  end protected memory_t;

  type memory_t is protected body

    variable noted_v : all_t := (others => (others => false));

    impure function is_new (n : natural; condition : boolean) return boolean is

      variable new_v : boolean;

    begin

      new_v := not noted_v(n)(condition);
      noted_v(n)(condition) := true;
      return new_v;

    end function is_new;

  end protected body memory_t;

  shared variable memory : memory_t;

  impure function seen (n : natural; condition : boolean) return boolean is

    file     list_v : text;
    variable line_v : line;

  begin

    if now > 0 ns then
      if memory.is_new(n, condition) then
        file_open(list_v, "{file}", append_mode);
        write(line_v, integer'image(n) & " " & boolean'image(condition));
        writeline(list_v, line_v);
        file_close(list_v);
      end if;
    end if;

    return condition;

  end function seen;

end package body gc_branch_pkg;
"""
_CONDITIONS = (
    re.compile(r"(?:(?<=\bif )|(?<=\belsif ))([^;]+?)(?= then$)"),
    re.compile(r"(?<= when )([^;]+?)(?= else\b)"),
)


@dataclass(frozen=True)
class Condition:
    """A condition of a file of rtl/: its line number, from 1, and its text."""

    file: str
    line: int
    text: str


def instrument(rtl: Path, out: Path) -> list[Condition]:
    """Copy rtl/ to the folder out, with every condition noted when it is evaluated; returns them by their number."""
    shutil.copytree(rtl, out)
    conditions: list[Condition] = []
    for path in handwritten_sources(out).values():
        text, inside, lines = path.read_text(), False, []
        for number, line in enumerate(text.split("\n"), start=1):
            code = line.split("--")[0].rstrip()
            inside = inside and not re.match(r" *end (function|procedure)\b", code)
            inside = inside or bool(re.match(r" *(function|procedure)\b", code))
            if not inside:
                line = _noted(line, code, path.name, number, conditions)
            lines.append(line)
        path.write_text("\n".join(lines))
    (out / "gc_branch_pkg.vhd").write_text(_PACKAGE.format(last=len(conditions) - 1, file=SEEN))
    sources = out / "sources.f"
    sources.write_text("gc_branch_pkg.vhd\n" + sources.read_text())
    return conditions


def _noted(line: str, code: str, file: str, number: int, conditions: list[Condition]) -> str:
    def note(found: re.Match) -> str:
        conditions.append(Condition(file, number, found[1].strip()))
        return f"work.gc_branch_pkg.seen({len(conditions) - 1}, {found[1].strip()})"

    for pattern in _CONDITIONS:
        if pattern.search(code):
            return pattern.sub(note, code)
    return line


def count(root: Path, build: Path, files: list[str], jobs: int) -> tuple[list[Condition], dict[int, set[bool]]]:
    """Run test files of tb/, all when there are none, on an instrumented copy: conditions, and what each of them was.

    Raises InputError when a test fails.
    """
    shutil.rmtree(build, ignore_errors=True)
    conditions = instrument(root / "rtl", build / "rtl")
    names = files or test_files(root)
    variables = {"GRAVCOMP_RTL": build / "rtl", "GRAVCOMP_BUILD": build, "PYTHONPATH": root / "sim"}
    environment = {**os.environ, **{name: str(path.resolve()) for name, path in variables.items()}}
    command = [sys.executable, "-m", "pytest", "-q", "-n", str(jobs), "-p", "no:cacheprovider", "-k", "not planted"]
    done = subprocess.run([*command, *(str(root / "tb" / name) for name in names)], cwd=root, env=environment,
                          check=False)  # fmt: skip
    if done.returncode:
        raise InputError("a test fails; a coverage without it would not be the tests' coverage")
    seen: dict[int, set[bool]] = {k: set() for k in range(len(conditions))}
    for path in build.rglob(SEEN):
        for line in path.read_text().split("\n"):
            if line:
                number, value = line.split()
                seen[int(number)].add(value == "true")
    return conditions, seen


def reasons(path: Path) -> dict[tuple[str, str, bool], str]:
    """Why a condition never has a value: (file, condition, value) -> reason, from a TOML file."""
    entries = tomllib.loads(path.read_text())["unseen"]
    return {(entry["file"], entry["condition"], entry["value"]): entry["reason"] for entry in entries}


def test_files(root: Path) -> list[str]:
    """The test files of the VHDL whose branches count: all but those that repeat what others test."""
    return sorted(path.name for path in (root / "tb").glob("test_rtl_*.py") if path.name not in LEFT_OUT)


def markdown(
    conditions: list[Condition],
    seen: dict[int, set[bool]],
    why: dict[tuple[str, str, bool], str],
    not_run: Sequence[str] = (),
) -> str:
    """Two tables: branches by file, and every branch not taken, with its reason; test files that did not run."""
    rows = []
    for file in [*dict.fromkeys(c.file for c in conditions), "all"]:
        of_file = [k for k, c in enumerate(conditions) if file in (c.file, "all")]
        n, n_seen = 2 * len(of_file), sum(len(seen[k]) for k in of_file)
        rows.append(f"| {file} | {n} | {n - n_seen} | {100 * n_seen / n:.1f} % |")
    lines = ["| file | branches | never taken | coverage |", "|---|---|---|---|", *rows]
    missed = [(c, value) for k, c in enumerate(conditions) for value in (True, False) if value not in seen[k]]
    if missed:
        lines += ["", "| never | condition | was | why |", "|---|---|---|---|"]
    for c, value in missed:
        reason = why.get((c.file, c.text, value), "**not explained**")
        lines.append(f"| {c.file}:{c.line} | `{c.text}` | {str(value).lower()} | {reason} |")
    if not_run:
        lines += ["", f"Not run for this page: {', '.join(f'`{name}`' for name in not_run)}."]
    return INTRODUCTION + "\n".join(lines) + "\n"
