"""Weights folders: what is written is read back; whatever is wrong is one line that names file, row and column."""

import numpy as np
import pytest

from gravcomp.cli import main
from gravcomp.core.folder import folder_hash
from gravcomp.errors import InputError
from gravcomp.network.activation import gamma
from gravcomp.network.weights import Network, load_network, save_network
from machines import MACHINE, machine_folder


@pytest.fixture
def network() -> Network:
    rng = np.random.default_rng(31)
    return Network(
        hidden_weights=rng.normal(size=(4, 3)),
        hidden_bias=rng.normal(size=4),
        output_weights=rng.normal(size=(3, 4)),
        output_bias=rng.normal(size=3),
        q_offset=rng.normal(size=3) * 0.01,
        q_scale=np.array([6.0, 6.1, 6.2]),
        f_offset=rng.normal(size=3) * 10,
        f_scale=np.array([60.0, 61.0, 62.0]),
        position_units=("m",) * 3,
    )


@pytest.fixture
def folder(network, tmp_path):
    return machine_folder(tmp_path, network)


def test_saved_network_is_read_back_in_full_precision(network, folder):
    read = load_network(folder)
    for name in vars(network):
        np.testing.assert_array_equal(getattr(read, name), getattr(network, name), err_msg=name)


def test_forces_follow_the_equation(network):
    q = np.array([0.01, -0.02, 0.03])
    hidden = [
        gamma(sum(w * (q[i] - network.q_offset[i]) * network.q_scale[i] for i, w in enumerate(row)) + bias)
        for row, bias in zip(network.hidden_weights, network.hidden_bias, strict=True)
    ]
    expected = network.f_offset + network.f_scale * (network.output_weights @ hidden + network.output_bias)
    np.testing.assert_allclose(network.forces(q), expected, rtol=1e-14)


def test_hash_changes_with_any_file(folder):
    before = folder_hash(folder, MACHINE)
    for name in ("hidden.csv", "output.csv", "scaling.csv"):
        path = folder / name
        text = path.read_text()
        path.write_text(text.replace("1", "2"))
        assert folder_hash(folder, MACHINE) != before
        path.write_text(text)
    assert folder_hash(folder, MACHINE) == before


def edit(name, old, new):
    def apply(folder):
        path = folder / name
        text = path.read_text()
        assert old in text
        path.write_text(text.replace(old, new, 1))

    return apply


def cell(name, row, column, text):
    def apply(folder):
        path = folder / name
        lines = [line.split(",") for line in path.read_text().splitlines()]
        lines[row][lines[0].index(column)] = text
        path.write_text("\n".join(map(",".join, lines)) + "\n")

    return apply


def drop_last_line(name):
    def apply(folder):
        path = folder / name
        path.write_text("\n".join(path.read_text().splitlines()[:-1]) + "\n")

    return apply


def replace(name, content):
    return lambda folder: (folder / name).write_bytes(content)


