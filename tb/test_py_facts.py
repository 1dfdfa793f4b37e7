"""Facts that more than one language states agree: the registers' description, VHDL, C, Python and the guide."""

import re

import pytest

from codes import ROOT
from gravcomp.core import formats
from gravcomp.core.compensator_tables import N_POSITIONS, N_SPEEDS
from gravcomp.driver import host
from gravcomp.driver.registers import read_registers
from gravcomp.twin.safety import ALWAYS, Cause, State
from gravcomp_lab.synthesis.verilog import source_of
from runner import RTL

RDL = (RTL / "registers" / "gc_registers.rdl").read_text()
SAFETY = source_of(RTL, "gc_safety_pkg").read_text()
BUS_SIDE = source_of(RTL, "gc_bus_side").read_text()
C_SOURCE = (ROOT / "host" / "gravcomp.c").read_text()
C_HEADER = (ROOT / "host" / "gravcomp.h").read_text()
GUIDE = ROOT / "docs" / "guide"
REGISTERS = read_registers()
CAUSE_OF_FIELD = {"unreferenced": "reference"}  # the others have the name of their cause


def test_causes_are_the_bits_of_the_fault_register():
    fields = {name: low for name, (low, width) in REGISTERS["fault"].fields.items() if name != "clear"}
    described = {CAUSE_OF_FIELD.get(name, name): low for name, low in fields.items()}
    assert {cause.name.lower(): int(cause) for cause in Cause} == described
    vhdl = re.findall(r"constant cause_(\w+)_c *: natural *:= (\d+);", SAFETY)
    assert {name: int(bit) for name, bit in vhdl} == described
    wired = re.findall(r"regs_in\.fault\.(\w+)\.next_q <= in_state\.fault\(cause_(\w+)_c\);", BUS_SIDE)
    assert {field: cause for field, cause in wired} == {name: CAUSE_OF_FIELD.get(name, name) for name in fields}


def test_causes_have_one_width():
    (width,) = re.findall(r"constant causes_c *: positive := (\d+);", SAFETY)
    assert int(width) == len(Cause) == max(Cause) + 1
    for register, field in (("fault", "clear"), ("cause", "value"), ("first_cause", "value")):
        assert REGISTERS[register].fields[field] == (0, len(Cause)), register


def test_causes_that_count_while_braked_are_those_of_the_guide():
    """Those of the VHDL are the twin's by test_rtl_safety.py."""
    told = re.findall(r"^\| (\w+) \| \d+ \|.*\| always \|", (GUIDE / "safety.md").read_text(), re.M)
    assert sum(Cause[name.upper()].mask for name in told) == ALWAYS


def test_every_cause_and_state_has_its_row_in_the_guide():
    rows = re.findall(r"^\| (\w+) \| (\d+) \|", (GUIDE / "safety.md").read_text(), re.M)
    assert {name: int(bit) for name, bit in rows if name.islower()} == {c.name.lower(): int(c) for c in Cause}
    assert {name: int(code, 2) for name, code in rows if name.isupper()} == {s.name: int(s) for s in State}


def test_registers_of_the_guide_are_at_their_offsets():
    rows = re.findall(r"^\| 0x(\w+) \| `(\w+)`", (GUIDE / "system.md").read_text(), re.M)
    assert len(rows) > 10
    assert [(name, int(offset, 16)) for offset, name in rows] == [(name, REGISTERS[name].address) for _, name in rows]


def test_states_agree():
    states = {state.name.lower(): int(state) for state in State}
    vhdl = re.findall(r'constant state_(\w+)_c *: safety_state_t := "(\d+)";', SAFETY)
    assert {name: int(code, 2) for name, code in vhdl} == states
    told = re.search(r'desc = "State of the brakes: ([^."]*)', RDL)[1]
    assert {name: int(code) for code, name in re.findall(r"(\d+) (\w+)", told)} == states
    driver = {"faulted": states.pop("fault"), **states}
    assert {state.name.lower(): int(state) for state in host.Brakes} == driver
    c = re.findall(r"GRAVCOMP_(BRAKED|HOLDING|RUN|FAULTED) = (\d+)", C_HEADER)
    assert {name.lower(): int(code) for name, code in c} == driver


def test_any_two_states_differ_in_two_bits():
    codes = [int(state) for state in State]
    assert all((a ^ b).bit_count() >= 2 for a in codes for b in codes if a != b)


@pytest.mark.parametrize(
    ("file", "pattern"),
    [
        ("rtl/registers/gc_registers.rdl", r"0x(\w+), ASCII KEYS"),
        ("host/gravcomp.c", r"#define LOAD_KEY 0x(\w+?)u"),
        ("docs/guide/system.md", r"Write 0x(\w+) to `load_unlock`"),
    ],
)
def test_key_to_loading_is_one(file, pattern):
    assert int(re.search(pattern, (ROOT / file).read_text())[1], 16) == host.LOAD_KEY
    assert re.search(r'load_key_c *: word_t := x"(\w+)"', BUS_SIDE)[1] == f"{host.LOAD_KEY:X}"
    assert host.LOAD_KEY.to_bytes(4, "big") == b"KEYS"


def test_what_the_key_guards_is_the_loader_and_nothing_else():
    (block,) = re.findall(r'load_block_c *: std_ulogic_vector\(11 downto 4\) := x"(\w+)"', BUS_SIDE)
    guarded = {name for name, register in REGISTERS.items() if register.address >> 4 == int(block, 16)}
    assert guarded == {"load_command", "load_crc", "load_word"}
    told = re.search(r"Without it, writes to 0x(\w+) to 0x(\w+) get SLVERR", (GUIDE / "system.md").read_text())
    assert [int(end, 16) for end in told.groups()] == [int(block, 16) << 4, (int(block, 16) << 4) + 15]


def test_axes_are_one_number():
    vhdl = re.search(r"constant axes_c *: positive := (\d+);", source_of(RTL, "gc_system_pkg").read_text())[1]
    c = re.search(r"#define GRAVCOMP_AXES (\d+)", C_HEADER)[1]
    arrays = {r.count for name, r in REGISTERS.items() if r.count > 1 and not name.endswith("_hash")}
    assert {int(vhdl), int(c), *arrays} == {host.AXES}


def test_operands_are_as_wide_in_python_as_in_vhdl():
    package = source_of(RTL, "gc_fixed_pkg").read_text()
    assert int(re.search(r"constant operand_bits_c *: positive := (\d+);", package)[1]) == formats.OPERAND_BITS


def test_tables_of_the_compensator_are_as_long_in_python_as_in_vhdl():
    package = source_of(RTL, "gc_image_pkg").read_text()
    bits = dict(re.findall(r"constant (speed|position)_address_bits_c *: positive := (\d+);", package))
    assert 2 ** int(bits["speed"]) == 2 * N_SPEEDS
    assert 2 ** int(bits["position"]) == N_POSITIONS


def test_drivers_kick_as_often_while_they_load():
    assert int(re.search(r"#define WORDS_PER_KICK (\d+)u", C_SOURCE)[1]) == host.WORDS_PER_KICK
