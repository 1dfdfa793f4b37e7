"""The declaration of a VHDL entity: generics, ports, and the comments above them."""

import re
import tempfile
from dataclasses import dataclass
from pathlib import Path

from gravcomp.errors import InputError
from gravcomp_lab.synthesis.verilog import rtl_sources, source_of, to_verilog


@dataclass(frozen=True)
class Generic:
    """kind: its VHDL type. default: as VHDL writes it, without underscores. description: the comment right above."""

    name: str
    kind: str
    default: str
    description: str


@dataclass(frozen=True)
class Port:
    """direction: in or out. kind: its VHDL type, without range. bits: None for a scalar."""

    name: str
    direction: str
    kind: str
    bits: int | None
    description: str


@dataclass(frozen=True)
class Entity:
    """Generics and ports in the order of the declaration; description: the first line of the file's header."""

    name: str
    description: str
    generics: tuple[Generic, ...]
    ports: tuple[Port, ...]


def read_entity(rtl: Path, name: str) -> Entity:
    """The entity that rtl/sources.f lists, its ranges evaluated by GHDL. Raises InputError when it cannot be read."""
    text = source_of(rtl, name).read_text()
    declared = text.partition("\narchitecture ")[0]
    bits = _port_bits(rtl, name, declared)
    generics = _declarations(name, _clause(declared, "generic"), r"(\w+) *:= *(\w+)")
    ports = _declarations(name, _clause(declared, "port"), r"(in|out) +(\w+)(\(?)")
    return Entity(
        name,
        re.search(r"^-- ((?!SPDX).*)", text, re.M)[1],
        tuple(Generic(name, kind, default.replace("_", ""), remark) for name, kind, default, remark in generics),
        tuple(
            Port(name, direction, kind, bits[name] if is_vector else None, remark)
            for name, direction, kind, is_vector, remark in ports
        ),
    )


def _clause(declared: str, keyword: str) -> str:
    found = re.search(rf"^  {keyword} \((.*?)^  \);", declared, re.M | re.S)
    return found[1] if found else ""


def _declarations(entity: str, clause: str, pattern: str) -> list[tuple[str, ...]]:
    """Name, groups of the pattern after the colon, and the comment above, of each declaration."""
    found, remarks = [], []
    for line in clause.splitlines():
        if remark := re.match(r" *-- (.*)", line):
            remarks.append(remark[1])
        elif declaration := re.match(rf" *(\w+) *: *{pattern}", line):
            found.append((*declaration.groups(), " ".join(remarks)))
            remarks = []
        elif line.strip():
            raise InputError(f"{entity}: cannot read {line.strip()!r}; write each generic and port on one line")
    return found


def _port_bits(rtl: Path, name: str, declared: str) -> dict[str, int]:
    """Bits of each port with the default generics, from the Verilog of the entity without its contents.

    Needs only the packages (*_pkg.vhd): what the entity contains need not compile yet.
    """
    with tempfile.TemporaryDirectory() as folder:
        shell = Path(folder) / f"{name}.vhd"
        shell.write_text(f"{declared}\narchitecture shell of {name} is\nbegin\nend architecture shell;\n")
        packages = [path for path in rtl_sources(rtl) if path.stem.endswith("_pkg")]
        verilog = to_verilog([*packages, shell], name, {}, shell.with_suffix(".v")).read_text()
    found = re.findall(r"(?:input|output) +(?:\[(\d+):0\] )?(\w+)", verilog)
    return {port: int(left or 0) + 1 for left, port in found}
