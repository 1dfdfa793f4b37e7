"""Boards: every pin has its place, once, and a machine that does not fit is refused before anything is made."""

import re
import shutil

import pytest

from gravcomp.errors import InputError
from gravcomp_lab.boards.bitstream import Clock, _check_clocks, _check_unpacked, build
from gravcomp_lab.boards.board import boards
from gravcomp_lab.shipped import SPHEIRO
from runner import ROOT, RTL

BOARDS = boards(ROOT / "boards")
ALL = pytest.mark.parametrize("board", BOARDS.values(), ids=BOARDS)


def ports(board) -> dict[str, bool]:
    """Ports of the top, each with whether it has a bit per axis; a vector of constant width counts bit by bit."""
    return ports_of(board.sources[-1].read_text())


def ports_of(top: str) -> dict[str, bool]:
    entity = re.search(r"port \((.*?)\n  \);", top, re.DOTALL)[1]
    found = {}
    for name, width in re.findall(
        r"^ +(\w+) +: +(?:in|out) +std_ulogic(?:_vector\(([^)]*) downto 0\))?", entity, re.MULTILINE
    ):
        if width.isdigit():
            found |= {f"{name}[{k}]": False for k in range(int(width) + 1)}
        else:
            found[name] = bool(width)
    return found


@ALL
def test_every_pin_of_every_axis_has_one_place_of_its_own(board):
    text = re.sub(r"#.*", "", board.constraints.read_text())
    sites = dict(re.findall(r'LOCATE COMP "(\S+)" SITE "(\w+)"', text))
    buffers = re.findall(r'IOBUF PORT "(\S+)" PULLMODE=(UP|DOWN|NONE) IO_TYPE=LVCMOS33', text)
    need = {f"{name}[{k}]" for name, per_axis in ports(board).items() if per_axis for k in range(board.axes)}
    need |= {name for name, per_axis in ports(board).items() if not per_axis}
    assert set(sites) == need == {name for name, _ in buffers}
    assert len(set(sites.values())) == len(sites) == len(buffers)


@ALL
def test_what_must_not_float_is_pulled_to_the_safe_side(board):
    pull = dict(re.findall(r'IOBUF PORT "(\w+)\S*" PULLMODE=(\w+)', board.constraints.read_text()))
    # README of the safety chain: a loose emergency stop stops, a loose index is no mark, a loose brake is engaged.
    assert pull["estop_n"] == pull["enc_z"] == pull["brake_free"] == pull["drive_on"] == "DOWN"
    assert pull["brake_hold"] == "UP"


@ALL
def test_clock_of_the_oscillator_is_constrained(board):
    (name, mhz) = re.search(r'FREQUENCY PORT "(\w+)" (\d+) MHZ;', board.constraints.read_text()).groups()
    assert name in ports(board)
    assert float(mhz) * 1e6 == board.oscillator_hz


@ALL
def test_generics_of_a_part_are_those_of_the_top(board):
    declared = re.search(r"generic \((.*?)port \(", board.sources[-1].read_text(), re.DOTALL)[1]
    assert {*board.generics, "selftest_g"} <= set(re.findall(r"(\w+) +:", declared))


# Boards for vendors' tools, which were not run: their constraints, (site, port, pull) of each pin.
UNRUN = {
    "arty_a7": ("xdc", r"PACKAGE_PIN (\w+) IOSTANDARD LVCMOS33(?: PULL(\w+) true)?\} \[get_ports \{([^}]+)\}"),
    "de10_nano": ("qsf", r"set_location_assignment PIN_(\w+)()? -to (\S+)"),
}


@pytest.mark.parametrize("name", UNRUN)
def test_every_pin_of_a_board_that_was_never_run_has_one_place_of_its_own(name):
    extension, pattern = UNRUN[name]
    folder = ROOT / "boards" / name
    text = (folder / f"{name}.{extension}").read_text()
    pins = re.findall(pattern, text)
    declared = ports_of((folder / f"{name}.vhd").read_text())
    need = {f"{port}[{k}]" if per_axis else port for port, per_axis in declared.items() for k in range(3)}
    assert {port for _, _, port in pins} == need
    assert len({site for site, _, _ in pins}) == len(pins) == len(need)
    if name == "arty_a7":
        pull = {port.partition("[")[0]: way for _, way, port in pins}
    else:  # no part of this family pulls down
        pull = dict.fromkeys(declared, "DOWN") | dict.fromkeys(
            re.findall(r"WEAK_PULL_UP_RESISTOR ON -to (\w+)", text), "UP"
        )
    assert pull["estop_n"] == pull["enc_z"] == pull["brake_free"] == pull["drive_on"] == "DOWN"
    assert pull["brake_hold"] == "UP"
    assert "Never run" in text


