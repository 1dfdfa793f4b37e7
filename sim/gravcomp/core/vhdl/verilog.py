"""VHDL to Verilog with GHDL's synthesis, and the repair of what GHDL 2.0.0 writes wrongly."""

import re
import subprocess
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from gravcomp.errors import InputError
from gravcomp.files import write_atomically


def rtl_sources(rtl: Path, generated: Path | None = None) -> list[Path]:
    """The VHDL files of rtl/sources.f, in compile order; InputError when there is none. generated: folder of another
    machine's packages, to be taken instead of those in rtl.
    """
    try:
        names = (rtl / "sources.f").read_text().split()
    except OSError:
        raise InputError(f"{rtl}: no sources.f; give the folder of the RTL") from None
    made = {} if generated is None else {name: generated / Path(name).name for name in names if _is_generated(name)}
    return [made.get(name, rtl / name) for name in names]


def _is_generated(name: str) -> bool:
    return name.startswith("generated/")


def to_verilog(sources: Sequence[Path], top: str, generics: Mapping[str, int | str], out: Path) -> Path:
    """Write the Verilog of entity top with its generics set to the file out; returns out.

    Raises InputError when GHDL refuses, or when its Verilog holds something that repair does not know to be right.
    """
    with analysed(sources) as library:
        return synthesised(library, top, generics, out)


@contextmanager
def analysed(sources: Sequence[Path]) -> Iterator[str]:
    """A folder with GHDL's library of these files, for any number of tops; InputError when GHDL refuses."""
    with tempfile.TemporaryDirectory() as library:
        _ghdl(["-a", "--std=08", f"--workdir={library}", *(str(path.resolve()) for path in sources)], library)
        yield library


def synthesised(library: str, top: str, generics: Mapping[str, int | str], out: Path) -> Path:
    """As of to_verilog, of a library that is analysed."""
    settings = [f"-g{name}={value}" for name, value in generics.items()]
    text = _ghdl(["--synth", "--std=08", f"--workdir={library}", "--out=verilog", *settings, top], library)
    write_atomically(out, repair(text))
    return out


def repair(verilog: str) -> str:
    """GHDL 2.0.0's Verilog with its three known faults mended; InputError for what would be silently wrong.

    Constants wider than 32 bits are written as strings, which Verilog reads as ASCII. An arithmetic shift is written as
    a logical one, which loses the sign. A signed product is written as one of sign-extended operands, which costs three
    DSP blocks for one. Operators that Verilog lacks come out as VHDL text, a case without default would be a latch:
    neither is mended, the VHDL must avoid them.
    """
    code = re.sub(r"/\*.*?\*/", "", verilog, flags=re.DOTALL)
    code = re.sub(r'"([01]{33,})"', lambda found: f"{len(found[1])}'b{found[1]}", code)
    code = re.sub(r"(\$signed\(\w+\)) >> ", r"\1 >>> ", code)
    code = _signed_products(code)
    statements = _without_full_cases(re.sub(r"//.*", "", code))
    for pattern, what in (
        (r'".*?"', "a string"),
        (r"\b(?:abs|minimum|maximum|mod|rem)\b", "an operator of VHDL"),
        (r"\bcase[xz]?\b(?:(?!\bendcase\b|\bdefault\b).)*\bendcase\b", "a case without default"),
    ):
        if found := re.search(pattern, statements, re.DOTALL):
            raise InputError(f"GHDL wrote {what} into its Verilog, {found[0][:40]!r}; write that VHDL another way")
    return code


def _without_full_cases(code: str) -> str:
    """The code less each case that lists every value of its selector, which is how GHDL reads an array by an index."""

    def replaced(found: re.Match) -> str:
        values = re.findall(r"^\s*(\d+)'b([01]+):", found[0], re.MULTILINE)
        return "" if values and len({value for _, value in values}) == 2 ** int(values[0][0]) else found[0]

    return re.sub(r"\bcase \(.*?\bendcase\b", replaced, code, flags=re.DOTALL)


def _signed_products(code: str) -> str:
    extended = dict(re.findall(r"assign (\w+) = \{\{\d+\{(\w+)\[\d+\]\}\}, \2\}; // sext", code))

    def product(found: re.Match) -> str:
        left, right = found[2], found[3]
        if left not in extended or right not in extended:
            raise InputError(f"GHDL wrote a signed product of unknown form, {found[0]!r}; write that VHDL another way")
        return f"assign {found[1]} = $signed({extended[left]}) * $signed({extended[right]});"

    return re.sub(r"assign (\w+) = (\w+) \* (\w+); // smul", product, code)


def _ghdl(arguments: Sequence[str], folder: str) -> str:
    try:
        done = subprocess.run(["ghdl", *arguments], cwd=folder, capture_output=True, text=True, check=False)
    except FileNotFoundError:
        raise InputError("ghdl: not found; start `make setup`") from None
    if done.returncode:
        message = (done.stderr.strip() or done.stdout.strip() or "no message").splitlines()[0]
        raise InputError(f"ghdl {arguments[0]}: {message}")
    return done.stdout
