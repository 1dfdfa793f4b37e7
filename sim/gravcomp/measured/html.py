"""report.html: one file, its figures inside."""

import base64
import io

import jinja2
import numpy as np
from matplotlib.figure import Figure

from gravcomp.measured.diagnosis import Diagnosis
from gravcomp.measured.empirical import variable, variable_names
from gravcomp.measured.report import report

_TEMPLATE = jinja2.Template(
    """<!doctype html><html lang="en"><head><meta charset="utf-8"><title>Diagnosis of {{ name }}</title><style>
body{font-family:sans-serif;max-width:64em;margin:2em auto;padding:0 1em}table{border-collapse:collapse;margin:1em 0}
td,th{border:1px solid #bbb;padding:.25em .7em;text-align:right}td:first-child,th:first-child{text-align:left}
img{max-width:100%}</style></head><body>
<h1>Diagnosis of {{ name }}</h1>
<p>Verdict: <b>{{ r.verdict }}</b>. {{ r.n_train }} samples trained, {{ r.n_test }} held out.
Noise floor {{ '%.4g' % r.noise_floor_n }} {{ r.unit }}.</p>
<table><tr><th>held out</th><th>RMS {{ r.unit }}</th><th>max {{ r.unit }}</th><th>average %</th><th>max %</th></tr>
{% for row in ('before', 'after') %}<tr><td>{{ row }}</td><td>{{ '%.4g' % r[row].rms_n }}</td>
<td>{{ '%.4g' % r[row].max_n }}</td><td>{{ '%.3g' % r[row].ave_pct }}</td><td>{{ '%.3g' % r[row].max_pct }}</td></tr>
{% endfor %}</table>
<h2>Effects</h2>{% if not r.effects %}<p>None named.</p>{% endif %}
{% for e in r.effects %}<h3>{{ e.name }}</h3><p>{{ '%.1f' % (100 * e.share) }} % of the held-out residual's variance,
p = {{ '%.2g' % e.p_value }}.</p><table><tr><th>parameter</th><th>value</th><th>95 % interval</th></tr>
{% for p, v in e.params.items() %}<tr><td>{{ p }}</td><td>{{ '%.5g' % v }}</td>
<td>{{ '%.5g' % e.ci95[p][0] }} .. {{ '%.5g' % e.ci95[p][1] }}</td></tr>{% endfor %}</table>{% endfor %}
{% if corrections %}<h2>Empirical corrections</h2><p>No physics is claimed for these.</p>
<table><tr><th>follows</th><th>share %</th></tr>{% for label, share in corrections %}<tr><td>{{ label }}</td>
<td>{{ '%.1f' % (100 * share) }}</td></tr>{% endfor %}</table>{% endif %}
{% if r.alternatives %}<h2>Cannot be told apart on this data</h2><ul>
{% for names in r.alternatives %}<li>{{ names | join(', ') }}</li>{% endfor %}</ul>{% endif %}
{% if r.drivers %}<h2>What the residual follows</h2><table><tr><th>axis</th><th>variable</th><th>share %</th></tr>
{% for d in r.drivers %}<tr><td>{{ d.axis }}</td><td>{{ d.variable }}</td><td>{{ '%.1f' % (100 * d.share) }}</td></tr>
{% endfor %}</table>{% endif %}
{% if untestable %}<h2>Not testable on this data</h2><ul>
{% for n, why in untestable.items() %}<li>{{ n }}: {{ why }}</li>{% endfor %}</ul>{% endif %}
<h2>Residual</h2>{% for f in figures %}<img alt="residual before and after" src="data:image/png;base64,{{ f }}">
{% endfor %}</body></html>
""",
    autoescape=True,
)
_MAX_POINTS = 4000
_BEFORE, _AFTER = "#b0413e", "#2a6f97"


def report_html(d: Diagnosis) -> str:
    """The page."""
    corrections = [(entry.name, d.shares[entry.key]) for entry in d.fit.corrections]
    figures = [_figure(d, axis) for axis in range(d.data.n_axes)]
    return _TEMPLATE.render(name=d.data.name, r=report(d), corrections=corrections, untestable=d.untestable,
                            figures=figures)  # fmt: skip


def _figure(d: Diagnosis, axis: int) -> str:
    own = [n for n in variable_names(d.data) if n in ("t", f"q{axis + 1}", f"v{axis + 1}", f"f{axis + 1}", "temp")]
    figure = Figure(figsize=(4.2 * len(own), 3.6), layout="constrained")
    rows = np.flatnonzero(d.is_test)
    rows = rows[:: max(len(rows) // _MAX_POINTS, 1)]
    for panel, name in zip(np.atleast_1d(figure.subplots(1, len(own), sharey=True)), own, strict=True):
        x = variable(d.data, name)[rows]
        panel.plot(x, d.before[rows, axis], ".", ms=2, color=_BEFORE, label="before")
        panel.plot(x, d.after[rows, axis], ".", ms=2, color=_AFTER, label="after")
        panel.set_xlabel(_axis_label(d, name))
        panel.axhline(0.0, color="k", lw=0.5)
    figure.axes[0].set_ylabel(f"residual of axis {axis + 1}, {d.data.unit} (held out)")
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside upper right", ncols=2, markerscale=5)
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=90)
    return base64.b64encode(stream.getvalue()).decode()


def _axis_label(d: Diagnosis, name: str) -> str:
    if name in ("t", "temp"):
        return {"t": "time, s", "temp": "temperature, °C"}[name]
    unit = d.data.position_units[int(name[1:]) - 1]
    known = {"q": f"position {name}, {unit}", "v": f"velocity {name}, {unit}/s", "f": f"model {name}, {d.data.unit}"}
    return known[name[0]]