def test_folder_without_boards_is_refused(tmp_path):
    with pytest.raises(InputError, match="no boards"):
        boards(tmp_path)


def test_board_without_a_key_is_refused(tmp_path):
    shutil.copytree(ROOT / "boards" / "ulx3s", tmp_path / "mine")
    toml = tmp_path / "mine" / "board.toml"
    toml.write_text(re.sub(r"^oscillator_hz.*$", "", toml.read_text(), flags=re.MULTILINE))
    with pytest.raises(InputError, match=r"mine/board.toml: no key oscillator_hz"):
        boards(tmp_path)


def test_machine_of_another_clock_is_refused(tmp_path):
    shutil.copytree(SPHEIRO, tmp_path / "mine")
    toml = tmp_path / "mine" / "robot.toml"
    toml.write_text(re.sub(r"^clock_hz.*$", "clock_hz = 50e6", toml.read_text(), flags=re.MULTILINE))
    with pytest.raises(InputError, match=r"clock_hz = 5e[+]07, ulx3s-85f runs its core at 4e[+]07"):
        build(BOARDS["ulx3s-85f"], tmp_path / "mine", RTL, tmp_path / "out", selftest=False, seed=1)
    assert not (tmp_path / "out").exists()


def test_machine_of_more_axes_than_pins_is_refused(tmp_path):
    with pytest.raises(InputError, match="6 axes; colorlight_i5-25f has pins for 3"):
        build(BOARDS["colorlight_i5-25f"], ROOT / "weights" / "so101", RTL, tmp_path / "out", selftest=False, seed=1)


def test_missed_clock_is_refused(tmp_path):
    _check_clocks((Clock("a", 25.0, 25.0), Clock("b", 40.0, 40.1)), tmp_path)
    with pytest.raises(InputError, match=r"clock b runs at 40.0 MHz, the placement reaches 39.9: no bitstream"):
        _check_clocks((Clock("a", 25.0, 60.0), Clock("b", 40.0, 39.9)), tmp_path)


PLACED = """.tile R2C2:PLC2
word: SLICEA.K0.INIT 1010101010101010
word: SLICEA.K1.INIT 1111111111111111
enum: SLICEA.MODE LOGIC
enum: SLICEA.REG0.REGSET SET
enum: SLICEA.REG1.REGSET RESET

.bram_init 3
00b 030
055 000

.tile_group MIB_R25C22:MIB_EBR0 MIB_R25C23:MIB_EBR1
word: EBR0.WID 110000000
"""
# As ecpunpack writes it: what is as erased is left out, and of a setting of a RAM each tile has a part.
UNPACKED = """.tile R2C2:PLC2
word: SLICEA.K0.INIT 1010101010101010
enum: SLICEA.REG1.REGSET RESET
word: SLICEB.K0.INIT 0000000000000000

.tile MIB_R25C23:MIB_EBR1
word: EBR0.WID 110011111

.bram_init 3
00b 030
055 000
"""


def test_bitstream_that_holds_what_was_placed_is_kept(tmp_path):
    placed, unpacked = tmp_path / "placed", tmp_path / "unpacked"
    placed.write_text(PLACED)
    unpacked.write_text(UNPACKED)
    _check_unpacked(placed, unpacked)


@pytest.mark.parametrize(
    ("text", "other"),
    [("INIT 1010101010101010", "INIT 1011101010101010"), ("word: SLICEA.K0.INIT 1010101010101010\n", ""),
     ("word: SLICEB.K0", "word: SLICEA.K1"), ("enum: SLICEA.REG1.REGSET RESET\n", ""),
     ("SLICEA.REG1.REGSET", "SLICEA.REG0.REGSET"), ("055 000", "055 001"), ("055 000\n", "")],
)  # fmt: skip
def test_bitstream_that_lost_a_bit_is_refused(text, other, tmp_path):
    placed, unpacked = tmp_path / "placed", tmp_path / "unpacked"
    placed.write_text(PLACED)
    assert text in UNPACKED
    unpacked.write_text(UNPACKED.replace(text, other))
    with pytest.raises(InputError, match=r"[12] of 6 settings are not"):
        _check_unpacked(placed, unpacked)
