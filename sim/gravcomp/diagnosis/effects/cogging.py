"""Force ripple over position: teeth and magnets of a motor."""

import numpy as np

from gravcomp.core.compensation import MAX_HARMONIC, no_compensation
from gravcomp.diagnosis.candidate import Parameter, on_axis
from gravcomp.diagnosis.effects.base import Effect
from gravcomp.diagnosis.search.periodogram import find_lines, pitch_of
from gravcomp.diagnosis.thresholds import DIVISORS, WAVE_SEEN
from gravcomp.errors import InputError


class Cogging(Effect):
    """Sum over harmonics h of A_ih sin(2 pi h q_i/pitch + p_ih)."""

    name = "cogging"
    driver = "q"
    equation = "sum over h of A_ih sin(2 pi h q_i/pitch + p_ih)"
    hardware = "compensator"
    units = {"amplitude": "[f]", "phase": "rad", "pitch": "[q]"}  # noqa: RUF012
    complexity = "general"
    shared = ("pitch",)
    scales = ("pitch",)
    is_scanned = True

    def shapes(self, data):
        return []

    def scanned_shapes(self, data, rows, residual):
        """Pitch and harmonics that all axes together, and each alone, show over their positions; the strongest line as
        the fundamental, and as a harmonic of a longer pitch.
        """
        q = data.q[rows]
        span = np.ptp(q, axis=0).max()
        turn = 2.0 * np.pi if data.position_units and data.position_units[0] == "rad" else None
        lines = [find_lines(q, residual)]
        lines += [find_lines(q[:, [i]], residual[:, [i]]) for i in range(data.n_axes) if data.n_axes > 1]
        found = {pitch_of(own, span, turn, divisors) for own in lines for divisors in (1, DIVISORS)}
        seen = [
            (pitch, tuple(h for h in own if pitch / h > WAVE_SEEN * data.spacing.max()))
            for pitch, own in filter(None, found)
        ]
        return {(("pitch", pitch), ("harmonics", harmonics)) for pitch, harmonics in seen if harmonics}

    def columns(self, data, shape):
        out = {}
        for i in range(data.n_axes):
            for h in shape["harmonics"]:
                angle = 2.0 * np.pi * h * data.q[:, i] / shape["pitch"]
                out[Parameter("sin", i, h)] = on_axis(data, i, np.sin(angle))
                out[Parameter("cos", i, h)] = on_axis(data, i, np.cos(angle))
        return out

    def groups(self, labels):
        waves = dict.fromkeys((label.axis, label.harmonic) for label in labels)
        return [{Parameter(stem, *wave) for stem in ("sin", "cos")} for wave in waves]

    def parameters(self, shape, coefficients):
        out = {Parameter("pitch"): shape["pitch"]}
        for label, a in coefficients.items():
            if label.stem == "sin":
                b = coefficients[Parameter("cos", label.axis, label.harmonic)]
                out[Parameter("amplitude", label.axis, label.harmonic)] = float(np.hypot(a, b))
                out[Parameter("phase", label.axis, label.harmonic)] = float(np.arctan2(b, a))
        return out

    def predict(self, data, parameters):
        force = np.zeros(data.shape)
        for axis, harmonic, amplitude, phase in _waves(parameters):
            angle = 2.0 * np.pi * harmonic * data.q[:, axis] / parameters["pitch"]
            force[:, axis] += amplitude * np.sin(angle + phase)
        return force

    def constants(self, data, parameters):
        waves = no_compensation(data.n_axes)
        for axis, harmonic, amplitude_n, phase in _waves(parameters):
            if harmonic > MAX_HARMONIC:
                raise InputError(
                    f"effect cogging: harmonic {harmonic} is above {MAX_HARMONIC}; delete it from the model"
                )
            waves.amplitude[axis, harmonic - 1], waves.phase_rad[axis, harmonic - 1] = amplitude_n, phase
        return {
            "pitch": np.full(data.n_axes, parameters["pitch"]),
            "amplitude": waves.amplitude,
            "phase_rad": waves.phase_rad,
        }


def _waves(parameters) -> list[tuple[int, int, float, float]]:
    """Axis, harmonic, amplitude and phase of each wave."""
    own = [Parameter.parse(name) for name in parameters]
    return [
        (name.axis, name.harmonic, parameters[name], parameters[Parameter("phase", name.axis, name.harmonic)])
        for name in own
        if name.stem == "amplitude"
    ]
