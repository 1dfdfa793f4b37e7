"""Every register and memory of a design, found in the Verilog that GHDL wrote for it."""

import re
from collections.abc import Iterable
from dataclasses import dataclass

from gravcomp.errors import InputError

_MODULE = re.compile(r"^module (\w+)\n(.*?)^endmodule", re.DOTALL | re.MULTILINE)
_CLOCKED = re.compile(r"always @\(posedge \w+\)\n((?:.*(?:<=|if \().*\n)+)")
_ASSIGNED = re.compile(r"(\w+)(\[[^\]]+\])? <=")
_REG = re.compile(r"^  reg (?:\[(\d+):0\] )?(\w+)(?:\[(\d+):0\] )?;.*\n", re.MULTILINE)
_ALIAS = re.compile(r"^ +(?:assign )?(\w+) = (\w+);", re.MULTILINE)
_READ = re.compile(r"(\w+)\[(\w+)\];")
_INSTANCE = re.compile(r"^  (\w+) (\w+) \(\n", re.MULTILINE)
_PUBLIC = "/*verilator public_flat_rd*/"


@dataclass(frozen=True)
class Store:
    """A register (depth 0) or a memory of depth words, bits wide, in one instance.

    path: instances from the top's down; variable: its name in the Verilog; name: what the VHDL calls it, where that is
    known. addresses: the signals that a memory is read with.
    """

    path: tuple[str, ...]
    entity: str
    variable: str
    name: str
    bits: int
    depth: int
    addresses: tuple[str, ...]

    @property
    def instance(self) -> str:
        return ".".join(self.path)

    def member(self, signal: str) -> str:
        """Name of a signal beside it in the program that Verilator writes."""
        return "__DOT__".join((*self.path, signal))


def find_state(verilog: str, top: str, entities: Iterable[str]) -> list[Store]:
    """All state of the design, instance by instance from the top down.

    entities: names in the VHDL; GHDL appends generics to them. Raises InputError for a module that is none of them, and
    when the Verilog holds something clocked that is understood neither as register nor as memory.
    """
    modules = dict(_MODULE.findall(verilog))
    stores = {name: _stores(name, body) for name, body in modules.items()}
    inside = {name: _instances(body, modules) for name, body in modules.items()}
    known = sorted(entities, key=len, reverse=True)

    def walk(module: str, path: tuple[str, ...]) -> Iterable[Store]:
        entity = next((name for name in known if re.fullmatch(rf"{name}(_\w+)?", module)), None)
        if entity is None:
            raise InputError(f"{module}: no entity of rtl/ has this name")
        yield from (Store(path, entity, *store) for store in stores[module])
        for kind, name in inside[module]:
            yield from walk(kind, (*path, name))

    return list(walk(top, (top,)))


def make_public(verilog: str) -> str:
    """The same Verilog, in which Verilator leaves every register, memory and memory's address where it can be found."""

    def module(found: re.Match) -> str:
        body, clocked, read = found[2], _clocked(found[2]), _addresses(found[2])
        signals = clocked | set(read) | {name for names in read.values() for name in names}
        body = re.sub(
            r"^(  (?:reg|wire) (?:\[\d+:0\] )?(\w+)(?:\[\d+:0\] )?)( ?;)",
            lambda line: f"{line[1]} {_PUBLIC}{line[3]}" if line[2] in signals else line[0],
            body,
            flags=re.MULTILINE,
        )
        return f"module {found[1]}\n{body}endmodule"

    return _MODULE.sub(module, verilog)


def _stores(module: str, body: str) -> list[tuple]:
    clocked, read = _clocked(body), _addresses(body)
    aliases = {variable: name for name, variable in reversed(_ALIAS.findall(body))}
    found = [
        (variable, aliases.get(variable, variable), int(high or 0) + 1, int(top) + 1 if top else 0,
         tuple(read.get(variable, ())))
        for high, variable, top in _REG.findall(body)
        if variable in clocked or top
    ]  # fmt: skip
    missing = clocked - {store[0] for store in found}
    if missing:
        raise InputError(f"{module}: clocked, but neither register nor memory: {', '.join(sorted(missing))}")
    return found


def _clocked(body: str) -> set[str]:
    return {name for block in _CLOCKED.findall(body) for name, _ in _ASSIGNED.findall(block)}


def _addresses(body: str) -> dict[str, list[str]]:
    memories = {variable for _, variable, top in _REG.findall(body) if top}
    read = {}
    for memory, address in _READ.findall(body):
        if memory in memories and not address.isdigit():
            read.setdefault(memory, []).append(address)
    return read


def _instances(body: str, modules: dict[str, str]) -> list[tuple[str, str]]:
    return [(kind, name) for kind, name in _INSTANCE.findall(body) if kind in modules]
