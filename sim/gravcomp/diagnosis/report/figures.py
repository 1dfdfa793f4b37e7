"""Figures of report.html, as SVG whose letters are text: residuals before and after, over what was measured."""

import io
from collections import Counter
from collections.abc import Iterable

import numpy as np

from gravcomp.diagnosis.candidate import Variable, variables
from gravcomp.diagnosis.diagnosis import Diagnosis

_MAX_POINTS = 4000
_BEFORE, _AFTER = "#b0413e", "#2a6f97"
_PANELS = 4  # beside one another at most
_MOST_DRIVERS = 6
_SMALL = 1e-3  # of its size: a range as small is shown from its middle
_FEW = 3  # values of a variable that are ticked as they are
_RC = {"svg.fonttype": "none", "font.family": "sans-serif", "font.size": 9, "axes.formatter.limits": (-3, 4),
       "axes.formatter.useoffset": False}  # fmt: skip


def driver_figure(d: Diagnosis) -> str:
    """The residual over the drivers, before and after, each effect's strongest first; empty without drivers."""
    ranks = Counter()
    ranked = []
    for item in sorted(d.drivers, key=lambda item: -item["share"]):
        ranked.append((ranks[item["of"]], item))
        ranks[item["of"]] += 1
    ranked.sort(key=lambda pair: pair[0])
    wanted = dict.fromkeys((item["axis"] - 1, item["variable"]) for _, item in ranked)
    own = [(axis, Variable.parse(name)) for axis, name in list(wanted)[:_MOST_DRIVERS]]
    own = [(axis, variable) for axis, variable in own if variable.is_in(d.data)]
    return _figure(d, own, "drivers") if own else ""


def axis_figure(d: Diagnosis, axis: int) -> str:
    """The residual of one axis over time and its own position, velocity, effort, and the temperature."""
    own = [x for x in variables(d.data) if x.axis in (None, axis) and x.kind in ("t", "q", "v", "f", "temp")]
    return _figure(d, [(axis, variable) for variable in own], f"axis{axis + 1}")


def _figure(d: Diagnosis, panels: Iterable[tuple[int, Variable]], name: str) -> str:
    import matplotlib as mpl
    from matplotlib.figure import Figure

    panels = list(panels)
    n_columns = min(max(len(panels), 3), _PANELS) if len(panels) != 6 else 3
    n_rows = -(-len(panels) // n_columns)
    with mpl.rc_context({**_RC, "svg.hashsalt": name}):  # ids of several figures in one page must differ
        figure = Figure(figsize=(10.5, 2.7 * n_rows + 0.3), layout="constrained")
        axes = figure.subplots(n_rows, n_columns, squeeze=False).ravel()
        for panel, (axis, variable) in zip(axes, panels, strict=False):
            _draw(panel, d, axis, variable)
        for panel in axes[len(panels) :]:
            panel.remove()
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper left", ncols=2, markerscale=5)
        stream = io.StringIO()
        figure.savefig(stream, format="svg", dpi=110, metadata={"Date": None})
    svg = stream.getvalue()
    return svg[svg.index("<svg") :]


def _draw(panel, d: Diagnosis, axis: int, variable: Variable) -> None:
    rows = np.flatnonzero(d.is_test & ~d.left_out[:, axis])
    rows = rows[:: max(len(rows) // _MAX_POINTS, 1)]
    x, label = variable.of(d.data)[rows], _label(d, variable)
    if np.ptp(x) < _SMALL * np.abs(x).max() and np.ptp(x) > 0.0:  # of such numbers only differences can be read
        middle = float(np.median(x))
        x, label = x - middle, f"{label}, from {middle:.8g}"
    values = np.unique(x)
    spread = 0.06 * (np.ptp(values) or 1.0) if len(values) <= _FEW else 0.0  # else all points lie on one another
    x = x + spread * np.random.default_rng(0).uniform(-1.0, 1.0, len(x))
    panel.plot(x, d.before[rows, axis], ".", ms=2, color=_BEFORE, label="before", rasterized=True)
    panel.plot(x, d.after[rows, axis], ".", ms=2, color=_AFTER, label="after", rasterized=True)
    panel.axhline(0.0, color="k", lw=0.5)
    _tick(panel, values)
    panel.set_xlabel(label)
    panel.set_ylabel(f"residual of axis {axis + 1}, {d.data.effort_units[axis]}")


def _tick(panel, values: np.ndarray) -> None:
    """Few ticks, that never run into one another: those of a variable of few values at these, if they lie apart."""
    from matplotlib.ticker import MaxNLocator

    panel.yaxis.set_major_locator(MaxNLocator(5))
    reach = np.ptp(values)
    apart = len(values) <= _FEW and (reach == 0.0 or np.diff(values).min() > 0.3 * reach)
    if apart:
        panel.set_xticks(values, [f"{value:.4g}" for value in values])
    else:
        panel.xaxis.set_major_locator(MaxNLocator(3))


def _label(d: Diagnosis, variable: Variable) -> str:
    if variable.axis is None:
        return {"t": "time, s", "temp": "temperature, °C"}[variable.kind]
    unit, effort = d.data.position_units[variable.axis], d.data.effort_units[variable.axis]
    about = {"q": f"position {{}}, {unit}", "v": f"velocity {{}}, {unit}/s", "dir": "direction {}",
             "f": f"model {{}}, {effort}", "a": f"acceleration {{}}, {unit}/s²"}  # fmt: skip
    return about[variable.kind].format(variable)
