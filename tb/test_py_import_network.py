"""Networks from ONNX files, written here as PyTorch, Keras and MATLAB export them."""

import numpy as np
import pytest

from arm import arm_toml
from gravcomp.cli import main
from gravcomp.network.onnx_file import read_onnx
from gravcomp.network.weights import load_network
from gravcomp.robot.machine import load_machine, parse_machine
from onnx_files import RNG, B, C, V, W, torch_like, write

MEAN, SPAN = np.array([0.3, -0.2]), np.array([1.5, 0.7])


def test_scaling_before_and_after_the_layers_is_folded_into_them(tmp_path):
    """Keras: a layer of normalisation, matrices turned, and efforts in their unit at the end."""
    nodes = [
        ("Sub", ["x", "mean"], "n", {}),
        ("Div", ["n", "span"], "s", {}),
        ("MatMul", ["s", "w"], "p", {}),
        ("Add", ["b", "p"], "a", {}),
        ("Sigmoid", ["a"], "h", {}),
        ("Transpose", ["v_turned"], "v", {}),
        ("MatMul", ["h", "v"], "o", {}),
        ("Add", ["o", "c"], "u", {}),
        ("Mul", ["u", "span"], "m", {}),
        ("Identity", ["m"], "y", {}),
    ]
    constants = {"mean": MEAN, "span": SPAN, "w": W.T, "b": B, "v_turned": V, "c": C}
    layers = read_onnx(write(tmp_path / "net.onnx", nodes, constants)).as_tanh()
    q = RNG.normal(size=(50, 2))
    hidden = 1 / (1 + np.exp(-(((q - MEAN) / SPAN) @ W.T + B)))
    wanted = (hidden @ V.T + C) * SPAN
    np.testing.assert_allclose(np.tanh(q @ layers.w.T + layers.b) @ layers.v.T + layers.c, wanted, atol=1e-5)


@pytest.mark.parametrize("act", ["Tanh", "Sigmoid"])
def test_network_of_another_tool_is_trained_further_to_the_hardware(tmp_path, act, capsys):
    """Fitted to the arm's torques here by least squares over fixed neurons, as a tool with tanh or sigmoid would."""
    (tmp_path / "arm").mkdir()
    (tmp_path / "arm" / "robot.toml").write_text(arm_toml(2))
    robot = parse_machine(arm_toml(2), "an arm").robot
    q = robot.workspace(800, 5)
    rng = np.random.default_rng(4)
    w, b = rng.normal(size=(24, 2)), rng.uniform(-2, 2, 24)
    gain = 1.0 if act == "Tanh" else 2.0
    hidden = np.tanh(q @ w.T + b)
    hidden = hidden if act == "Tanh" else (1 + hidden) / 2
    parts = np.linalg.lstsq(np.c_[hidden, np.ones(len(q))], robot.forces(q), rcond=None)[0]
    file = torch_like(tmp_path / "net.onnx", act, gain * w, gain * b, parts[:-1].T, parts[-1])
    out = tmp_path / "out"
    how = ["--robot", str(tmp_path / "arm"), "--out", str(out), "--poses", "800"]
    assert main(["import-network", str(file), *how]) == 0
    lines = capsys.readouterr().out.splitlines()[1:]
    imported, replaced, trained = (float(line.split()[-1]) for line in lines)
    assert imported < 1.0 < replaced
    assert trained < 0.5
    unseen = robot.workspace(2000, 9)
    error = load_network(out).forces(unseen) - robot.forces(unseen)
    assert 100 * np.sqrt(np.mean(error**2) / np.mean(robot.forces(unseen) ** 2)) < 0.5
    assert load_machine(out).activation == "gamma"
    assert main(["rom", "--weights", str(out), "--out", str(tmp_path / "rom")]) == 0


BAD = {
    "another activation": (
        [("Gemm", ["x", "w", "b"], "a", {"transB": 1}), ("Relu", ["a"], "y", {})], "node 2, Relu: is not known here"
    ),
    "no activation": ([("Gemm", ["x", "w", "b"], "y", {"transB": 1})], "no hidden layer of tanh or sigmoid"),
    "two hidden layers": (
        [("Tanh", ["x"], "h", {}), ("Tanh", ["h"], "y", {})], "node 2, Tanh: a second hidden layer; the core has one"
    ),
    "a branch": (
        [("Tanh", ["x"], "h", {}), ("Add", ["h", "x"], "y", {})], "node 2, Add: takes a value that is no constant"
    ),
    "sizes": ([("Gemm", ["x", "v", "c"], "a", {"transB": 1}), ("Tanh", ["a"], "y", {})], "node 1, Gemm: its sizes do"),
}  # fmt: skip


@pytest.mark.parametrize("case", [*BAD, "no file", "no ONNX", "other sizes"])
def test_file_that_is_no_such_network_is_refused_in_one_line(tmp_path, case, capsys):
    (tmp_path / "robot.toml").write_text(arm_toml(3 if case == "other sizes" else 2))
    file, words = tmp_path / "net.onnx", {"no file": "not found", "no ONNX": "not an ONNX file"}.get(case)
    if case == "no ONNX":
        file.write_bytes(b"\x00not a protobuf")
    elif case == "other sizes":
        torch_like(file)
        words = "2 inputs and 2 outputs, but the machine gives 3 and takes 3"
    elif case != "no file":
        nodes, words = BAD[case]
        write(file, nodes, {"w": W, "b": B, "v": V, "c": C})
    assert main(["import-network", str(file), "--robot", str(tmp_path), "--out", str(tmp_path / "out")]) == 2
    complaint = capsys.readouterr().err
    assert complaint.count("\n") == 1
    assert words in complaint
    assert not (tmp_path / "out").exists()
