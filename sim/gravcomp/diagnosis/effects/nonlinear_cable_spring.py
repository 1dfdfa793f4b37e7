"""A cable or hose that pulls harder the farther it is bent, and perhaps otherwise on its way back."""

import numpy as np
from numpy.polynomial import Polynomial

from gravcomp.diagnosis.candidate import Parameter, axes_in, on_axis, per_axis
from gravcomp.diagnosis.effects.base import Effect, needs_velocity

_POWERS = range(5)  # order 4: what users fit to such cables


class NonlinearCableSpring(Effect):
    """k0_i + k1_i q_i + ... + k4_i q_i^4."""

    name = "nonlinear_cable_spring"
    driver = "q"
    equation = "k0_i + k1_i q_i + ... + k4_i q_i^4, and by direction (h0_i + h1_i q_i + ... + h4_i q_i^4) sign(v_i)"
    hardware = "network"
    units = {f"{stem}{n}": ("[f]", "[f]/[q]")[n] if n < 2 else f"[f]/[q]^{n}" for stem in "kh" for n in _POWERS}  # noqa: RUF012
    complexity = "rarer"
    special_case = "cable_spring"

    def shapes(self, data):
        """Middle and half range of each axis: powers of what lies between are nearly independent."""
        low, high = data.q.min(axis=0), data.q.max(axis=0)
        axes = [i for i in range(data.n_axes) if len(np.unique(data.poses[:, i])) >= len(_POWERS)]
        shape = {Parameter("middle", i): float(low[i] + high[i]) / 2 for i in axes}
        return [shape | {Parameter("half", i): float(high[i] - low[i]) / 2 for i in axes}] if axes else []

    def columns(self, data, shape):
        out = {}
        for i in axes_in(shape, "middle"):
            x = (data.q[:, i] - shape[Parameter("middle", i)]) / shape[Parameter("half", i)]
            out |= {Parameter(f"k{n}", i): on_axis(data, i, x**n) for n in _POWERS}
        return out

    def parameters(self, shape, coefficients):
        """Coefficients of the powers of q itself."""
        out = {}
        for i in axes_in(shape, "middle"):
            half = shape[Parameter("half", i)]
            x = Polynomial([-shape[Parameter("middle", i)] / half, 1.0 / half])
            for stem in "kh":
                own = [coefficients.get(Parameter(f"{stem}{n}", i), 0.0) for n in _POWERS]
                if any(own):
                    out |= {Parameter(f"{stem}{n}", i): float(c) for n, c in enumerate(Polynomial(own)(x).coef)}
        return out

    def predict(self, data, parameters):
        force = _polynomial(data, parameters, "k")
        if data.has_velocity:
            force += _polynomial(data, parameters, "h") * data.direction
        return force

    def groups(self, labels):
        """Axes, and before them what an offset beside it has too."""
        level = [{label} for label in labels if label.stem == "k0"]
        return level + super().groups(labels)

    def constants(self, data, parameters):
        """What goes with the direction is friction: its mean over the positions in the data."""
        friction = _polynomial(data, parameters, "h").mean(axis=0)
        return {"fc_pos": friction, "fc_neg": friction}


class DirectionalNonlinearCableSpring(NonlinearCableSpring):
    """The same with one polynomial for each direction, k +- h: the cable rubs where it bends.

    No column is constant in a direction: friction that is the same everywhere is Coulomb friction.
    """

    complexity = "most general"

    unavailable = staticmethod(needs_velocity)

    def columns(self, data, shape):
        even = super().columns(data, shape)
        bent = [label for label in even if label.stem != "k0"]
        odd = {Parameter(f"h{label.stem[1:]}", label.axis): even[label] * data.direction for label in bent}
        return even | odd


def _polynomial(data, parameters, stem: str) -> np.ndarray:
    """Sum of its powers, (n, k)."""
    return sum(per_axis(parameters, f"{stem}{n}", data.n_axes) * data.q**n for n in _POWERS)
