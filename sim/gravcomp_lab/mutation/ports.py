"""A fault at every output port of every entity: which claim or test sees it?

The fault inverts the lowest bit of the port (of the first field of a record), all the time; the entity itself goes on
reading the right value. So whatever is asserted about the entity's inside cannot see it, only what is about its port.
"""

import re
import shutil
import tempfile
from collections.abc import Mapping
from dataclasses import astuple, dataclass
from pathlib import Path

from gravcomp.errors import InputError
from gravcomp_lab.formal.claims import CLAIMS, verify
from gravcomp_lab.mutation.kept import Keys, read_lines, write_lines
from gravcomp_lab.mutation.trial import CAUGHT, TIMEOUT, compiles, relevant_tests, run_tests
from gravcomp_lab.synthesis.verilog import rtl_sources, source_of

TIMEOUT_S = 600.0
# Claims that take longer to be shown than a test takes to fail.
_SLOW_CHECKERS = ("hidden_sums", "output_sums")
_SCALARS = ("std_ulogic", "std_logic")
_BY_TEST = "simulation: equality with the twin"
_BY_PROOF = "proof"


@dataclass(frozen=True)
class OutputPort:
    """An output port: its entity, name, type, and default with its assignment sign, or nothing."""

    entity: str
    name: str
    type: str
    default: str = ""


@dataclass(frozen=True)
class Found:
    """What saw the fault of a port: the tool, and assertions of a checker or name of a test; nothing if none did.

    A simulation that does not end says nothing of the port: the tool is then nothing, too, and by is TIMEOUT.
    """

    entity: str
    port: str
    tool: str
    by: str


def output_ports(rtl: Path) -> list[OutputPort]:
    """The output ports of all entities of rtl/sources.f, in its order."""
    return [port for path in rtl_sources(rtl) for port in _ports(path)]


def _ports(path: Path) -> list[OutputPort]:
    text = path.read_text()
    if not (entity := re.search(r"^entity (\w+) is$(.*?)^end\b", text, re.MULTILINE | re.DOTALL)):
        return []
    code = re.sub(r"--.*", "", entity[2])
    pattern = r"(\w+)\s*:\s*(?:out|buffer)\s+([^:;]*?)\s*(:=[^;]*?)?\s*(?:;|\)\s*;\s*$)"
    return [OutputPort(entity[1], *(group or "" for group in found)) for found in re.findall(pattern, code)]


def plant(text: str, port: OutputPort, records: Mapping[str, tuple[str, str]]) -> str:
    """The text of an entity's file with a fault at one of its ports; records: of record_types."""
    head, begin, body = re.split(rf"^(architecture \w+ of {port.entity} is)$", text, maxsplit=1, flags=re.MULTILINE)
    sound = f"{port.name}_sound"
    # Formals of the entity's parts, and fields, are other names.
    body = re.sub(rf"(?<![.\w']){port.name}\b(?!(?:\([^()]*\))?\s*=>)", sound, body)
    path, kind = "", port.type
    while kind in records:
        field, kind = records[kind]
        path += f".{field}"
    bit = "" if kind in _SCALARS else f"({sound}{path}'low)"
    fault = f"""
  p_fault : process (all) is
  begin

    {port.name} <= {sound};
    {port.name}{path}{bit} <= not {sound}{path}{bit};

  end process p_fault;

"""
    last = re.search(r"^end\b.*\Z", body, re.MULTILINE | re.DOTALL)
    declared = f"\n  signal {sound} : {port.type} {port.default};\n"
    return head + begin + declared + body[: last.start()] + fault + body[last.start() :]


def record_types(rtl: Path) -> dict[str, tuple[str, str]]:
    """Name and type of the first field of each record type of rtl/."""
    pattern = r"type (\w+) is record\s+(?:--[^\n]*\s+)*(\w+)\s*:\s*([^;]*?)\s*;"
    return {name: (field, kind) for path in rtl_sources(rtl) for name, field, kind in
            re.findall(pattern, path.read_text())}  # fmt: skip


