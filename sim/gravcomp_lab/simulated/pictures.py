"""Pictures of the proof: maps of the force error over the workspace, and a simulated run read from its VCD."""

import io
from collections.abc import Callable
from pathlib import Path

import numpy as np

from gravcomp.core.formats import FixedNetwork
from gravcomp.errors import InputError
from gravcomp.files import write_atomically
from gravcomp.robot.machine import EFFORT_UNITS, MAX_AXES, Machine
from gravcomp.robot.spheiro.robot import Spheiro, spheiro_of
from gravcomp.robot.spheiro.workspace import pose
from gravcomp.twin import network as bittrue
from gravcomp_lab.simulated.poses import counts_at

RUN_SCOPE = "gc_force_path_bench.i_force_path"
SIGNALS = ("pin_a", "pin_b", "sts_count", "in_valid", "out_valid", "out_force")
SHOWN_AXIS = 1  # the fastest one of the motion
AXIS_COLOURS = tuple(f"C{k}" for k in range(MAX_AXES))


def save_figure(figure, path: Path) -> None:
    """Write a Matplotlib figure as PNG, whole or not at all."""
    image = io.BytesIO()
    figure.savefig(image, format="png", dpi=120, bbox_inches="tight")
    write_atomically(path, image.getvalue())


def error_picture(fixed: FixedNetwork, machine: Machine):
    """Maps of the error of the Sphe.I.Ro., of any other robot the spread of each axis' error. A Matplotlib figure."""
    return error_maps(fixed, machine) if isinstance(machine.robot, Spheiro) else error_spread(fixed, machine)


def error_spread(fixed: FixedNetwork, machine: Machine, n_poses: int = 8000, seed: int = 21):
    """Error of the fixed-point core against the statics over the workspace, a histogram per axis. Returns a figure."""
    from matplotlib.figure import Figure

    counts = machine.drive.counts(machine.robot.workspace(n_poses, seed))
    statics = machine.robot.forces(machine.drive.positions(counts))
    error = bittrue.core(counts, fixed).force_mn / 1000.0 - statics
    figure = Figure(figsize=(11, 2.0 * machine.n_axes), layout="constrained")
    panels = figure.subplots(machine.n_axes, 1, squeeze=False)[:, 0]
    for axes, own, values, axis in zip(panels, error.T, statics.T, machine.axes, strict=True):
        axes.hist(own, bins=101)
        rms, unit = np.sqrt(np.mean(own**2)), EFFORT_UNITS[axis.unit]
        axes.set_title(
            f"{axis.name}: RMS {rms:.2g} {unit} of {np.sqrt(np.mean(values**2)):.3g}, largest {np.abs(own).max():.2g}",
            fontsize=9,
        )
        axes.set_yticks([])
        axes.set_xlabel(f"error, {unit}", fontsize=8)
    figure.suptitle(f"Error of the core against the statics, {n_poses} poses of the workspace, seed {seed}")
    return figure


def error_maps(fixed: FixedNetwork, machine: Machine, torsions_deg=(0.0, 15.0)):
    """Norm of the force error of the fixed-point core against the statics over azimuth and tilt, one map per torsion.

    The maps of the paper's figures 6 and 7. Returns a Matplotlib figure.
    """
    from matplotlib.figure import Figure

    azimuth = np.linspace(0.0, 2.0 * np.pi, 181)
    tilt_deg = np.linspace(0.0, spheiro_of(machine).tilt_max_deg, 71)
    error = [_error_norm(fixed, machine, azimuth, tilt_deg, torsion) for torsion in torsions_deg]
    figure = Figure(figsize=(11, 5.2), layout="constrained")
    top = max(float(e.max()) for e in error)
    for k, (norm, torsion) in enumerate(zip(error, torsions_deg, strict=True)):
        axes = figure.add_subplot(1, len(error), k + 1, projection="polar")
        mesh = axes.pcolormesh(azimuth, tilt_deg, norm, vmin=0.0, vmax=top, cmap="viridis", shading="gouraud")
        axes.set_title(f"torsion {torsion:.0f}°: mean {norm.mean():.3f} N, largest {norm.max():.3f} N")
        axes.set_yticks([10, 20, 30], ["10°", "20°", "30°"], color="white")
        axes.grid(color="white", alpha=0.3)
    figure.colorbar(mesh, ax=figure.axes, label="|force error| of the core against the statics, N")
    figure.suptitle("Error over the workspace: angle is the azimuth, radius the tilt")
    return figure


def _error_norm(fixed, machine, azimuth, tilt_deg, torsion_deg) -> np.ndarray:
    rotation = pose(azimuth[None, :], np.deg2rad(tilt_deg)[:, None], np.deg2rad(torsion_deg))
    counts = counts_at(rotation, machine)
    statics_n = machine.robot.forces(machine.drive.positions(counts))
    return np.linalg.norm(bittrue.core(counts, fixed).force_mn / 1000.0 - statics_n, axis=-1)


