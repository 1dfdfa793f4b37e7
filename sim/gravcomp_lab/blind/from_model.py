"""Blind data of our own: the analytic model, an effect drawn by seed, noise; the diagnosis sees the CSV's content only.

Cases: "listed" (one effect of the vocabulary), "clean" (none), "unlisted" (one effect on no list), "pair" (two of the
vocabulary). Machines: the built-in robot, held or in slow motion; an arm of one rotary axis and a linear axis of one,
with fm columns.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gravcomp.diagnosis.effects import effect_named
from gravcomp.logs.force_surface import fit_force_function
from gravcomp.logs.measurement import Measurement
from gravcomp.robot.machine import Machine
from gravcomp.robot.spheiro.kinematics import inverse_kinematics
from gravcomp.robot.spheiro.workspace import pose, sample_workspace
from gravcomp_lab.shipped import shipped_machine

CASES = ("listed", "clean", "unlisted", "pair")
# Two of these together are one of them with other parameters.
ONE_EFFECT = (
    {"coulomb_friction", "stribeck_friction", "presliding_hysteresis"},
    {"cable_spring", "current_offset", "nonlinear_cable_spring"},
    {"load_dependent_friction", "thrust_constant", "directional_load_friction"},
)
UNLISTED = {
    "soft_stop": "q", "friction_bump": "q dir", "cross_coupling": "cross", "periodic_in_time": "t", "saturation": "f",
    "air_drag": "v", "speed_coupling": "cross",
}  # fmt: skip


@dataclass(frozen=True)
class Case:
    """One blind data set with its answer: truth: names of effects or a key of UNLISTED."""

    data: Measurement
    kind: str
    truth: tuple[str, ...]
    axes: tuple[int, ...]
    noise: np.ndarray
    machine: str
    ratio: float


def draw(kind: str, seed: int) -> Case:
    """Draw machine, effect, size (1 to 5 times the noise) and kind of noise from one seed."""
    rng = np.random.default_rng([CASES.index(kind), seed])
    for _ in range(100):
        machine = rng.choice(["holds", "motion", "holds", "motion", "arm", "slide"])
        data = machine_log(machine, rng)
        noise = _noise(data, rng)
        if kind == "clean":
            return _case(data, kind, (), np.zeros(data.shape), noise, machine, 0.0, range(data.n_axes))
        names = _unlisted_for(data) if kind == "unlisted" else drawable(data)
        truth = tuple(str(name) for name in rng.choice(names, 2 if kind == "pair" else 1))
        if kind == "pair" and (truth[0] == truth[1] or any(same.issuperset(truth) for same in ONE_EFFECT)):
            continue
        force, axes, ratio = np.zeros(data.shape), (), 0.0
        for name in truth:
            if kind == "unlisted":
                own, axes = _unlisted(name, data, rng)
            else:
                own, axes = listed(name, data, rng)(data), range(data.n_axes)
            size, rms = float(rng.uniform(1.0, 5.0)), np.sqrt(np.mean(own**2))
            if rms == 0:
                break
            force, ratio = force + own * size * np.sqrt(np.mean(noise**2)) / rms, max(ratio, size)
        else:
            return _case(data, kind, truth, force, noise, machine, ratio, axes)
    raise RuntimeError("no effect shows on any machine drawn")


def _case(data, kind, truth, force, noise, machine, ratio, axes) -> Case:
    measured = Measurement(data.name, data.t_s, data.q, data.v, data.nominal + force + noise, data.nominal, data.unit,
                           data.position_units, data.temp_c, data.force_at, data.robot)  # fmt: skip
    return Case(measured, kind, truth, tuple(axes), noise, str(machine), ratio)


def machine_log(machine: str, rng) -> Measurement:
    machine_folder = shipped_machine()
    p = machine_folder.robot.parameters
    temp = bool(rng.random() < 0.3)
    if machine == "holds":
        n = int(rng.choice([120, 300, 1000, 3000]))
        q = inverse_kinematics(sample_workspace(n, p, int(rng.integers(2**31))), p)
        v = rng.choice([-1.0, 1.0], q.shape) * rng.uniform(0.0005, 0.01, q.shape)
        return _robot(machine_folder, 3.0 * np.arange(n), q, v, temp, rng)
    if machine == "motion":
        n = int(rng.choice([1200, 3600]))
        t = np.arange(n) * 0.1
        w = 2 * np.pi / rng.uniform(15.0, 60.0)
        phase = rng.uniform(0, 2 * np.pi, 3)
        tilt = np.deg2rad(18.0) * (1.0 + 0.8 * np.sin(w * t + phase[0]))
        rotation = pose(0.618 * w * t + phase[1], tilt, np.deg2rad(18.0) * np.sin(0.733 * w * t + phase[2]))
        q = inverse_kinematics(rotation, p)
        return _robot(machine_folder, t, q, np.gradient(q, t, axis=0), temp, rng)
    return _single(machine, rng, temp)


def _robot(machine: Machine, t, q, v, temp, rng) -> Measurement:
    q, robot = machine.drive.positions(machine.drive.counts(q)), machine.robot
    return Measurement("blind", t, q, v, np.zeros_like(q), robot.forces(q), "N", ("m",) * 3,
                       _temperature(t, rng) if temp else None, robot.forces, robot)  # fmt: skip


def _single(machine: str, rng, temp) -> Measurement:
    n = int(rng.choice([800, 2500]))
    t = np.arange(n) * 0.05
    w = 2 * np.pi / rng.uniform(8.0, 25.0)
    wave = 0.7 * np.sin(w * t) + 0.3 * np.sin(0.618 * w * t + 1.0)
    q = (1.4 * wave if machine == "arm" else 0.2 * wave)[:, None]
    v = np.gradient(q, t, axis=0)
    nominal = 8.0 * np.cos(q) if machine == "arm" else np.full_like(q, 30.0)
    unit, position = ("Nm", ("rad",)) if machine == "arm" else ("N", ("m",))
    return Measurement("blind", t, q, v, nominal, nominal, unit, position, _temperature(t, rng) if temp else None,
                       fit_force_function(q, nominal, list(position)))  # fmt: skip


def _temperature(t, rng) -> np.ndarray:
    rise = rng.uniform(5, 25) * (1 - np.exp(-t / (np.ptp(t) * rng.uniform(0.1, 0.5))))
    return np.round(22.0 + rise + 0.5 * np.sin(2 * np.pi * t / np.ptp(t) * 3.0), 1)


def _noise(data, rng) -> np.ndarray:
    """Gaussian, heavy-tailed, unequal by axis, quantised, or with outliers."""
    kind = rng.choice(["gauss", "student", "axes", "quantised", "outliers", "correlated"])
    sigma = rng.uniform(0.2, 1.0) * (0.1 if data.unit == "Nm" else 1.0)
    e = sigma * rng.standard_normal(data.shape)
    if kind == "student":
        e = sigma * rng.standard_t(4, data.shape) / np.sqrt(2.0)
    if kind == "axes":
        e = e * rng.uniform(0.5, 1.5, data.n_axes)
    if kind == "quantised":
        e = np.round(e / sigma) * sigma
    if kind == "outliers":
        e = np.where(rng.random(data.shape) < 0.01, 8.0 * e, e)
    if kind == "correlated":
        rho = 0.6
        for k in range(1, len(e)):
            e[k] = rho * e[k - 1] + np.sqrt(1 - rho**2) * e[k]
    return e


def drawable(data) -> list[str]:
    names = ["coulomb_friction", "coulomb_friction", "viscous_friction", "stribeck_friction", "cogging",
             "current_offset", "cable_spring", "nonlinear_cable_spring", "thermal_drift", "offset_step",
             "friction_step"]  # fmt: skip
    if data.n_axes > 1 or data.unit == "Nm":
        names += ["thrust_constant", "load_dependent_friction", "directional_load_friction", "payload"]
        names += ["encoder_offset", "backlash", "link_compliance"]
    if data.robot is not None:
        names += ["base_tilt", "passive_joint_friction", "universal_joint_friction", "platform_hose"]
        names += ["reaction_friction", "transmission_friction"]
    if data.is_motion.mean() > 0.5:
        names += ["presliding_hysteresis", "inertia"]
    return names


def listed(name: str, data, rng) -> Callable[[Measurement], np.ndarray]:
    """One effect of ordinary proportions on this data: its force (n, k) on any data of the machine; its size comes
    later.
    """
    effect = effect_named(name)
    if name == "cogging":
        span = np.ptp(data.q, axis=0).max()
        shape = {"pitch": span / rng.uniform(4.0, 40.0), "harmonics": tuple(range(1, 1 + int(rng.integers(1, 4))))}
    elif name.endswith("_step"):
        shape = {"t_step_s": float(data.t_s[0] + rng.uniform(0.3, 0.7) * np.ptp(data.t_s))}
    elif name == "transmission_friction":
        shapes = effect.shapes(data)
        shape = shapes[int(rng.integers(len(shapes)))]
    else:
        shapes = effect.shapes(data)
        shape = dict(shapes[int(rng.integers(len(shapes)))])
        shape = {key: value * float(rng.uniform(0.8, 1.2)) for key, value in shape.items()}
        if name == "stribeck_friction":
            top = np.quantile(np.abs(data.v), 0.95, axis=0)
            shape = {f"vs_{i + 1}": float(rng.uniform(0.1, 0.4) * top[i]) for i in range(data.n_axes)}
    coefficients, force, columns = {}, np.zeros(data.shape), effect.columns(data, shape)
    sides = {label: side for one in effect.contrasts(tuple(columns)) if len(one) == 1 for label, side in one.items()}
    for label, column in columns.items():
        if label.startswith(("c_", "level_")) and effect.per_axis:
            continue
        is_signed = label not in sides and not effect.positive and not label.startswith(("k_", "gain_"))
        factor = rng.uniform(0.5, 1.5) * (rng.choice([-1, 1]) if is_signed else sides.get(label, 1.0))
        factor /= max(np.sqrt(np.mean(column**2)), 1e-300)
        if name == "stribeck_friction":
            factor = rng.uniform(1.6, 2.5) if label.startswith("fs") else rng.uniform(0.6, 1.0)
        coefficients[label], force = factor, force + factor * column
    more_forward = 0.4 * np.abs(force).max() if name == "coulomb_friction" and rng.random() < 0.4 else 0.0

    def of(other: Measurement) -> np.ndarray:
        columns = effect.columns(other, shape)
        own = sum((factor * columns[label] for label, factor in coefficients.items()), np.zeros(other.shape))
        return own + np.where(other.direction > 0, more_forward, 0.0) if more_forward else own

    return of


def _unlisted_for(data) -> list[str]:
    names = ["soft_stop", "friction_bump", "periodic_in_time", "air_drag"]
    if data.n_axes > 1:
        names += ["cross_coupling", "saturation", "speed_coupling"]
    return names


def _unlisted(name: str, data, rng) -> tuple[np.ndarray, tuple[int, ...]]:
    axis = int(rng.integers(data.n_axes))
    other = (axis + 1) % data.n_axes
    q, v, t = data.q[:, axis], data.v[:, axis], data.t_s
    centre, span = q.mean(), np.ptp(q)
    x = (q - centre) / (span / 2)
    f = {
        "soft_stop": lambda: -np.maximum(x - rng.uniform(0.2, 0.5), 0.0),
        "friction_bump": lambda: np.exp(-(((x - rng.uniform(-0.4, 0.4)) / 0.2) ** 2)) * data.direction[:, axis],
        "cross_coupling": lambda: data.nominal[:, other] - data.nominal[:, other].mean(),
        "periodic_in_time": lambda: np.sin(2 * np.pi * rng.uniform(12, 60) * t / np.ptp(t) + rng.uniform(0, 6)),
        "saturation": lambda: -data.nominal[:, axis] * np.abs(data.nominal[:, axis]),
        "air_drag": lambda: v * np.abs(v),
        "speed_coupling": lambda: data.v[:, other],
    }[name]()
    force = np.zeros(data.shape)
    force[:, axis] = f
    return force, (axis,)


def is_driver(case: Case, drivers: list[dict]) -> bool:
    """Is the first driver of the report what the unlisted effect follows?"""
    if not drivers:
        return False
    axis, name = drivers[0]["axis"], drivers[0]["variable"]
    own, other = f"{case.axes[0] + 1}", f"{(case.axes[0] + 1) % case.data.n_axes + 1}"
    right = {
        "soft_stop": {f"q{own}"}, "friction_bump": {f"q{own}", f"dir{own}"},
        "cross_coupling": {f"f{other}"}, "speed_coupling": {f"v{other}"}, "saturation": {f"f{own}"},
        "periodic_in_time": {"t"}, "air_drag": {f"v{own}"},
    }[case.truth[0]]  # fmt: skip
    return axis == case.axes[0] + 1 and name in right