def try_port(port: OutputPort, root: Path) -> Found:
    """Plant the fault of a port in a copy of root's rtl/; look for a claim that breaks, else for a test that fails.

    Raises InputError when the fault does not compile, which would pass for found.
    """
    with tempfile.TemporaryDirectory(prefix="port-") as folder:
        rtl, work = Path(folder) / "rtl", Path(folder) / "work"
        shutil.copytree(root / "rtl", rtl)
        work.mkdir()
        source = source_of(rtl, port.entity)
        source.write_text(plant(source.read_text(), port, record_types(rtl)))
        for claim in CLAIMS:
            if claim.entity == port.entity and claim.checker not in _SLOW_CHECKERS:
                broken = verify(claim, rtl, root / "tb" / "formal", Path(folder) / "formal").broken
                if broken:
                    return Found(port.entity, port.name, _BY_PROOF, f"{claim.checker}: {', '.join(sorted(broken))}")
        if not compiles(rtl, str(work)):
            raise InputError(f"{port.entity}.{port.name}: a fault at this port does not compile")
        tests = _simulations(port.entity, root)
        result, test = run_tests(root, rtl, Path(folder) / "build", tests, TIMEOUT_S)
        if result == CAUGHT:
            return Found(port.entity, port.name, _BY_TEST, test)
        return Found(port.entity, port.name, "", TIMEOUT if result == TIMEOUT else "")


def _simulations(entity: str, root: Path) -> list[str]:
    return [test for test in relevant_tests(entity, root / "rtl", root / "tb") if "formal" not in test]


class PortVerdicts:
    """What found each fault, in a CSV file, with a key of all that this rests on in the tree of root."""

    _COLUMNS = ("entity", "port", "tool", "by", "key")

    def __init__(self, path: Path, root: Path):
        self._path, self._root, self._keys = path, root, Keys()
        self._kept = {(line["entity"], line["port"]): line for line in read_lines(path)}

    def known(self, port: OutputPort) -> Found | None:
        """The verdict on a port, when nothing that it rests on has changed."""
        line = self._kept.get((port.entity, port.name))
        found = line and Found(*(line[name] for name in self._COLUMNS[:-1]))
        return found if found and line["key"] == self._key(found) else None

    def keep(self, found: Found) -> None:
        """Write the table with this verdict."""
        self._kept[found.entity, found.port] = dict(
            zip(self._COLUMNS, (*astuple(found), self._key(found)), strict=True)
        )
        write_lines(self._path, self._COLUMNS, (line for _, line in sorted(self._kept.items())))

    def _key(self, found: Found) -> str:
        """Of the entity, and of the checker or test that found the fault; of all that did not, where none did."""
        rtl, tb = self._root / "rtl", self._root / "tb"
        if found.tool == _BY_PROOF:
            names = [f"formal/{found.by.partition(':')[0]}.sv"]
        elif found.tool == _BY_TEST:
            names = [found.by.partition("::")[0]]
        else:
            names = [*_simulations(found.entity, self._root), *sorted(f"formal/{p.name}" for p in tb.glob("formal/*"))]
        return self._keys.of([source_of(rtl, found.entity), *(tb / name for name in names)])


INTRODUCTION = """\
# A fault at every output port

Written by `make ports`. The list is made from the VHDL: every output port of every entity of `rtl/sources.f`. At each
one a fault is planted, by itself: its lowest bit inverted (of a record, that of its first field), while the entity goes
on reading the right value. First the proofs of the entity are tried ([which](formal.md)), and every assertion that
breaks is named; where arithmetic is out of their reach, or nothing is proven of the port, the tests in which the entity
runs, which compare it clock by clock with its twin in Python, until the first fails. A simulation that does not end is
no test that fails: it has found nothing. Verdicts are kept in `ports.csv`; a port is tried again when its entity has
changed, or what found its fault.

| entity | port | found by | assertions that break, or test that fails |
|---|---|---|---|
"""


def markdown(found: list[Found], n_ports: int) -> str:
    """A row per port that was tried, how many of them were found, and how many of all n_ports were tried."""
    rows = [f"| {f.entity} | {f.port} | {f.tool or '**nothing**'} | {f.by} |" for f in found]
    n = {tool: sum(f.tool == tool for f in found) for tool in (_BY_PROOF, _BY_TEST)}
    told = f"{sum(n.values())} of {len(found)} ports: {n[_BY_PROOF]} by proof, {n[_BY_TEST]} by a test"
    return INTRODUCTION + "\n".join(rows) + f"\n\nFound: {told}. Tried: {len(found)} of {n_ports} ports.\n"
