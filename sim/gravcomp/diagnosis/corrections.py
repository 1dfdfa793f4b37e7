"""Corrections without physics: a table over one measured variable, a wave in time, a smooth function of all positions.

They compete with the effects in the search, so that an effect on no list is not given a wrong name, and they say
which variable it follows. Each acts on one axis and is linear in its values.
"""

from dataclasses import dataclass

import numpy as np
from sklearn.preprocessing import PolynomialFeatures

from gravcomp.logs.measurement import Measurement

_SURFACE_DEGREE = 3


@dataclass(frozen=True)
class Correction:
    """What the residual of one axis follows: ``variables`` for people, ``shape`` for the computation.

    kind "table": hat functions over knots of one variable, times the axis' direction if ``by_direction``;
    "line", "product": one or two variables as they are; "wave": sin and cos of a frequency in time, Hz;
    "step": another level from a time on; "surface": polynomial of all positions.
    """

    axis: int
    kind: str
    variables: tuple[str, ...]
    shape: tuple[float, ...] = ()
    by_direction: bool = False

    @property
    def label(self) -> str:
        return f"axis {self.axis + 1}: {' and '.join(self.variables)}"

    def columns(self, data: Measurement) -> np.ndarray:
        """Regressors (n, p) of this axis."""
        if self.kind == "wave":
            angle = 2.0 * np.pi * self.shape[0] * (data.t_s - data.t_s[0])
            return np.column_stack([np.sin(angle), np.cos(angle)])
        if self.kind == "step":
            return np.column_stack([data.t_s > self.shape[0], np.ones(len(data.t_s))]).astype(float)
        if self.kind == "surface":
            half = np.asarray(self.shape).reshape(2, -1)
            return PolynomialFeatures(_SURFACE_DEGREE).fit_transform((data.q - half[0]) / half[1])
        if self.kind == "product":
            return (variable(data, self.variables[0]) * variable(data, self.variables[1]))[:, None]
        x = variable(data, self.variables[0])
        if self.kind == "line":
            return x[:, None]
        hats = np.column_stack([np.interp(x, self.shape, hat) for hat in np.eye(len(self.shape))])
        return hats * data.direction[:, [self.axis]] if self.by_direction else hats


def variable(data: Measurement, name: str) -> np.ndarray:
    """A measured variable by the name that the report uses: q1, v1, dir1, f1 (model), a1, t, temp; (n,)."""
    if name == "t":
        return data.t_s
    if name == "temp":
        return data.temp_c
    stem, axis = name.rstrip("0123456789"), int(name.lstrip("abcdefghijklmnopqrstuvwxyz")) - 1
    source = {"q": "q", "v": "v", "dir": "direction", "f": "nominal", "a": "acceleration"}[stem]
    return getattr(data, source)[:, axis]


def variable_names(data: Measurement) -> list[str]:
    """Every measured variable that varies in this data."""
    axes = range(1, data.n_axes + 1)
    names = [f"q{i}" for i in axes] + [f"f{i}" for i in axes]
    if data.has_velocity:
        names += [f"v{i}" for i in axes] + [f"dir{i}" for i in axes]
    names += ["t"] + (["temp"] if data.temp_c is not None else [])
    return [name for name in names if np.ptp(variable(data, name)) > 0.0]


def candidates(data: Measurement) -> list[Correction]:
    """Every correction that the search tries, waves in time excepted: a scan of the residual proposes those."""
    out, n = [], len(data.t_s)
    sizes = (7, 15) if n >= 600 else (6,)
    for axis in range(data.n_axes):
        for name in variable_names(data):
            x = variable(data, name)
            if name.startswith("dir"):
                out.append(Correction(axis, "line", (name,)))
                continue
            if name not in ("t", "temp"):
                out.append(Correction(axis, "line", (name,)))
            fine = (30,) if n >= 600 and name == f"q{axis + 1}" else ()
            for size in sizes + fine:
                knots = _knots(x, size)
                if len(knots) < 3:
                    continue
                out.append(Correction(axis, "table", (name,), knots))
                if data.has_velocity and name[0] in "qf" and int(name[1:]) == axis + 1:
                    out.append(Correction(axis, "table", (name, f"dir{axis + 1}"), knots, by_direction=True))
        if data.n_axes > 1 and n >= 200 and data.n_axes <= 3:
            centre, half = data.q.mean(axis=0), np.ptp(data.q, axis=0) / 2
            if (half > 0).all():
                names = tuple(f"q{i + 1}" for i in range(data.n_axes))
                out.append(Correction(axis, "surface", names, (*centre, *half)))
        own = [f"q{axis + 1}"] + ([f"v{axis + 1}"] if data.has_velocity else [])
        others = [name for name in variable_names(data) if name[0] in "qvf" and name not in own]
        out += [Correction(axis, "product", (a, b)) for a in own for b in others]
    return out


def _knots(x: np.ndarray, size: int) -> tuple[float, ...]:
    uniform = np.linspace(x.min(), x.max(), size)
    filled = [uniform[0]]
    for knot in uniform[1:]:  # a knot only where at least a few samples lie between it and the last
        if np.count_nonzero((x > filled[-1]) & (x <= knot)) >= 4:
            filled.append(knot)
    filled[-1] = uniform[-1]  # no sample lies beyond: a straight line is always within the table
    return tuple(float(k) for k in filled)
