"""Force ripple over position: teeth and magnets of a motor."""

import numpy as np

from gravcomp.diagnosis.effects.base import Effect, axis_of, on_axis


class Cogging(Effect):
    """Sum over harmonics h of A_ih sin(2 pi h q_i/pitch + p_ih)."""

    name = "cogging"
    follows = "q"
    equation = "sum over h of A_ih sin(2 pi h q_i/pitch + p_ih)"
    hardware = "compensator"
    units = {"amplitude": "[f]", "phase": "rad", "pitch": "[q]"}  # noqa: RUF012
    complexity = 6.0

    def __init__(self):
        self.found: list[dict] = []  # pitch and harmonics that the scan of the residual proposes

    def shapes(self, data):
        return self.found

    def columns(self, data, shape):
        out = {}
        for i in range(data.n_axes):
            for h in shape["harmonics"]:
                angle = 2.0 * np.pi * h * data.q[:, i] / shape["pitch"]
                out[f"sin_{i + 1}_h{h}"] = on_axis(data, i, np.sin(angle))
                out[f"cos_{i + 1}_h{h}"] = on_axis(data, i, np.cos(angle))
        return out

    def groups(self, labels):
        return [{f"sin_{tail}", f"cos_{tail}"} for tail in dict.fromkeys(label.split("_", 1)[1] for label in labels)]

    def parameters(self, shape, coefficients):
        out = {"pitch": shape["pitch"]}
        for label, a in coefficients.items():
            if label.startswith("sin_"):
                tail = label.removeprefix("sin_")
                b = coefficients[f"cos_{tail}"]
                out |= {f"amplitude_{tail}": float(np.hypot(a, b)), f"phase_{tail}": float(np.arctan2(b, a))}
        return out

    def predict(self, data, parameters):
        force = np.zeros(data.shape)
        for label, amplitude in parameters.items():
            if label.startswith("amplitude_"):
                tail, i = label.removeprefix("amplitude_"), axis_of(label)
                angle = 2.0 * np.pi * int(tail.split("_h")[1]) * data.q[:, i] / parameters["pitch"]
                force[:, i] += amplitude * np.sin(angle + parameters[f"phase_{tail}"])
        return force
