"""The end of a campaign: the table for the terminal, and report.html, one file with its pictures inside."""

import io

import numpy as np

from gravcomp.campaign.figures import Efforts
from gravcomp.campaign.journal import AFTER, BEFORE
from gravcomp.robot.machine import Machine
from gravcomp.robot.protocol import TellsOrientation

_PHASES = (BEFORE, AFTER)
_COLOURS = {BEFORE: "#b0413e", AFTER: "#2a6f97"}
_RC = {"svg.fonttype": "none", "font.family": "sans-serif", "font.size": 9, "svg.hashsalt": "campaign"}


def rows(content: dict) -> list[tuple[str, str, dict[str, float]]]:
    """Of what, when, and its errors: the rows of the table."""
    return [(name, phase, content[phase]["servo"][name])
            for name in ("all", "holds", "motion") for phase in _PHASES
            if phase in content and name in content[phase]["servo"]]  # fmt: skip


def outcome(content: dict) -> str:
    """What was loaded, or why nothing was."""
    if content["loaded"]:
        return f"loaded: image with CRC-32 {content['loaded']}"
    return f"nothing loaded: {content['not_loaded']}"


def text(content: dict) -> str:
    """The result for the terminal."""
    unit = content["unit"]
    between = content["between"]
    told = [f"measured in between, {between['steps']} steps: {between['why']}"] if between else []
    lines = [content["found"]["found"], *told, outcome(content),
             f"effort of the servo, what the feed-forward did not know, on {content['held_out']} held-out steps:",
             f"{'':16}{'RMS ' + unit:>10}{'max ' + unit:>10}{'ave %':>8}{'max %':>8}"]  # fmt: skip
    for name, phase, e in rows(content):
        lines.append(f"{name:8}{phase:8}{e['rms_n']:10.3f}{e['max_n']:10.3f}{e['ave_pct']:8.2f}{e['max_pct']:8.2f}")
    lines.append(f"noise of the measured currents {content['noise']:.3f} {unit} RMS, error of the network in the core "
                 f"{content['network']:.3f} {unit} RMS")  # fmt: skip
    for phase in _PHASES:
        if phase in content:
            own = content[phase]["tracking"]
            lines.append(f"tracking error at rest {phase}: {own['rms_counts']:.2f} counts RMS, {own['max_counts']:.1f}"
                         " at most")  # fmt: skip
    return "\n".join(lines)


def report_page(content: dict, phases: dict[str, Efforts], machine: Machine) -> str:
    """The page of a campaign."""
    import jinja2

    pages = jinja2.Environment(loader=jinja2.PackageLoader("gravcomp.campaign", "."), autoescape=True)
    figures = [_figure(phases, axis, machine) for axis in range(machine.n_axes)]
    robot = machine.robot
    maps = _maps(phases, robot, content["unit"]) if isinstance(robot, TellsOrientation) else None
    return pages.get_template("report.html.j2").render(
        r=content, rows=rows(content), outcome=outcome(content), figures=figures, maps=maps
    )


def _maps(phases: dict[str, Efforts], robot: TellsOrientation, unit: str) -> str:
    """Effort of the servo, RMS over the axes, over the orientation: each angle over the first, a column per phase."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    names = robot.orientation_names
    angles = {phase: np.rad2deg(robot.orientation(e.q)) for phase, e in phases.items()}
    size = {phase: np.sqrt(np.mean(e.servo**2, axis=1)) for phase, e in phases.items()}
    largest = max(own.max() for own in size.values())
    with mpl.rc_context({**_RC, "svg.hashsalt": "maps"}):
        figure = Figure(figsize=(10.5, 2.6 * (len(names) - 1)), layout="constrained")
        panels = figure.subplots(len(names) - 1, len(phases), sharex=True, sharey="row", squeeze=False)
        for column, phase in enumerate(phases):
            for row, panel in enumerate(panels[:, column]):
                x, y = angles[phase][:, 0], angles[phase][:, row + 1]
                dots = panel.scatter(x, y, c=size[phase], vmin=0.0, vmax=largest, s=9, cmap="viridis_r")
                panel.grid(color="#dddddd", lw=0.6)
                panel.set_axisbelow(True)
                if column == 0:
                    panel.set_ylabel(f"{names[row + 1]}, deg")
            panels[0, column].set_title(phase, fontsize=9)
            panels[-1, column].set_xlabel(f"{names[0]}, deg")
        figure.colorbar(dots, ax=panels, label=f"servo, RMS over axes, {unit}")
        return _svg(figure)


def _figure(phases: dict[str, Efforts], axis: int, machine: Machine) -> str:
    """Effort of the servo of one axis: at rest and in motion over its position, in motion over its velocity."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    unit, effort = machine.position_units[axis], {"m": "N", "rad": "Nm"}[machine.position_units[axis]]
    with mpl.rc_context({**_RC, "svg.hashsalt": f"campaign{axis}"}):  # ids of several figures in one page must differ
        figure = Figure(figsize=(10.5, 2.9), layout="constrained")
        panels = figure.subplots(1, 3, sharey=True)
        for phase, e in phases.items():
            for panel, x, own in zip(panels, (e.q, e.q, e.velocity), (e.is_hold, ~e.is_hold, ~e.is_hold), strict=True):
                panel.plot(x[own, axis], e.servo[own, axis], ".", ms=4, color=_COLOURS[phase], label=phase)
        names = (
            f"at rest, q{axis + 1}, {unit}",
            f"in motion, q{axis + 1}, {unit}",
            f"in motion, v{axis + 1}, {unit}/s",
        )
        for panel, name in zip(panels, names, strict=True):
            panel.set_xlabel(name)
            panel.locator_params(axis="x", nbins=5)
            panel.axhline(0.0, color="#888888", lw=0.6)
        panels[0].set_ylabel(f"servo, {effort}")
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper left", ncols=2, markerscale=2)
        return _svg(figure)


def _svg(figure) -> str:
    """The picture, to stand inside a page."""
    stream = io.StringIO()
    figure.savefig(stream, format="svg", metadata={"Date": None})
    svg = stream.getvalue()
    return svg[svg.index("<svg") :]
