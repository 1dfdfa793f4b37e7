"""The generated VHDL: what is checked in comes from the shipped weights, and a change of the weights shows."""

import re

import pytest

from codes import ROOT, fixed_network
from gravcomp.cli import main
from gravcomp.core.folder import folder_hash
from gravcomp.core.vhdl.network_package import PACKAGE_FILE, stale_rom_files, write_rom
from gravcomp.network.weights import HIDDEN_CSV
from gravcomp.robot.machine import load_machine
from machines import SHIPPED, machine_folder


def test_checked_in_rom_comes_from_the_shipped_weights():
    assert stale_rom_files(SHIPPED, ROOT / "rtl" / "generated") == []


@pytest.fixture
def copy(tmp_path):
    """A weights folder, and the ROM made from it."""
    folder, generated = tmp_path / "weights", tmp_path / "generated"
    machine_folder(folder)
    write_rom(folder, generated)
    return folder, generated


def test_check_tells_a_rom_that_disagrees_with_its_csv(copy, capsys):
    folder, generated = copy
    command = ["rom", "--check", "--weights", str(folder), "--out", str(generated)]
    assert main(command) == 0
    lines = (folder / HIDDEN_CSV).read_text().splitlines()
    cells = lines[1].split(",")
    cells[1] = repr(float(cells[1]) + 0.01)
    (folder / HIDDEN_CSV).write_text("\n".join([lines[0], ",".join(cells), *lines[2:]]) + "\n")
    assert main(command) == 2
    assert PACKAGE_FILE in capsys.readouterr().err
    assert main([word for word in command if word != "--check"]) == 0
    assert main(command) == 0


def test_package_holds_the_hash_and_the_words_of_the_weights(copy):
    folder, generated = copy
    text = (generated / PACKAGE_FILE).read_text()
    assert folder_hash(folder, load_machine(folder)) in text
    fixed = fixed_network()
    first_word = re.search(r'hidden_words_c .*?0 => b"([01_]+)"', text, re.DOTALL).group(1).split("_")
    codes = [int(bits, 2) - (bits[0] == "1") * 2 ** len(bits) for bits in first_word]
    assert codes == [fixed.hidden_bias[0], *fixed.hidden_weights[0, ::-1]]
