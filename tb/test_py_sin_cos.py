"""Sine and cosine from the count, for every phase code and for counts over all their 32 bits."""

import re
import shutil
from fractions import Fraction

import numpy as np
import pytest

from gravcomp.cli import main
from gravcomp.core.formats import OPERAND_BITS, PHASE_BITS, SIN_COS_FRACTION, STEP_BITS, quantise
from gravcomp.core.image import image_records, load_image
from gravcomp.core.provenance import write_provenance
from gravcomp.network.weights import Network, load_network, save_network
from gravcomp.robot.machine import load_machine
from gravcomp.training.training import Effort, train, workspace_set
from gravcomp.twin.network import core
from gravcomp.twin.precision import MAX_SHARE
from gravcomp.twin.sin_cos import ERROR_LSB, HALF_BITS, PHASE_ERROR_LSB, RADIAN, REST_BITS, phase, sin_cos
from mechanisms import body, mechanism, mjcf
from test_py_image import Reader


def test_sine_and_cosine_of_every_phase_are_within_the_bound():
    code = np.arange(2**PHASE_BITS)
    angle = 2 * np.pi * code / 2**PHASE_BITS
    sine, cosine = sin_cos(code)
    worst = max(
        np.abs(found - 2.0**SIN_COS_FRACTION * wanted).max()
        for found, wanted in ((sine, np.sin(angle)), (cosine, np.cos(angle)))
    )
    print(f"MEASURED sine and cosine {worst:.2f} LSB off, bound {ERROR_LSB:.2f}")
    assert worst <= ERROR_LSB < 3
    assert max(sine.max(), cosine.max()) < 2 ** (OPERAND_BITS - 1)
    assert min(sine.min(), cosine.min()) >= -(2 ** (OPERAND_BITS - 1))
    # Operands of one multiplier.
    assert RADIAN * 2 ** (REST_BITS - 1) < 2 ** (OPERAND_BITS - 1)


def steps(counts_per_turn: Fraction) -> tuple[int, int]:
    """Turns per 2^16 counts and per count, modulo a turn, as codes."""
    return tuple(round((n / counts_per_turn % 1) * 2**STEP_BITS) for n in (2**HALF_BITS, 1))


@pytest.mark.parametrize("counts_per_turn", [Fraction(n) for n in (1, 3, 4096, 8192000, 12345)] + [Fraction(2**31, 7)])
def test_phase_is_within_its_bound_over_all_counts(counts_per_turn):
    rng = np.random.default_rng(1)
    edges = [-(2**31), 2**31 - 1, *(np.arange(-3, 4) * 2**16), *(np.arange(1, 8) * 2**16 - 1)]
    count = [int(c) for c in np.r_[edges, rng.integers(-(2**31), 2**31, 20000)]]
    found = phase(np.array(count), *steps(counts_per_turn))
    exact = [float(c / counts_per_turn % 1) * 2**PHASE_BITS for c in count]
    off = np.abs((found - exact + 2 ** (PHASE_BITS - 1)) % 2**PHASE_BITS - 2 ** (PHASE_BITS - 1))
    print(f"MEASURED phase {off.max():.3f} LSB off at {counts_per_turn} counts per turn, bound {PHASE_ERROR_LSB}")
    assert off.max() <= PHASE_ERROR_LSB < 1


def test_a_turn_later_the_phase_is_the_same():
    turn = phase(np.array([3, 3 + 4096, 3 - 4096]), *steps(Fraction(4096)))
    assert len(set(turn.tolist())) == 1


