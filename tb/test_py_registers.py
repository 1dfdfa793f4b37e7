"""The generated register files: what is checked in comes from the description, and every view of it agrees."""

import re
import subprocess

import pytest

from codes import ROOT
from gravcomp import __version__
from gravcomp.driver.registers import MOTION_XML, REGISTERS_XML, read_registers
from gravcomp.errors import InputError
from gravcomp_lab.ipxact.component import SCRIPT
from runner import RTL

GENERATED = [
    *(RTL / "registers" / name for name in ("gc_facts_pkg.vhd", "gc_scalars_pkg.vhd")),
    REGISTERS_XML,
    MOTION_XML,
    *(RTL / name for name in ("component.xml", SCRIPT)),
    *(ROOT / "host" / name for name in ("gravcomp_registers.h", "gravcomp_motion_registers.h", "gravcomp_facts.h")),
    ROOT / "sim" / "gravcomp" / "facts.py",
    ROOT / "docs" / "guide" / "system.md",
]
# By the name of their description and header.
MAPS = {"registers": REGISTERS_XML, "motion_registers": MOTION_XML}


@pytest.fixture(scope="module")
def fresh(tmp_path_factory):
    """A folder with everything that `make regs` writes."""
    folder = tmp_path_factory.mktemp("registers")
    subprocess.run([ROOT / "scripts" / "registers.sh", folder], check=True, capture_output=True, timeout=120)
    return folder


@pytest.mark.parametrize("path", GENERATED, ids=lambda path: path.name)
def test_register_files_come_from_the_description(fresh, path):
    relative = path.relative_to(ROOT)
    assert path.read_bytes() == (fresh / relative).read_bytes(), f"{relative} is stale; start `make regs`"


@pytest.mark.parametrize("name", MAPS)
def test_register_pages_are_written(fresh, name):
    assert (fresh / "build" / name / "index.html").stat().st_size > 0


@pytest.mark.parametrize("name", MAPS)
def test_register_addresses_of_header_and_ipxact_agree(name):
    """Offsets of the C struct, counted from its members' sizes, against the IP-XACT addresses that Python uses."""
    header = (ROOT / "host" / f"gravcomp_{name}.h").read_text()
    members = re.findall(r"^    uint(8|32)_t (\w+)(?:\[(\w+)\])?;", header, re.MULTILINE)
    offset, offsets = 0, {}
    for bits, member, count in members:
        offsets[member] = (offset, int(count or "1", 0))
        offset += int(bits) // 8 * int(count or "1", 0)
    expected = {of: (register.address, register.count) for of, register in read_registers(MAPS[name]).items()}
    assert {member: where for member, where in offsets.items() if not member.startswith("RESERVED")} == expected


@pytest.mark.parametrize("description", MAPS)
def test_register_fields_of_header_and_ipxact_agree(description):
    header = (ROOT / "host" / f"gravcomp_{description}.h").read_text()
    for name, register in read_registers(MAPS[description]).items():
        for field, (low, width) in register.fields.items():
            c_name = rf"GC_{description}__{name}X?__{field}".upper()
            mask = re.search(rf"#define {c_name}_bm (0x\w+)", header)
            assert int(mask.group(1), 16) == (2**width - 1) << low, c_name


def test_version_of_the_registers_is_that_of_the_package():
    version = read_registers()["version"].reset
    assert f"{version >> 16 & 255}.{version >> 8 & 255}.{version & 255}" == __version__


def test_registers_that_cannot_be_read_are_refused(tmp_path):
    (tmp_path / "component.xml").write_text("<component>")
    with pytest.raises(InputError, match=r"component[.]xml: .*make regs"):
        read_registers(tmp_path / "component.xml")
