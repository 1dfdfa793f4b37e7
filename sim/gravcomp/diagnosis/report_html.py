"""report.html: one file, its figures inside."""

import base64
import io

import jinja2
import numpy as np

from gravcomp.diagnosis.candidate import Variable, variables
from gravcomp.diagnosis.diagnosis import Diagnosis
from gravcomp.diagnosis.report import report

_PAGES = jinja2.Environment(loader=jinja2.PackageLoader("gravcomp.diagnosis", "."), autoescape=True)
_MAX_POINTS = 4000
_BEFORE, _AFTER = "#b0413e", "#2a6f97"


def report_html(d: Diagnosis) -> str:
    """The page."""
    corrections = [(entry.name, d.shares[entry.name]) for entry in d.fit.corrections]
    figures = [_figure(d, axis) for axis in range(d.data.n_axes)]
    page = _PAGES.get_template("report.html.j2")
    return page.render(name=d.data.name, r=report(d), corrections=corrections, untestable=d.untestable, figures=figures)


def _figure(d: Diagnosis, axis: int) -> str:
    from matplotlib.figure import Figure  # here, because whoever only diagnoses draws nothing

    own = [x for x in variables(d.data) if x.axis in (None, axis) and x.kind in ("t", "q", "v", "f", "temp")]
    figure = Figure(figsize=(4.2 * len(own), 3.6), layout="constrained")
    rows = np.flatnonzero(d.is_test)
    rows = rows[:: max(len(rows) // _MAX_POINTS, 1)]
    for panel, variable in zip(np.atleast_1d(figure.subplots(1, len(own), sharey=True)), own, strict=True):
        x = variable.of(d.data)[rows]
        panel.plot(x, d.before[rows, axis], ".", ms=2, color=_BEFORE, label="before")
        panel.plot(x, d.after[rows, axis], ".", ms=2, color=_AFTER, label="after")
        panel.set_xlabel(_axis_label(d, variable))
        panel.axhline(0.0, color="k", lw=0.5)
    figure.axes[0].set_ylabel(f"residual of axis {axis + 1}, {d.data.unit} (held out)")
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside upper right", ncols=2, markerscale=5)
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=90)
    return base64.b64encode(stream.getvalue()).decode()


def _axis_label(d: Diagnosis, variable: Variable) -> str:
    if variable.axis is None:
        return {"t": "time, s", "temp": "temperature, °C"}[variable.kind]
    unit = d.data.position_units[variable.axis]
    about = {"q": f"position {{}}, {unit}", "v": f"velocity {{}}, {unit}/s", "f": f"model {{}}, {d.data.unit}"}
    return about[variable.kind].format(variable)