@pytest.mark.parametrize("counts_per_turn", [Fraction(4096), Fraction(1), Fraction(8192000), Fraction(2**31, 7)])
def test_where_the_count_wraps_the_phase_jumps_unless_all_counts_are_whole_turns(counts_per_turn):
    """By the part of a turn that is left of 2^32 counts."""
    before, after = phase(np.array([2**31 - 1, -(2**31)]), *steps(counts_per_turn))
    exact = float((1 - 2**32) / counts_per_turn % 1) * 2**PHASE_BITS
    off = (after - before - exact + 2 ** (PHASE_BITS - 1)) % 2**PHASE_BITS - 2 ** (PHASE_BITS - 1)
    assert abs(off) <= 2 * PHASE_ERROR_LSB
    one_count = float(1 / counts_per_turn % 1) * 2**PHASE_BITS
    assert (abs(exact - one_count) < 1e-6) == (counts_per_turn != 8192000)


@pytest.mark.parametrize(
    ("more", "turns"),
    [
        ("", 2**31 / 100000),
        ('counts_per_turn = "8192000/3"\n', 3 * 2**31 / 8192000),
        ("counts_per_turn = 65536\n", None),
        ("low = -6.0\nhigh = 6.0\n", None),
    ],
)
def test_rom_tells_after_how_many_turns_a_count_wraps(more, turns, tmp_path, capsys):
    drawn_machine(tmp_path, more)
    assert main(["rom", "--weights", str(tmp_path), "--out", str(tmp_path / "rom")]) == 0
    told = re.findall(r"axis 'turn' has no limits: its count wraps after (\S+) turns", capsys.readouterr().out)
    assert [float(number) for number in told] == ([] if turns is None else [pytest.approx(turns, rel=1e-3)])


def small_turning_machine(folder, more=""):
    """A hinge without limits that carries an arm, and a slide on it. more: lines of [[axis]] of the hinge."""
    text = mjcf(body("a", 'name="turn" axis="0 1 0"', 2.0, "0.3 0 0", inside=body(
        "b", 'name="out" type="slide" axis="1 0 0" range="0.1 0.5"', 1.0
    )))  # fmt: skip
    return mechanism(folder, text, {"turn": f'input = "sin_cos"\n{more}', "out": "counts_per_m = 1000000"})


def test_bit_true_core_with_sine_and_cosine_is_the_float_network(tmp_path):
    """Trained, written, read back, quantised; turns later the joint is held by the same torque."""
    machine = small_turning_machine(tmp_path / "machine")
    out, data = tmp_path / "out", workspace_set(300, machine.robot, 1)
    effort = Effort(draws=5, tied_hops=3, hops=3, search_poses=150)
    network, _ = train(data, machine, n_hidden=8, n_starts=1, backend="threading", effort=effort)
    save_network(network, out)
    network, q = load_network(out), machine.robot.workspace(3000, 2)
    assert network.inputs == ("sin_cos", "position")
    assert (out / "hidden.csv").read_text().splitlines()[0] == "neuron,w_sin1,w_cos1,w_q2,bias"
    fixed = quantise(network, machine.drive)
    counts = machine.drive.counts(q)
    error_mn = core(counts, fixed).force_mn - 1000 * network.forces(machine.drive.positions(counts))
    limit_mn = 1000 * MAX_SHARE * float(network.f_scale.max())
    assert np.sqrt(np.mean(error_mn**2)) < limit_mn
    turned = counts + np.array([7 * 100000, 0])
    np.testing.assert_allclose(core(turned, fixed).force_mn, core(counts, fixed).force_mn, atol=3)
    assert not core(turned, fixed).clamped.any()
    error = network.forces(q) - machine.robot.forces(q)
    assert np.sqrt(np.mean(error**2) / np.mean(machine.robot.forces(q) ** 2)) < 0.01


def drawn_machine(folder, more=""):
    """The machine folder of a drawn network for the hinge and the slide."""
    machine = small_turning_machine(folder, more)
    rng, units, inputs = np.random.default_rng(7), ("rad", "m"), ("sin_cos", "position")
    one = np.ones(2)
    network = Network(
        rng.uniform(-1, 1, (4, 3)), np.zeros(4), np.ones((2, 4)) / 4, 0 * one, 0 * one, one, 0 * one, 20 * one, units,
        inputs,
    )  # fmt: skip
    save_network(network, folder)
    write_provenance(folder, command="a test", data={}, metrics={}, machine=machine)
    return machine


