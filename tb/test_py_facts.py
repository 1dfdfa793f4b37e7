"""Facts are defined once, in facts.toml and the registers' description; what is written by hand beside them agrees."""

import re
import tomllib

import pytest

from codes import ROOT
from gravcomp import facts
from gravcomp.core.compensator_tables import MANTISSA_BITS, N_POSITIONS, N_SPEEDS
from gravcomp.core.cost import CoreCost
from gravcomp.driver.registers import MOTION_XML, read_registers
from gravcomp.errors import InputError
from gravcomp.facts import ALWAYS, Cause, State
from gravcomp_lab.registers.facts import SOURCE, Facts
from gravcomp_lab.synthesis.verilog import source_of
from runner import RTL

BUS_SIDE = source_of(RTL, "gc_bus_side").read_text()
GUIDE = ROOT / "docs" / "guide"
REGISTERS = read_registers()
MOTION = read_registers(MOTION_XML)


def test_every_cause_is_wired_to_the_fault_of_its_name():
    wired = re.findall(r"regs_in\.fault\.(\w+)\.next_q <= in_state\.fault\(cause_(\w+)_c\);", BUS_SIDE)
    assert sorted(field for field, _ in wired) == sorted(cause.name.lower() for cause in Cause)
    assert all(field == cause for field, cause in wired)


def test_causes_have_one_width():
    assert len(Cause) == max(Cause) + 1
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


@pytest.mark.parametrize(("page", "registers"), [("system", REGISTERS), ("motion", MOTION)])
def test_registers_of_the_guide_are_at_their_offsets(page, registers):
    rows = re.findall(r"^\| 0x(\w+) \| `(\w+)`", (GUIDE / f"{page}.md").read_text(), re.M)
    assert len(rows) > 7
    assert [(name, int(offset, 16)) for offset, name in rows] == [(name, registers[name].address) for _, name in rows]


def test_registers_of_motion_are_beside_the_others():
    """Where gc_bus_side looks for them, settings apart from the rest; what a record shows at once fills its block."""
    settings = {name for name, register in MOTION.items() if register.holding}
    assert {REGISTERS[name].address >> 11 for name in REGISTERS} == {0}
    assert {name for name, register in MOTION.items() if 0x800 <= register.address < 0xA00} == settings
    assert all(0xA00 <= register.address < 0x1000 for name, register in MOTION.items() if name not in settings)
    assert [name for name, r in MOTION.items() if r.address >= MOTION["record_word"].address] == ["record_word"]
    assert 4 * facts.RECORD_WINDOW == 0x100


def test_any_two_states_differ_in_two_bits():
    assert all((a ^ b).bit_count() >= 2 for a in State for b in State if a != b)


def test_latencies_in_the_table_of_entities_are_those_of_the_facts():
    rows = dict(re.findall(r"^\| `gc_(\w+)` \|[^|]*\| (\d+)", (RTL / "README.md").read_text(), re.M))
    clocks = {name.removesuffix("_CLOCKS").lower(): n for name, n in vars(facts).items() if name.endswith("_CLOCKS")}
    assert {name: int(rows[name]) for name in clocks} == clocks
    path = (RTL / "README.md").read_text()
    at_once, in_turn = (CoreCost(20, 3, 3, lanes).clocks_behind() for lanes in (20, 4))
    assert in_turn == at_once + 2 * 3 - 1
    assert f"that of `gc_core` and {at_once}; 2 k - 1 more where k axes take turns;" in path


def test_tables_have_a_node_per_address():
    """Direction, five bits of exponent of a 32-bit period, mantissa; the last octave stands for standstill."""
    assert 2**facts.SPEED_ADDRESS_BITS == 2 * N_SPEEDS == 2 * 32 * 2**MANTISSA_BITS
    assert 2**facts.POSITION_ADDRESS_BITS == N_POSITIONS


def test_key_guards_whole_blocks_of_registers_alone():
    table = tomllib.loads(SOURCE.read_text())
    made = Facts(table, REGISTERS)
    assert (made.load_key.to_bytes(4, "big"), made.guarded_block) == (b"KEYS", 0x62)
    for names in (["load_command", "load_crc"], ["load_command", "load_crc", "load_word", "guards"]):
        with pytest.raises(InputError, match="guarded: they must be alone in one block of 16 bytes"):
            _ = Facts({**table, "guarded": names}, REGISTERS).guarded_block
