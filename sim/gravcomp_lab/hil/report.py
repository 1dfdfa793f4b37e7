"""Tables and picture of the runs with gc_system in the loop."""

from collections.abc import Sequence

import numpy as np

from gravcomp_lab.hil.runs import Fault, Log, Run, rms, stop_after

Logs = Sequence[tuple[Run, Log]]
_NAMES = {False: "servo alone", True: "servo and network"}
_COLOURS = {False: "tab:red", True: "tab:blue"}
_STYLES = {Fault.ESTOP: "-", Fault.ENCODER: "--"}


def tracking_table(runs: Logs) -> str:
    """Markdown: errors and forces of the runs without a fault, phase by phase."""
    lines = [
        "| | | error RMS, um | error max, um | servo RMS, N | servo max, N | motors RMS, N |",
        "|---|---|---|---|---|---|---|",
    ]
    for phase in [name for name, chosen in runs[0][0].phases(runs[0][1].t_s).items() if chosen.any()]:
        for run, log in runs:
            chosen = run.phases(log.t_s)[phase]
            error_um, servo_n, motor_n = 1e6 * log.error_m()[chosen], log.servo_n[chosen], log.motor_n()[chosen]
            lines.append(
                f"| {phase} | {_NAMES[run.uses_network]} | {rms(error_um):.2f} | {np.abs(error_um).max():.2f} "
                f"| {rms(servo_n):.2f} | {np.abs(servo_n).max():.2f} | {rms(motor_n):.2f} |"
            )
    return "\n".join(lines)


def stop_table(runs: Logs) -> str:
    """Markdown: how the runs with a fault came to rest."""
    lines = [
        "| fault | brake closes in, ms | clocks to the brakes' pins | platform still after, ms | carriages go on, um "
        "| platform at the fault, mrad/s | at the end, mrad/s |",
        "|---|---|---|---|---|---|---|",
    ]
    for run, log in runs:
        stop = stop_after(run, log)
        lines.append(
            f"| {run.fault} | {1e3 * run.closing_s:.0f} | {log.reaction_clocks} | {1e3 * stop.still_s:.0f} "
            f"| {1e6 * stop.drop_m:.0f} | {1e3 * stop.speed:.1f} | {1e3 * stop.last_speed:.4f} |"
        )
    return "\n".join(lines)


def picture(tracked: Logs, stopped: Logs):
    """Error and force of the servo over time; path and speed after the faults. Returns a Matplotlib figure."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 6.5), layout="constrained")
    (error, path), (force, speed) = figure.subplots(2, 2, sharex="col")
    for run, log in tracked:
        style = {"color": _COLOURS[run.uses_network], "label": _NAMES[run.uses_network]}
        error.semilogy(log.t_s, np.maximum(1e6 * np.abs(log.error_m()).max(axis=1), 0.01), **style)
        force.plot(log.t_s, np.abs(log.servo_n).max(axis=1), **style)
    run = tracked[0][0]
    for axes in (error, force):
        for step in run.steps:
            axes.axvspan(
                step.start_s, step.end_s, color="0.82", zorder=0, label="step" if step is run.steps[0] else None
            )
        axes.axvspan(run.move.start_s, run.move.end_s, color="0.92", zorder=0, label="moving slowly")
        axes.legend(fontsize="small")
    error.set(title="Tracking error, worst axis", ylabel="um")
    force.set(title="Force of the servo, worst axis", ylabel="N", xlabel="time since the brakes opened, s")
    for run, log in stopped:
        after_ms = 1e3 * (log.t_s - run.fault_s)
        way_um = 1e6 * np.abs(log.q_m - log.q_m[np.argmax(after_ms >= 0)]).max(axis=1)
        shown = (after_ms > -10) & (after_ms < 50)
        style = {"label": f"{run.fault}, brakes close in {1e3 * run.closing_s:.0f} ms", "linestyle": _STYLES[run.fault]}
        path.plot(after_ms[shown], way_um[shown], **style)
        speed.semilogy(after_ms[shown], 1e3 * log.speed[shown], **style)
    path.set(title="Distance from where the fault came, worst axis", ylabel="um")
    speed.set(title="Angular speed of the platform", ylabel="mrad/s", xlabel="time since the fault, ms")
    path.legend(fontsize="small")
    for axes in figure.axes:
        axes.grid(alpha=0.3)
    return figure