def test_rom_holds_the_axes_that_turn_and_their_steps(tmp_path):
    drawn_machine(tmp_path)
    assert main(["rom", "--weights", str(tmp_path), "--out", str(tmp_path / "rom")]) == 0
    text = (tmp_path / "rom" / "gc_network_pkg.vhd").read_text()
    assert re.search(r'turning_c +: std_ulogic_vector\(inputs_c - 1 downto 0\) := "01";', text)
    for size, number in (("axes", 2), ("features", 3)):
        assert re.search(rf"{size}_c +: positive := {number};", text)
    for name, step in zip(("coarse", "fine"), steps(Fraction(100000)), strict=True):
        assert f"{name}_step_c" in text
        assert f'b"{0:035b}_{step:035b}"' in text


def test_trained_range_of_an_axis_that_turns_leaves_room_for_a_margin(tmp_path):
    """Nothing is clamped there; a host adds its margin, up to as many counts again, within 32 bits."""
    drawn_machine(tmp_path)
    fixed = quantise(load_network(tmp_path), load_machine(tmp_path).drive)
    assert (fixed.count_low[0], fixed.count_high[0]) == (-(2**30), 2**30)
    assert not core(np.array([[2**31 - 1, 0], [-(2**31), 0]]), fixed).clamped[:, 0].any()


def test_formats_cost_of_sine_and_cosine_is_told_by_their_columns(tmp_path, capsys):
    drawn_machine(tmp_path)
    assert main(["formats", "--weights", str(tmp_path)]) == 0
    told = capsys.readouterr().out
    assert re.search(r"hidden weights \| [\d.]+ \| hidden.csv row \d, (w_sin1|w_cos1|w_q2) = ", told)
    assert "| turn beside its place, rad | -102912 | 102912 | 18 | 18 |" in told


def test_image_has_the_weights_of_sine_and_cosine_and_ends_of_each_input(tmp_path):
    """Per neuron p = 3 weights, of two axes two outputs; the scalars of the encoders, of the inputs, of the outputs."""
    drawn_machine(tmp_path)
    image = load_image(tmp_path, tmp_path)
    reader, net = Reader(image.words), image.network
    for weights, bias in zip(net.hidden_weights, net.hidden_bias, strict=True):
        assert reader.record(*[OPERAND_BITS] * 3, net.hidden_sum_bits) == [*weights, bias]
    for weights in net.output_weights.T:
        assert reader.record(*[OPERAND_BITS] * 2) == weights.tolist()
    scalars = image_records(net, image.compensation)["scalar"][0]
    assert [int(value) for value, _ in scalars[:6]] == [*net.count_low, *net.count_high, *net.input_scale]
    assert [(int(value), bits) for value, bits in scalars[6:12]] == [
        (value, OPERAND_BITS) for value in (*net.x_low, *net.x_high)
    ]
    assert (net.x_low[:2].tolist(), net.x_high[:2].tolist()) == ([-(2**17)] * 2, [2**17 - 1] * 2)


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("= 100000", "= 100001", "axis 1: counts_per_turn is another than that of the core"),
        ('input = "sin_cos"', 'input = "position"\nlow = -1\nhigh = 1', "axis 1 has columns of sin_cos, but"),
    ],
)  # fmt: skip
def test_image_of_other_turns_is_refused(tmp_path, capsys, old, new, complaint):
    drawn_machine(tmp_path / "core")
    other = tmp_path / "other"
    shutil.copytree(tmp_path / "core", other)
    text = (other / "robot.toml").read_text()
    assert old in text
    (other / "robot.toml").write_text(text.replace(old, new))
    assert main(["image", "--weights", str(other), "--rom", str(tmp_path / "core"), "--out", str(tmp_path / "i")]) == 2
    told = capsys.readouterr().err
    assert complaint in told
    assert told.count("\n") == 1
    assert not (tmp_path / "i").exists()
