"""A network with one hidden layer from an ONNX file, as PyTorch, Keras and MATLAB export it.

The graph is followed from its input as an affine map A x + b: what scales and shifts before, between and after the two
layers folds into them. Its inputs are positions in m or rad, or sine and cosine, in the order of the axes; its outputs
efforts in N or N m.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gravcomp.errors import InputError, optional

_PASSED = ("Identity", "Cast", "Dropout", "Flatten", "Reshape", "Squeeze", "Unsqueeze")
ACTIVATIONS = {"Tanh": np.tanh, "Sigmoid": lambda x: 1.0 / (1.0 + np.exp(-x))}


@dataclass(frozen=True)
class Layers:
    """y = V act(W x + b) + c: W (h, p), b (h,), V (m, h), c (m,); activation: Tanh or Sigmoid."""

    w: np.ndarray
    b: np.ndarray
    v: np.ndarray
    c: np.ndarray
    activation: str

    def as_tanh(self) -> "Layers":
        """The same with tanh: sigmoid(z) = (1 + tanh(z/2)) / 2."""
        if self.activation == "Tanh":
            return self
        v = self.v / 2
        return replace(self, w=self.w / 2, b=self.b / 2, v=v, c=self.c + v.sum(axis=1), activation="Tanh")


def read_onnx(path: Path) -> Layers:
    """The two layers of a file. Raises InputError naming file and node where it is another graph."""
    onnx = optional("onnx", "onnx", "an ONNX network")
    if not path.is_file():
        raise InputError(f"{path}: not found; give an ONNX file")
    try:
        graph = onnx.load(str(path)).graph
        constants = {item.name: _number(onnx, item) for item in graph.initializer}
    except Exception as error:  # protobuf's own kinds, and onnx' of external data
        message = " ".join(str(error).split())[:200]
        raise InputError(f"{path}: not an ONNX file ({message}); export the network again") from error
    inputs = [item for item in graph.input if item.name not in constants]
    if len(inputs) != 1 or len(graph.output) != 1:
        raise InputError(f"{path}: {len(inputs)} inputs, {len(graph.output)} outputs; export a network of one each")
    return _Walk(path, onnx, constants).layers(graph, inputs[0])


def _number(onnx, tensor) -> np.ndarray:
    return np.asarray(onnx.numpy_helper.to_array(tensor), dtype=float)


class _Walk:
    """Follows a graph. value: name of a tensor to its map (A, b) of what the layer begins with."""

    def __init__(self, path: Path, onnx, constants: dict[str, np.ndarray]):
        self.path, self.onnx, self.constants = path, onnx, constants
        self.hidden, self.activation = None, ""

    def layers(self, graph, graph_input) -> Layers:
        sizes = [dimension.dim_value for dimension in graph_input.type.tensor_type.shape.dim]
        width = sizes[-1] if sizes and sizes[-1] > 0 else self._first_width(graph)
        value = {graph_input.name: (np.eye(width), np.zeros(width))}
        for number, node in enumerate(graph.node, start=1):
            where = f"{self.path}: node {number}, {node.op_type}"
            try:
                self._step(node, value, where)
            except ValueError as error:
                if isinstance(error, InputError):
                    raise
                raise InputError(f"{where}: its sizes do not fit ({error}); export the network again") from error
        if self.hidden is None or graph.output[0].name not in value:
            raise InputError(f"{self.path}: no hidden layer of tanh or sigmoid leads to its output; give one")
        return Layers(*self.hidden, *value[graph.output[0].name], self.activation)

    def _step(self, node, value: dict, where: str) -> None:
        attributes = {item.name: self.onnx.helper.get_attribute_value(item) for item in node.attribute}
        if node.op_type == "Constant":
            self.constants[node.output[0]] = _number(self.onnx, attributes["value"])
            return
        names = [name for name in node.input if name]
        if node.op_type == "Transpose" and names[0] in self.constants:
            self.constants[node.output[0]] = self.constants[names[0]].T
            return
        moving = [name for name in names if name in value]
        if node.op_type in _PASSED and names[0] in self.constants:
            self.constants[node.output[0]] = self.constants[names[0]]
            return
        if len(moving) != 1:
            raise InputError(f"{where}: joins or begins branches; give a network of two layers in a row")
        a, b = value[moving[0]]
        if node.op_type in ACTIVATIONS:
            if self.hidden is not None:
                raise InputError(f"{where}: a second hidden layer; the core has one")
            self.hidden, self.activation = (a, b), node.op_type
            value.clear()  # what comes before it can't be used after it
            value[node.output[0]] = np.eye(len(b)), np.zeros(len(b))
            return
        value[node.output[0]] = self._affine(node.op_type, names, attributes, a, b, value, where)

    def _affine(self, kind: str, names: list[str], attributes: dict, a, b, value: dict, where: str):
        """A x + b after one node."""
        others = [self.constants.get(name) for name in names if name not in value]
        if kind in _PASSED:
            return a, b
        if any(item is None for item in others):
            raise InputError(f"{where}: takes a value that is no constant; export the network with its weights")
        first = names[0] in value
        if kind in ("Add", "Sub", "Mul", "Div"):
            return _elementwise(kind, a, b, others[0].reshape(-1) * np.ones(len(b)), first, where)
        if kind == "MatMul" and first:
            return others[0].T @ a, others[0].T @ b
        if kind == "Gemm" and first and not attributes.get("transA", 0):
            weights = (others[0] if attributes.get("transB", 0) else others[0].T) * attributes.get("alpha", 1.0)
            bias = attributes.get("beta", 1.0) * others[1].reshape(-1) if len(others) > 1 else 0.0
            return weights @ a, weights @ b + bias
        raise InputError(f"{where}: is not known here; give a network of two layers with tanh or sigmoid")

    def _first_width(self, graph) -> int:
        """Inputs, from the first matrix, where the file leaves the size open."""
        for node in graph.node:
            matrix = self.constants.get(node.input[1]) if node.op_type in ("Gemm", "MatMul") else None
            if matrix is not None and matrix.ndim == 2:
                is_turned = any(item.name == "transB" and item.i for item in node.attribute)
                return matrix.shape[1 if is_turned else 0]
        raise InputError(f"{self.path}: has no matrix of weights; give a network of two layers with tanh or sigmoid")


def _elementwise(kind: str, a, b, constant: np.ndarray, is_first: bool, where: str):
    if kind == "Add":
        return a, b + constant
    if kind == "Mul":
        return constant[:, None] * a, constant * b
    if kind == "Sub":
        return (a, b - constant) if is_first else (-a, constant - b)
    if not is_first:
        raise InputError(f"{where}: divides by the signal; give a network of two layers with tanh or sigmoid")
    return a / constant[:, None], b / constant
