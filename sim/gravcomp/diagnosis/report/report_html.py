"""report.html: one file, its figures inside."""

from gravcomp.diagnosis.diagnosis import Diagnosis
from gravcomp.diagnosis.report.figures import axis_figure, driver_figure
from gravcomp.diagnosis.report.report import by_reason, error_rows

# Okabe and Ito, 2008: told apart by every eye; what has no name is grey.
_COLOURS = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#d55e00", "#56b4e9", "#f0e442", "#000000")
_GREYS = ("#777777", "#999999", "#5f5f5f", "#ababab")
_LEFT = "#e4e4e4"
_SEEN = 0.002  # of an axis: a thinner part is no picture


def report_html(d: Diagnosis, content: dict) -> str:
    """The page of a diagnosis and its report."""
    import jinja2

    pages = jinja2.Environment(loader=jinja2.PackageLoader("gravcomp.diagnosis.report", "."), autoescape=True)
    return pages.get_template("report.html.j2").render(
        name=d.data.name, r=content, rows=error_rows(content), bars=_bars(content), legend=_legend(content),
        untestable=by_reason(content["untestable"]), drivers=driver_figure(d), position_units=d.data.position_units,
        figures=[axis_figure(d, axis) for axis in range(d.data.n_axes)],
    )  # fmt: skip


def _legend(content: dict) -> list[dict]:
    """Name, colour and part of the whole of everything that explains, and of what nothing explains."""
    out, used = [], {"effect": 0, "correction": 0, "left": 0}
    for own in content["contributions"]:
        colours = {"effect": _COLOURS, "correction": _GREYS, "left": (_LEFT,)}[own["kind"]]
        out.append({**own, "colour": colours[used[own["kind"]] % len(colours)]})
        used[own["kind"]] += 1
    return out


def _bars(content: dict) -> list[dict]:
    """Per axis the parts that explain it, as widths in per cent of the bar; parts below zero take from none."""
    legend, out = _legend(content), []
    for i, axis in enumerate(content["by_axis"]):
        parts = [(own, max(own["by_axis"][i], 0.0)) for own in legend]
        total = sum(part for _, part in parts) or 1.0
        shown = [{"name": own["name"], "colour": own["colour"], "percent": 100.0 * part / total}
                 for own, part in parts if part > _SEEN]  # fmt: skip
        out.append({**axis, "parts": shown})
    return out
