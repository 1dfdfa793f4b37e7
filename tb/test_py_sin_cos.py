"""Sine and cosine from the count, for every phase code and for counts over all their 32 bits."""

import numpy as np

from gravcomp.cli import main
from gravcomp.core.formats import OPERAND_BITS, PHASE_BITS, PHASE_SCALE_FRACTION, SIN_COS_FRACTION, quantise
from gravcomp.core.provenance import write_provenance
from gravcomp.network.weights import Network, load_network, save_network
from gravcomp.training.training import Effort, train, workspace_set
from gravcomp.twin.network import core
from gravcomp.twin.precision import MAX_SHARE
from gravcomp.twin.sin_cos import ERROR_LSB, RADIAN, REST_BITS, phase, sin_cos
from mechanisms import body, mechanism, mjcf


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
    assert max(np.abs(sine).max(), np.abs(cosine).max()) < 2 ** (OPERAND_BITS - 1)
    # Operands of one multiplier.
    assert RADIAN * 2 ** (REST_BITS - 1) < 2 ** (OPERAND_BITS - 1)


def test_phase_is_one_code_off_at_most_over_all_counts_and_wraps():
    rng = np.random.default_rng(1)
    count = np.r_[-(2**31), 2**31 - 1, rng.integers(-(2**31), 2**31, 20000)]
    for counts_per_turn in (4096, 8192000, 12345, 2.0**31 / 7):
        scale = round(2.0**PHASE_SCALE_FRACTION / counts_per_turn)
        turns = count / counts_per_turn
        found = phase(count, np.int64(scale)) / 2.0**PHASE_BITS
        off = np.abs((found - turns + 0.5) % 1.0 - 0.5) * 2**PHASE_BITS
        assert off.max() <= 0.5 + 1.0, counts_per_turn
    turn = phase(np.array([3, 3 + 4096, 3 - 4096]), np.int64(2**PHASE_SCALE_FRACTION // 4096))
    assert len(set(turn.tolist())) == 1


def small_turning_machine(folder):
    """A hinge without limits that carries an arm, and a slide on it."""
    text = mjcf(body("a", 'name="turn" axis="0 1 0"', 2.0, "0.3 0 0", inside=body(
        "b", 'name="out" type="slide" axis="1 0 0" range="0.1 0.5"', 1.0
    )))  # fmt: skip
    return mechanism(folder, text, {"turn": 'input = "sin_cos"', "out": "counts_per_m = 1000000"})


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


def test_vhdl_refuses_sine_and_cosine_by_axis(tmp_path, capsys):
    machine = small_turning_machine(tmp_path)
    weights, units, inputs = np.ones((4, 3)) / 4, ("rad", "m"), ("sin_cos", "position")
    one = np.ones(2)
    network = Network(
        weights, np.zeros(4), np.ones((2, 4)) / 4, 0 * one, 0 * one, one, 0 * one, 20 * one, units, inputs
    )
    save_network(network, tmp_path)
    write_provenance(tmp_path, command="a test", data={}, metrics={}, machine=machine)
    assert main(["rom", "--weights", str(tmp_path), "--out", str(tmp_path / "rom")]) == 2
    complaint = capsys.readouterr().err
    assert complaint.count("\n") == 1
    assert "robot.toml: axis 1: input = 'sin_cos': the core in VHDL takes positions alone as yet" in complaint
    assert not (tmp_path / "rom").exists()
    text = (tmp_path / "robot.toml").read_text()
    (tmp_path / "robot.toml").write_text(text.replace('"sin_cos"', '"position"\nlow = -1\nhigh = 1'))
    assert main(["rom", "--weights", str(tmp_path), "--out", str(tmp_path / "rom")]) == 2
    assert "hidden.csv: axis 1 has columns of sin_cos, but robot.toml says position" in capsys.readouterr().err