def run_picture(vcd: Path, n_axes: int, force_bits: int, unit: str):
    """A run of gc_force_path from its VCD: counts and forces of the whole run, pins and handshake of one inference.

    unit: of the efforts, N, Nm, or both where the axes differ. Returns a Matplotlib figure. Raises InputError when
    there is no such VCD, or a damaged one.
    """
    from matplotlib.figure import Figure

    try:
        waves = _Waves(vcd)
        results = waves.rises("out_valid")
    except (OSError, ValueError, KeyError):
        raise InputError(f"{vcd}: no waveform of a run, or a damaged one; start `make sim` first") from None
    milli = " or ".join(f"m{one}" for one in unit.split(" or "))
    figure = Figure(figsize=(12, 7), layout="constrained")
    left, right = figure.add_gridspec(1, 2)
    left, right = left.subgridspec(3, 1, height_ratios=(3, 3, 1)), right.subgridspec(5, 1)
    counts = figure.add_subplot(left[0], title="the run", ylabel="change of the encoder counts")
    _plot_axes(counts, waves, "sts_count", n_axes, 32, results[0])
    forces = figure.add_subplot(left[1], sharex=counts, ylabel=f"change of the forces, {milli}")
    _plot_axes(forces, waves, "out_force", n_axes, force_bits, results[0])
    ticks = figure.add_subplot(left[2], sharex=counts, yticks=[], ylabel="results", xlabel="time, ms")
    ticks.vlines(results, 0, 1, color="black")
    middle, shown_axis = results[len(results) // 2], min(SHOWN_AXIS, n_axes - 1)
    window = (middle - 0.25, middle + 0.05)
    for row, (name, label) in enumerate(
        [
            ("pin_a", f"A, axis {shown_axis + 1}"),
            ("pin_b", f"B, axis {shown_axis + 1}"),
            ("in_valid", "in_valid"),
            ("out_valid", "out_valid"),
        ]
    ):
        bit = shown_axis if name.startswith("pin") else 0
        axes = figure.add_subplot(right[row], xlim=window, ylim=(-0.2, 1.3), yticks=[0, 1], ylabel=label)
        axes.step(*waves.signal(name, lambda word, bit=bit: word >> bit & 1), where="post", color="black")
        axes.tick_params(labelbottom=False)
        if row == 0:
            axes.set_title("one inference: pins rest, counts in, forces out")
    times, values = waves.signal("out_force", lambda word: _field(word, shown_axis, force_bits))
    shown = [value for time, value in zip(times, values, strict=True) if abs(time - middle) < 1.5]
    axes = figure.add_subplot(right[4], xlim=window, ylabel=f"force {shown_axis + 1}, {milli}", xlabel="time, ms")
    axes.step(times, values, where="post", color=AXIS_COLOURS[shown_axis])
    axes.set_ylim(min(shown) - 10, max(shown) + 10)
    return figure


def _plot_axes(axes, waves, name: str, n_axes: int, bits: int, start_ms: float) -> None:
    """Steps of a packed signal from the first result on, each axis as the change since then."""
    for i in range(n_axes):
        times, values = waves.signal(name, lambda word, i=i: _field(word, i, bits))
        first = max(k for k, time in enumerate(times) if time <= start_ms)
        change = [value - values[first] for value in values[first:]]
        colour = AXIS_COLOURS[i % len(AXIS_COLOURS)]
        axes.step([start_ms, *times[first + 1 :]], change, where="post", label=f"axis {i + 1}", color=colour)
    axes.tick_params(labelbottom=False)
    axes.legend(loc="best", ncols=min(n_axes, 3))


def _field(word: int, index: int, bits: int) -> int:
    value = word >> index * bits & (1 << bits) - 1
    return value - (1 << bits) if value >> bits - 1 else value


class _Waves:
    """Changes of the signals of gc_force_path in a VCD; times in ms, words as unsigned integers."""

    def __init__(self, vcd: Path):
        from vcdvcd import VCDVCD

        names = VCDVCD(str(vcd), only_sigs=True).signals
        self._path = {name.removeprefix(RUN_SCOPE).split("[")[0]: name for name in names if name.startswith(RUN_SCOPE)}
        self._vcd = VCDVCD(str(vcd), signals=[self._path[f".{name}"] for name in SIGNALS])
        self._ms = float(self._vcd.timescale["timescale"]) * 1e3
        self.end_ms = self._vcd.endtime * self._ms

    def signal(self, name: str, decode: Callable[[int], int] = int) -> tuple[list[float], list[int]]:
        """Times and decoded values of the changes of a signal, from its first defined value to the end."""
        changes = [
            (time * self._ms, decode(int(word, 2)))
            for time, word in self._vcd[self._path[f".{name}"]].tv
            if not set(word.lower()) - {"0", "1"}
        ]
        times, values = (list(column) for column in zip(*changes, strict=True))
        return [*times, self.end_ms], [*values, values[-1]]

    def rises(self, name: str) -> list[float]:
        """Times at which a single bit rises."""
        times, values = self.signal(name)
        return [time for time, value in zip(times[:-1], values[:-1], strict=True) if value == 1]
