"""Networks as ONNX files, as PyTorch, Keras and MATLAB export them."""

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

RNG = np.random.default_rng(1)
W, B, V, C = RNG.normal(size=(9, 2)), RNG.normal(size=9), RNG.normal(size=(2, 9)), RNG.normal(size=2)


def write(path, nodes, constants, width=2):
    """An ONNX file of nodes (kind, names in, name out, attributes) from x to y."""
    made = [helper.make_node(kind, ins, [out], **more) for kind, ins, out, more in nodes]
    tensors = [numpy_helper.from_array(np.asarray(value, dtype=np.float32), name) for name, value in constants.items()]
    ends = [helper.make_tensor_value_info(name, TensorProto.FLOAT, ["batch", width]) for name in ("x", "y")]
    onnx.save(helper.make_model(helper.make_graph(made, "g", ends[:1], ends[1:], tensors)), str(path))
    return path


def torch_like(path, act="Tanh", w=W, b=B, v=V, c=C, width=2):
    nodes = [
        ("Gemm", ["x", "w", "b"], "a", {"transB": 1}),
        (act, ["a"], "h", {}),
        ("Gemm", ["h", "v", "c"], "y", {"transB": 1}),
    ]
    return write(path, nodes, {"w": w, "b": b, "v": v, "c": c}, width)