SCALING_HEADER = b"axis,position_unit,q_offset,q_scale,f_offset,f_scale\n"
DAMAGE = {
    "missing file": (lambda folder: (folder / "output.csv").unlink(), ["output.csv", "not found"]),
    "missing column": (edit("hidden.csv", "w_q2", "other"), ["hidden.csv", "row 0", "column w_q2", "missing"]),
    "extra column": (edit("scaling.csv", "axis,", "axis,extra,"), ["scaling.csv", "row 0", "extra"]),
    "not a number": (cell("hidden.csv", 3, "w_q1", "soft"), ["hidden.csv", "row 3", "column w_q1", "'soft'"]),
    "NaN": (cell("output.csv", 2, "v_3", "nan"), ["output.csv", "row 2", "column v_3", "'nan'"]),
    "infinite": (cell("hidden.csv", 1, "bias", "inf"), ["hidden.csv", "row 1", "column bias", "'inf'"]),
    "misnumbered row": (cell("hidden.csv", 2, "neuron", "7"), ["hidden.csv", "row 2", "column neuron", "'7'"]),
    "short row": (edit("output.csv", "\n2,", "\n2,1\n2,"), ["output.csv", "row 2", "columns"]),
    "row too few": (drop_last_line("output.csv"), ["output.csv", "2 rows", "3 axes"]),
    "neuron too few": (drop_last_line("hidden.csv"), ["output.csv", "row 0"]),
    "no rows": (replace("scaling.csv", SCALING_HEADER), ["scaling.csv", "no rows"]),
    "empty file": (replace("hidden.csv", b""), ["hidden.csv", "empty"]),
    "binary file": (replace("hidden.csv", b"\x89PNG\xff\xfe\x00"), ["hidden.csv", "not a CSV"]),
    "zero scale": (cell("scaling.csv", 2, "q_scale", "0"), ["scaling.csv", "row 2", "column q_scale"]),
    "negative scale": (cell("scaling.csv", 3, "f_scale", "-5"), ["scaling.csv", "row 3", "column f_scale"]),
    "too large weight": (cell("hidden.csv", 4, "w_q3", "1e9"), ["hidden.csv", "row 4", "column w_q3", "1e+09"]),
    "too large output weight": (cell("output.csv", 1, "v_2", "-1e9"), ["output.csv", "row 1", "column v_2"]),
    "too large bias": (cell("hidden.csv", 2, "bias", "1e9"), ["hidden.csv", "row 2", "column bias"]),
    "beyond any float": (cell("hidden.csv", 1, "w_q1", "1e400"), ["hidden.csv", "row 1", "column w_q1", "'1e400'"]),
    "bias that overflows": (cell("hidden.csv", 2, "bias", "1e308"), ["hidden.csv", "row 2", "column bias"]),
    "offset that overflows": (cell("scaling.csv", 2, "q_offset", "1e308"), ["scaling.csv", "row 2"]),
    "scale that overflows": (cell("scaling.csv", 2, "f_scale", "1e308"), ["scaling.csv", "row 2", "f_scale"]),
    "scale that vanishes": (cell("scaling.csv", 3, "f_scale", "5e-324"), ["scaling.csv", "row 3", "f_scale"]),
    "semicolons": (
        lambda folder: (folder / "output.csv").write_text((folder / "output.csv").read_text().replace(",", ";")),
        ["output.csv", "row 0"],
    ),
    "open quote": (cell("hidden.csv", 2, "w_q1", '"1'), ["hidden.csv", "not a CSV"]),
    "folder in place of a file": (
        lambda folder: ((folder / "hidden.csv").unlink(), (folder / "hidden.csv").mkdir()),
        ["hidden.csv", "not a CSV"],
    ),
    "unknown unit": (
        cell("scaling.csv", 2, "position_unit", "mm"),
        ["scaling.csv", "row 2", "column position_unit", "'mm'"],
    ),
    "unit of another axis": (
        cell("scaling.csv", 3, "position_unit", "rad"),
        ["scaling.csv", "row 3", "robot.toml says m"],
    ),
    "too large force": (cell("scaling.csv", 1, "f_scale", "1e9"), ["scaling.csv", "row 1", "column f_scale"]),
    "too wide range": (
        cell("scaling.csv", 1, "q_scale", "1e-9"),
        ["scaling.csv", "row 1", "column q_scale"],
    ),
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_rom_refuses_damaged_weights_in_one_line_and_keeps_the_old_rom(damage, folder, tmp_path, capsys):
    generated = tmp_path / "generated"
    command = ["rom", "--weights", str(folder), "--out", str(generated)]
    assert main(command) == 0
    old = {path.name: path.read_bytes() for path in generated.iterdir()}
    capsys.readouterr()
    apply, words = DAMAGE[damage]
    apply(folder)
    assert main(command) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.count("\n") == 1
    for word in words:
        assert word in printed.err
    assert {path.name: path.read_bytes() for path in generated.iterdir()} == old


def test_saving_into_a_file_is_refused(network, tmp_path):
    (tmp_path / "weights").write_text("a file")
    with pytest.raises(InputError, match="weights"):
        save_network(network, tmp_path / "weights")
