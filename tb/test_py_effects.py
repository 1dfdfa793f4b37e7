"""Every effect of the vocabulary: its contract, its equation written again, its zero, its fit to data made from it.

Friction is what the motor has to give beside the statics, so it has the sign of the motion.
"""

import ast
import re
from collections.abc import Callable
from dataclasses import dataclass, replace

import mujoco
import numpy as np
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation
from scipy.stats import binom, chi2

from codes import ROOT
from gravcomp.diagnosis.candidate import Parameter, Term
from gravcomp.diagnosis.effects import EFFECTS, NAMES, effect_named
from gravcomp.diagnosis.fit import fit_terms
from gravcomp.diagnosis.model import Model
from gravcomp.diagnosis.search.periodogram import find_lines, pitch_of
from gravcomp.errors import InputError
from gravcomp.logs.measurement import Measurement
from gravcomp.robot.machine import load_machine
from gravcomp.robot.spheiro.kinematics import direct_kinematics
from gravcomp.robot.spheiro.statics import holding_forces_at
from machines import P
from measured_samples import MOTION_M, MOTION_RAD_PER_S, arm, holds, motion, sampled

# name: units by parameter ([q], [f]: units of position and effort in the data), place in hardware
CONTRACT = {
    "coulomb_friction": ({"fc": "[f]", "fc_pos": "[f]", "fc_neg": "[f]"}, "compensator"),
    "viscous_friction": ({"b": "[f] s/[q]", "b_pos": "[f] s/[q]", "b_neg": "[f] s/[q]"}, "compensator"),
    "stribeck_friction": ({"fc": "[f]", "fs": "[f]", "vs": "[q]/s"}, "compensator"),
    "passive_joint_friction": ({"fc_prismatic": "N", "fc_rotary": "Nm"}, "compensator"),
    "universal_joint_friction": ({"fc_universal": "Nm"}, "compensator"),
    "platform_hose": ({"k": "Nm/rad"}, "network"),
    "load_dependent_friction": ({"mu": "1"}, "compensator"),
    "directional_load_friction": (
        {"mu_motor": "1", "mu_load": "1", "nu_motor": "1/[f]", "nu_load": "1/[f]"},
        "compensator",
    ),
    "reaction_friction": ({"mu": "1"}, "compensator"),
    "transmission_friction": (
        {"fc_plus": "[f]", "fc_minus": "[f]", "b_plus": "[f] s/[q]", "b_minus": "[f] s/[q]"},
        "compensator",
    ),
    "offset_step": ({"step": "[f]", "t_step": "s"}, "none"),
    "position_dependent_friction": ({"fc": "[f]", "slope": "[f]/[q]"}, "compensator"),
    "friction_step": ({"step": "[f]", "t_step": "s"}, "none"),
    "sensor_sign": ({"sign": "1"}, "none"),
    "sensor_lag": ({"tau": "s", "tau_v": "s"}, "none"),
    "backlash": ({"gap": "[q]", "travel": "[q]"}, "none"),
    "cogging": ({"amplitude": "[f]", "phase": "rad", "pitch": "[q]"}, "compensator"),
    "payload": ({"mass": "kg", "moment": "kg m", "torque": "[f]"}, "network"),
    "body_moment": ({"moment": "kg m"}, "network"),
    "base_tilt": ({"tilt": "rad"}, "network"),
    "thrust_constant": ({"gain": "1"}, "network"),
    "encoder_offset": ({"offset": "[q]"}, "network"),
    "current_offset": ({"o": "[f]"}, "network"),
    "cable_spring": ({"k": "[f]/[q]", "q0": "[q]"}, "network"),
    "nonlinear_cable_spring": (
        {f"{part}{n}": ("[f]", "[f]/[q]", "[f]/[q]^2", "[f]/[q]^3", "[f]/[q]^4")[n] for part in "kh" for n in range(5)},
        "network",
    ),
    "link_compliance": ({"c": "[q]/[f]"}, "network"),
    "thermal_drift": ({"gain": "1 or 1/K", "tau": "s", "t0": "degC"}, "none"),
    "inertia": ({"m": "[f] s^2/[q]"}, "none"),
    "presliding_hysteresis": ({"fc": "[f]", "s": "[q]"}, "compensator"),
}
ARM2 = ROOT / "weights" / "arm2"
OF_SENSORS = ("sensor_sign", "sensor_lag")  # not added to the model's force: they turn the log back
AXES = (1, 2, 3)
NOISE_N = 0.1
SEEDS = range(6)


def picked() -> Measurement:
    """Hand-picked holds; axis 2 of the third was not moved, axes 1 and 3 of the last pull."""
    q = np.array([[30, -20, 50], [-60, 10, 0], [20, 70, -40], [-35, -55, -15], [0, 0, 0], [75, -70, 75]]) * 1e-3
    v = np.array([[4, -1, 2], [-3, 5, -0.5], [1, 0, -6], [-2, 3, 1], [0.3, -8, 2], [1, 2, -3]]) * 1e-3
    t_s, temp_c = np.array([[0, 20], [10, 25], [40, 31], [100, 40], [500, 22], [501, 23]], float).T
    return sampled(t_s, q, v, temp_c)


def each(stem: str, *values: float) -> dict[str, float]:
    return {f"{stem}_{axis}": value for axis, value in zip(AXES, values, strict=True)}


def at(params: dict, stem: str) -> np.ndarray:
    return np.array([params.get(f"{stem}_{axis}", 0.0) for axis in AXES])


def statics(q: np.ndarray) -> np.ndarray:
    return holding_forces_at(q, P)


def by_direction(data, params, stem):
    return np.where(data.v > 0, at(params, f"{stem}_pos"), np.where(data.v < 0, at(params, f"{stem}_neg"), 0.0))


def stribeck(data, params):
    fc, fs, vs = (at(params, stem) for stem in ("fc", "fs", "vs"))
    return (fc + (fs - fc) * np.exp(-((data.v / vs) ** 2))) * np.sign(data.v)


def passive_positions(q: np.ndarray) -> np.ndarray:
    """Slides b_i and angles phi_i of the passive joints, (n, 6), from the mechanism's closure."""
    ends = P.d_m * direct_kinematics(q, P) @ np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])  # columns d R u_i
    out = []
    for i in range(3):
        across = ends[:, :, i].copy()
        across[:, i] = 0.0  # less q_i e_i
        out.append((np.linalg.norm(across, axis=1), np.arctan2(across[:, (i + 2) % 3], across[:, (i + 1) % 3])))
    return np.stack([b for b, _ in out] + [phi for _, phi in out], axis=1)


def passive_friction(data, params):
    step = 1e-6
    jacobian = np.stack(
        [(passive_positions(data.q + step * e) - passive_positions(data.q - step * e)) / (2 * step) for e in np.eye(3)],
        axis=-1,
    )
    kinds = ("fc_prismatic_n", "fc_rotary_nm")
    own = [params.get(kind, params.get(f"{kind}_{leg}")) for kind in kinds for leg in AXES]
    level = np.stack([np.broadcast_to(one, len(data.q)) for one in own], axis=-1)
    return np.einsum("npk,np->nk", jacobian, level * np.sign(np.einsum("npk,nk->np", jacobian, data.v)))


def hinge_angles(q: np.ndarray) -> np.ndarray:
    """Inner and outer angle of the universal joints, (n, 6), from R = turn about e, about e x u, about u."""
    rotation, phi, out = direct_kinematics(q, P), passive_positions(q)[:, 3:], []
    for i in range(3):
        e, u = np.eye(3)[i], np.eye(3)[(i + 1) % 3]
        home = np.stack([e, np.cross(e, u), u])
        seen = Rotation.from_rotvec(-phi[:, i, None] * e).as_matrix() @ rotation
        x, y, z = np.moveaxis(home @ seen @ home.T, 0, -1)  # rows of Ry(inner) Rz(outer) in the frame e, e x u, u
        out.append((np.arctan2(x[2], z[2]), np.arctan2(y[0], y[1])))
    return np.stack([inner for inner, _ in out] + [outer for _, outer in out], axis=1)


def hinge_jacobian(q: np.ndarray) -> np.ndarray:
    step = 1e-6 * np.eye(3)
    return np.stack([(hinge_angles(q + e) - hinge_angles(q - e)) / 2e-6 for e in step], axis=-1)


def universal_friction(data, params):
    jacobian, kind = hinge_jacobian(data.q), "fc_universal_nm"
    level = np.array([params.get(kind, params.get(f"{kind}_{leg}")) for leg in AXES] * 2)
    return np.einsum("npk,np->nk", jacobian, level * np.sign(np.einsum("npk,nk->np", jacobian, data.v)))


def hose(data, params):
    return np.einsum("npk,np->nk", hinge_jacobian(data.q)[:, 3:], at(params, "k") * hinge_angles(data.q)[:, 3:])


def load_by_side(data, params):
    load = statics(data.q)
    size = [at(params, f"mu_{side}") * np.abs(load) + at(params, f"nu_{side}") * load**2 for side in ("motor", "load")]
    return np.where(load * data.v > 0, size[0], size[1]) * np.sign(data.v)


def reaction_friction(data, params):
    mu = np.array([params.get("mu", params.get(f"mu_{leg}")) for leg in AXES])
    borne = data.robot.slide_reactions(data.q)  # beside the engine in test_py_prototype
    return passive_friction(
        replace(data), {f"fc_prismatic_n_{k + 1}": mu[k] * borne[:, k] for k in range(3)} | {"fc_rotary_nm": 0.0}
    )


def transmission(data, params, both, which):
    speed = data.v @ both
    return (params[f"fc_{which}"] * np.sign(speed) + params[f"b_{which}"] * speed)[:, None] * both


def payload(data, params):
    """Gradient over q of the potential -g . R (m r)."""
    moment = np.array([params[f"moment_{axis}"] for axis in "xyz"])

    def potential(q):
        return -(direct_kinematics(q, P) @ moment) @ (9.81 * np.array([-1.0, -1.0, -1.0]) / np.sqrt(3.0))

    step = 1e-6
    return np.stack([(potential(data.q + step * e) - potential(data.q - step * e)) / (2 * step) for e in np.eye(3)], -1)


def arm2_holds(n: int, seed: int) -> Measurement:
    """Scattered poses of the arm of two links."""
    robot = load_machine(ARM2).robot
    q = robot.workspace(n, seed)
    f = robot.forces(q)
    return Measurement("arm2", 2.0 * np.arange(n), q, None, f, f, "Nm", ("rad",) * 2, None, robot.forces, robot)


def moments_on_bodies(data, params):
    """Gradient over q of -g . R_b (m r), R_b by the engine's own kinematics."""
    model = mujoco.MjModel.from_xml_path(str(ARM2 / "arm2.xml"))
    state = mujoco.MjData(model)

    def potential(q):
        state.qpos[:] = q
        mujoco.mj_kinematics(model, state)
        bodies = {name: state.body(name).xmat.reshape(3, 3) for name in ("upper_arm", "forearm")}
        moment = sum(value * bodies[label[7:-2]][:, "xyz".index(label[-1])] for label, value in params.items())
        return -model.opt.gravity @ moment

    step = 1e-6 * np.eye(2)
    return np.array([[(potential(q + e) - potential(q - e)) / 2e-6 for e in step] for q in data.q])


def cable(data, params):
    even, odd = (sum(at(params, f"{part}{n}") * data.q**n for n in range(5)) for part in "kh")
    return even + odd * np.sign(data.v)


def powers(part: str, *sizes: float) -> dict[str, float]:
    """Terms of the order of newtons at 80 mm, another one on each axis."""
    return {
        label: value
        for n, size in enumerate(sizes)
        for label, value in each(f"{part}{n}", *(size * sign / 0.08**n for sign in (1.0, -1.2, 0.9))).items()
    }


def tilted(data, params):
    first, down = np.array([0.0, -1.0, 1.0]) / np.sqrt(2.0), np.array([-1.0, -1.0, -1.0]) / np.sqrt(3.0)
    x, y, z = params["tilt_a"] * first + params["tilt_b"] * np.cross(down, first)
    turned = expm(np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])) @ down
    return holding_forces_at(data.q, replace(P, gravity_direction=turned)) - statics(data.q)


def waves(harmonic: int, amplitudes, phases) -> dict[str, float]:
    named = each("amplitude", *amplitudes) | each("phase", *phases)
    return {f"{label}_h{harmonic}": value for label, value in named.items()}


def cogging(data, params):
    force = np.zeros(data.shape)
    for label in (label for label in params if label.startswith("amplitude")):
        axis, harmonic = (int(number) for number in re.findall(r"\d+", label))
        turns = harmonic * data.q[:, axis - 1] / params["pitch"]
        phase = params[label.replace("amplitude", "phase")]
        force[:, axis - 1] += params[label] * np.sin(2 * np.pi * turns + phase)
    return force


def dahl(data, params):
    """After each reversal, at -+60 mm, friction goes from one sign to the other along the travel s; full at first."""
    way = np.sign(data.v)
    has_reversed = np.maximum.accumulate(way != way[0], axis=0)
    since = np.abs(data.q + way * MOTION_M)
    return at(params, "fc") * way * (1.0 - 2.0 * has_reversed * np.exp(-since / np.maximum(at(params, "s"), 1e-9)))


def crossing(data, params):
    """Side of the gap, -1..1: after each reversal, at -+60 mm, it changes in proportion to the way, over the travel."""
    way = np.sign(data.v)
    has_reversed = np.maximum.accumulate(way != way[0], axis=0)
    since = np.abs(data.q + way * MOTION_M)
    return np.where(has_reversed, way * np.minimum(2.0 * since / at(params, "travel") - 1.0, 1.0), way)


def shifted(data, shift):
    return statics(data.q + shift) - statics(data.q)


@dataclass(frozen=True)
class Case:
    """force: the contract's equation. The effect vanishes with the parameters of zeros, in which it may be linear."""

    kind: str
    params: dict[str, float]
    zeros: tuple[str, ...]
    force: Callable[[Measurement, dict], np.ndarray]
    few: Callable[[], Measurement] = picked
    many: Callable[[], Measurement] = lambda: holds(400, 5)
    linear: bool = True
    tolerance: float = 1e-9


MOVING = {"few": lambda: motion(400), "many": lambda: motion(800)}
CASES = {
    "coulomb": Case("CoulombFriction", each("fc", 1.0, 2.0, 0.5), ("fc",),
                    lambda d, p: at(p, "fc") * np.sign(d.v)),
    "coulomb by direction": Case("DirectionalCoulombFriction",
                                 each("fc_pos", 1, 2, 0.5) | each("fc_neg", 0.7, 2.5, 0.3), ("fc_pos", "fc_neg"),
                                 lambda d, p: by_direction(d, p, "fc") * np.sign(d.v)),
    "viscous": Case("ViscousFriction", each("b", 100.0, 300.0, 200.0), ("b",), lambda d, p: at(p, "b") * d.v),
    "viscous by direction": Case("DirectionalViscousFriction",
                                 each("b_pos", 100, 300, 200) | each("b_neg", 150, 200, 90), ("b_pos", "b_neg"),
                                 lambda d, p: by_direction(d, p, "b") * d.v),
    "stribeck": Case("StribeckFriction", each("fc", 1, 2, 0.5) | each("fs", 3, 3.5, 2) | each("vs", 2e-3, 3e-3, 1e-3),
                     ("fc", "fs"), stribeck),
    "passive joints": Case("PassiveJointFriction", {"fc_prismatic_n": 2.0, "fc_rotary_nm": 0.4},
                           ("fc_prismatic", "fc_rotary"), passive_friction, lambda: holds(5, 3), tolerance=1e-6),
    "each passive joint": Case("FrictionOfEachPassiveJoint",
                               each("fc_prismatic_n", 2.0, 1.5, 2.6) | each("fc_rotary_nm", 0.4, 0.5, 0.3),
                               ("fc_prismatic", "fc_rotary"), passive_friction, lambda: holds(5, 3), tolerance=1e-6),
    "universal joints": Case("UniversalJointFriction", {"fc_universal_nm": 0.4}, ("fc_universal",), universal_friction,
                             lambda: holds(5, 3), tolerance=1e-6),
    "each universal joint": Case("FrictionOfEachUniversalJoint", each("fc_universal_nm", 0.4, 0.3, 0.5),
                                 ("fc_universal",), universal_friction, lambda: holds(5, 3), tolerance=1e-6),
    "hose": Case("PlatformHose", each("k", 2.0, -1.5, 3.0), ("k",), hose, tolerance=1e-6),
    "load": Case("LoadDependentFriction", each("mu", 0.02, 0.05, 0.03), ("mu",),
                 lambda d, p: at(p, "mu") * np.abs(statics(d.q)) * np.sign(d.v)),
    "load by side": Case("DirectionalLoadFriction",
                         each("mu_motor", 0.06, 0.05, 0.07) | each("mu_load", 0.02, 0.03, 0.01),
                         ("mu_motor", "mu_load"), load_by_side),
    "load by side, with its square": Case("QuadraticLoadFriction",
                                          each("mu_motor", 0.06, 0.05, 0.07) | each("mu_load", 0.03, 0.04, 0.03)
                                          | each("nu_motor", 8e-4, 9e-4, 7e-4) | each("nu_load", 5e-4, 6e-4, 4e-4),
                                          ("mu_motor", "mu_load", "nu_motor", "nu_load"), load_by_side),
    "reaction": Case("ReactionFriction", {"mu": 0.03}, ("mu",), reaction_friction, lambda: holds(5, 3), tolerance=1e-6),
    "reaction of each slide": Case("ReactionFrictionOfEachSlide", each("mu", 0.03, 0.02, 0.04), ("mu",),
                                   reaction_friction, lambda: holds(5, 3), tolerance=1e-6),
    "sum of two axes": Case("TransmissionFriction", {"fc_plus_1": 1.0, "b_plus_1": 200.0}, ("fc_plus", "b_plus"),
                            lambda d, p: transmission(d, p, [1.0, 1.0, 0.0], "plus_1")),
    "difference of two axes": Case("TransmissionFriction", {"fc_minus_2": 1.5, "b_minus_2": 150.0},
                                   ("fc_minus", "b_minus"),
                                   lambda d, p: transmission(d, p, [0.0, 1.0, -1.0], "minus_2")),
    "step of the level": Case("OffsetStep", each("step", 1.0, -0.5, 0.8) | {"t_step_s": 301.0}, ("step",),
                              lambda d, p: at(p, "step") * (d.t_s[:, None] > p["t_step_s"])),
    "position": Case("PositionDependentFriction", each("fc", 1.0, 2.0, 0.9) | each("slope", 4.0, -9.0, 6.0),
                     ("fc", "slope"), lambda d, p: (at(p, "fc") + at(p, "slope") * d.q) * np.sign(d.v)),
    "step of friction": Case("FrictionStep", each("step", 1.0, -0.5, 0.8) | {"t_step_s": 301.0}, ("step",),
                             lambda d, p: at(p, "step") * np.sign(d.v) * (d.t_s[:, None] > p["t_step_s"])),
    "backlash": Case("Backlash", each("gap", 0.004, 0.002, 0.003), ("gap",),
                     lambda d, p: shifted(d, -at(p, "gap") / 2 * np.sign(d.v)), linear=False),
    "backlash in motion": Case("BacklashInMotion", each("gap", 4e-3, 2e-3, 3e-3) | each("travel", 5e-3, 3e-3, 2e-3),
                               ("gap",), lambda d, p: shifted(d, -at(p, "gap") / 2 * crossing(d, p)), **MOVING,
                               linear=False, tolerance=2e-2),
    "cogging": Case("Cogging", {"pitch": 0.012} | waves(1, (1.0, 0.8, 0.6), (0.3, -2.0, 1.5))
                    | waves(2, (0.5, 0.4, 0.7), (2.0, 0.4, -1.0)), ("amplitude",), cogging),
    "payload": Case("Payload", {"moment_x": 0.1, "moment_y": -0.05, "moment_z": 0.08}, ("moment",), payload,
                    tolerance=1e-6),
    "payload of an arm": Case("Payload", {"torque_cos": 0.5, "torque_sin": -0.3}, ("torque",),
                              lambda d, p: p["torque_cos"] * np.cos(d.q) + p["torque_sin"] * np.sin(d.q),
                              lambda: arm(5, 1), lambda: arm(400, 2)),
    "moments on bodies": Case("BodyMoment",
                              {"moment_upper_arm_x": 0.2, "moment_upper_arm_z": -0.15, "moment_forearm_x": -0.1,
                               "moment_forearm_z": 0.12}, ("moment",), moments_on_bodies,
                              lambda: arm2_holds(6, 1), lambda: arm2_holds(400, 2), tolerance=1e-6),
    "tilt": Case("BaseTilt", {"tilt_a": 0.02, "tilt_b": -0.03}, ("tilt",), tilted, linear=False),
    "thrust constant": Case("ThrustConstant", each("gain", 0.02, -0.03, 0.05), ("gain",),
                            lambda d, p: at(p, "gain") * statics(d.q)),
    "encoder offset": Case("EncoderOffset", each("offset", 0.003, -0.002, 0.004), ("offset",),
                           lambda d, p: shifted(d, at(p, "offset")), linear=False),
    "current offset": Case("CurrentOffset", each("o", 0.5, -0.3, 0.8), ("o",),
                           lambda d, p: np.broadcast_to(at(p, "o"), d.shape)),
    "spring": Case("CableSpring", each("k", 30.0, -20.0, 40.0) | each("q0", 0.02, 0.05, -0.03), ("k",),
                   lambda d, p: at(p, "k") * (d.q - at(p, "q0"))),
    "nonlinear cable": Case("NonlinearCableSpring", powers("k", 2.0, -3.0, 2.5, 3.0, -3.0),
                            tuple(f"k{n}" for n in range(5)), cable),
    "nonlinear cable by direction": Case("DirectionalNonlinearCableSpring",
                                         powers("k", 2.0, -3.0, 2.5, 3.0, -3.0)
                                         | powers("h", 1.5, 3.0, -2.5, -3.0, 3.0),
                                         tuple(f"{part}{n}" for part in "kh" for n in range(5)), cable),
    "compliance": Case("LinkCompliance", each("c", -5e-5, -3e-5, -8e-5), ("c",),
                       lambda d, p: shifted(d, at(p, "c") * statics(d.q)), linear=False),
    "drift over time": Case("ThermalDrift", each("gain", 0.03, -0.04, 0.05) | {"tau_s": 120.0}, ("gain",),
                            lambda d, p: at(p, "gain") * (1 - np.exp(-d.t_s[:, None] / p["tau_s"])) * statics(d.q),
                            lambda: replace(picked(), temp_c=None), lambda: replace(holds(400, 5), temp_c=None)),
    "drift over temperature": Case("ThermalDrift", each("gain", 2e-3, -3e-3, 5e-3) | each("t0", 22.0, 35.0, 28.0),
                                   ("gain",),
                                   lambda d, p: at(p, "gain") * (d.temp_c[:, None] - at(p, "t0")) * statics(d.q)),
    "inertia": Case("Inertia", each("m", 20.0, 35.0, 15.0), ("m",),
                    lambda d, p: -at(p, "m") * MOTION_RAD_PER_S**2 * d.q, **MOVING, tolerance=2e-3),
    "presliding": Case("PreslidingHysteresis", each("fc", 1.0, 2.0, 1.5) | each("s", 4e-3, 2e-3, 6e-3), ("fc",), dahl,
                       **MOVING, tolerance=2e-2),
}  # fmt: skip
every_case = pytest.mark.parametrize("case", CASES.values(), ids=CASES)
every_class = pytest.mark.parametrize("kind", EFFECTS, ids=[kind.__name__ for kind in EFFECTS])


def effect_of(case: Case):
    return next(kind for kind in EFFECTS if kind.__name__ == case.kind)()


def stem(label: str) -> str:
    """moment_forearm_x is the moment of a body."""
    without = re.sub(r"_((n_|nm_)?\d+(_h\d+)?|n|nm|s|[xyz]|[ab]|cos|sin)$", "", label)
    return "moment" if label.startswith("moment_") else without


def inner(force: np.ndarray) -> np.ndarray:
    """Without the ends, where a derivative along time is one-sided."""
    return force[10:-10] if len(force) > 100 else force


def test_vocabulary_is_the_contract_and_every_effect_has_a_case():
    assert set(NAMES) == set(CONTRACT), "state name, units and place of a new effect in CONTRACT"
    added = {kind.__name__ for kind in EFFECTS if kind.name not in OF_SENSORS}
    assert added == {case.kind for case in CASES.values()}, "add a case for a new effect"


def test_no_other_module_of_the_diagnosis_knows_an_effect_by_name():
    rooms = [ROOT / "sim" / "gravcomp" / room for room in ("diagnosis", "loop", "logs")]
    modules = [path for room in rooms for path in room.rglob("*.py") if path.parent.name != "effects"]
    assert len(modules) > 15
    known = {*NAMES} | {kind.__name__ for kind in EFFECTS}
    assert {path.name: found for path in modules if (found := words_of(path) & known)} == {}


def words_of(path) -> set[str]:
    """Strings and names in the code of a module; prose is free."""
    nodes = list(ast.walk(ast.parse(path.read_text())))
    strings = {node.value for node in nodes if isinstance(node, ast.Constant) and isinstance(node.value, str)}
    names = {getattr(node, "id", None) or getattr(node, "name", None) for node in nodes}
    return strings | {name for name in names if isinstance(name, str)}


@every_class
def test_units_and_place_in_hardware_are_those_of_the_contract(kind):
    assert (kind.units, kind.hardware) == CONTRACT[kind.name]


@every_class
def test_page_on_effects_says_what_the_code_says(kind):
    (row,) = re.findall(rf"^\| {kind.name} \|(.*)\|$", (ROOT / "docs" / "guide" / "effects.md").read_text(), re.M)
    equation, parameters, hardware = (cell.strip() for cell in row.split("|"))
    assert (equation, hardware) == (kind.equation, kind.hardware)
    assert all(re.search(rf"\b{name}(_i)?\b", parameters) for name in kind.units)


def test_parameters_of_the_cases_are_those_of_the_contract():
    used = {name: set() for name in NAMES if name not in OF_SENSORS}
    used["payload"].add("mass")  # on an arm, in test_py_arm_effects
    for case in CASES.values():
        used[effect_of(case).name] |= {stem(label) for label in case.params}
    assert used == {name: set(units) for name, (units, _) in CONTRACT.items() if name not in OF_SENSORS}


@every_case
def test_prediction_is_the_equation(case):
    data = replace(case.few(), force=case.few().force + 7.0)  # effects follow the model's force, not the measured one
    assert effect_of(case).unavailable(data) == ""
    given, wanted = effect_of(case).predict(data, case.params), case.force(data, case.params)
    assert np.abs(wanted).max(axis=0).min() > 0.1 or case.kind in ("BaseTilt", "TransmissionFriction")
    np.testing.assert_allclose(inner(given), inner(wanted), atol=case.tolerance, rtol=0)


@every_case
def test_effect_of_size_zero_is_exactly_nothing(case):
    nothing = {label: 0.0 if stem(label) in case.zeros else value for label, value in case.params.items()}
    assert not effect_of(case).predict(case.few(), nothing).any()


@every_case
def test_effect_scales_with_its_size_where_the_equation_does(case):
    data = case.few()
    twice = {label: value * (2.0 if stem(label) in case.zeros else 1.0) for label, value in case.params.items()}
    ratio = effect_of(case).predict(data, twice) - 2.0 * effect_of(case).predict(data, case.params)
    assert (np.abs(ratio).max() < 1e-9) == case.linear


@pytest.mark.parametrize("case", [c for c in CASES.values() if any("_2" in label for label in c.params)],
                         ids=lambda c: c.kind)  # fmt: skip
def test_axis_without_parameters_has_no_part_in_the_effect(case):
    effect, data = effect_of(case), case.few()
    fewer = {label: value for label, value in case.params.items() if not re.search(r"_2(_|$)", label)}
    size = {label: 0.0 if stem(label) in case.zeros else value for label, value in case.params.items()}
    given = effect.predict(data, fewer)
    np.testing.assert_allclose(given, effect.predict(data, size | fewer), atol=1e-12)
    assert not effect.per_axis or not given[:, 1].any()


@pytest.mark.parametrize("case", [c for c in CASES.values() if effect_of(c).name.endswith("friction")],
                         ids=lambda c: c.kind)  # fmt: skip
def test_friction_takes_power_from_the_motors(case):
    data = case.many()
    assert (np.sum(effect_of(case).predict(data, case.params) * data.v, axis=1) > 0).all()


@every_case
def test_regressors_are_the_effect_to_first_order(case):
    effect, data = effect_of(case), case.many()
    for shape in tried_shapes(effect, data, case.force(data, case.params)):
        columns = effect.columns(data, shape)
        scale = {label: np.sqrt(np.mean(column**2)) for label, column in columns.items()}
        coefficients = {label: 1e-3 * (k + 1) / scale[label] for k, label in enumerate(columns)}
        linear = sum(coefficients[label] * column for label, column in columns.items())
        exact = effect.predict(data, effect.parameters(shape, coefficients))
        np.testing.assert_allclose(exact, linear, atol=2e-3 * np.abs(linear).max(), rtol=0)


@every_case
def test_derivatives_are_those_of_the_prediction(case):
    """What the fit steps along; ``is_linear`` promises that they depend on no parameter."""
    effect, data = effect_of(case), case.few()
    given = effect.jacobian(data, case.params)
    assert set(given) == set(case.params)
    for name, value in case.params.items():
        step = 1e-4 * abs(value)
        ends = [effect.predict(data, {**case.params, name: value + sign * step}) for sign in (1.0, -1.0)]
        wanted = (ends[0] - ends[1]) / (2.0 * step)
        np.testing.assert_allclose(given[name], wanted, atol=2e-3 * np.abs(wanted).max() + 1e-9, rtol=0)
    assert not effect.is_linear or case.linear


def test_columns_of_a_curved_effect_lead_to_its_force_at_any_size():
    """Three times a usual size: the columns of small parameters miss a part of the force that a name may imitate."""
    curved = [case for case in CASES.values() if effect_of(case).is_curved]
    assert {effect_of(case).name for case in curved} == {"encoder_offset", "base_tilt", "link_compliance", "backlash"}
    for case in curved:
        effect, data = effect_of(case), motion(400)
        large = {name: value * (1.0 if "travel" in name else 3.0) for name, value in case.params.items()}
        wanted, size = effect.predict(data, large), np.abs(effect.predict(data, large)).max()
        led = sum(large[name] * column for name, column in effect.columns_to(data, large).items())
        np.testing.assert_allclose(led, wanted, atol=1e-4 * size, rtol=0)
        shape = {name: value for name, value in large.items() if "travel" in name}
        small = sum(large[name] * column for name, column in effect.columns(data, shape).items())
        assert np.abs(small - wanted).max() > 1e-3 * size


@every_case
def test_fit_recovers_the_parameters_within_its_own_intervals(case):
    effect, data = effect_of(case), case.many()
    force = case.force(data, case.params)
    shapes = tried_shapes(effect, data, force)
    off = []
    for seed in SEEDS:
        residual = force + NOISE_N * np.random.default_rng(seed).standard_normal(data.shape)
        entry = fitted(effect, data, residual, shapes)
        assert set(entry.parameters) == set(case.params)
        for label, true in case.params.items():
            low, high = entry.intervals[label]
            if label == "t_step_s":  # between two samples, no Jacobian tells where
                assert abs(entry.parameters[label] - true) <= 4.0
                continue
            off.append((entry.parameters[label] - true) / ((high - low) / 2))
            assert high - low < abs(true), f"{label}: an interval as wide as the parameter says nothing"
    covered, squares = np.count_nonzero(np.abs(off) < 1), np.sum(np.square(1.96 * np.array(off)))
    print(f"MEASURED {case.kind}: {covered} of {len(off)} intervals cover, chi2 {squares:.1f}")
    assert covered >= binom.ppf(1e-3, len(off), 0.95)
    assert chi2.ppf(1e-3, len(off)) < squares < chi2.ppf(0.999, len(off))


def tried_shapes(effect, data, force) -> list[dict]:
    """Shapes that the search would try; the pitch of a cogging comes from the scan of the residual."""
    if effect.name in ("friction_step", "offset_step"):
        return [dict(shape) for shape in effect.scanned_shapes(data, np.arange(len(force)), force)]
    if effect.name != "cogging":
        return effect.shapes(data)
    pitch, harmonics = pitch_of(find_lines(data.q, force), np.ptp(data.q, axis=0).max(), None)
    assert set(harmonics) >= {1, 2}
    return [{"pitch": pitch, "harmonics": (1, 2)}]


def fitted(effect, data, residual, shapes):
    """The effect alone, fitted from the best of the shapes."""

    def misfit(shape):
        x = np.stack([column.ravel() for column in effect.columns(data, shape).values()], axis=-1)
        return np.linalg.lstsq(x, residual.ravel(), rcond=None)[1].sum()

    shape = min(shapes, key=misfit)
    term = Term(effect, tuple(effect.columns(data, shape)), shape)
    noise = np.full(data.n_axes, NOISE_N)
    return fit_terms(data, residual, np.arange(len(residual)), [term], [], noise).effects[0]


def test_log_with_the_wrong_sign_is_turned_back():
    data = replace(holds(50, 1), force=holds(50, 1).nominal * [1.0, 1.0, -1.0])
    seen = effect_named("sensor_sign").seen_in(data)
    assert seen == {"sign_3": (-1.0, 0.0)}
    assert effect_named("sensor_sign").seen_in(holds(50, 1)) == {}
    right = effect_named("sensor_sign").corrected(data, {"sign_3": -1.0})
    np.testing.assert_array_equal(right.force, data.nominal)


def test_lag_of_the_effort_is_seen_in_a_motion_and_turned_back():
    data = motion(800)
    friction = 0.5 * np.sign(data.v)
    whole = data.nominal + friction
    late = np.column_stack([np.interp(data.t_s - 0.12, data.t_s, f) for f in whole.T])
    noise = 0.05 * np.random.default_rng(3).standard_normal(data.shape)
    effect = effect_named("sensor_lag")
    ((tau, half),) = effect.seen_in(replace(data, force=late + noise)).values()
    assert abs(tau - 0.12) < max(half, 0.01)
    assert effect.seen_in(replace(data, force=whole + noise)) == {}
    back = effect.corrected(replace(data, force=late), {"tau_s": 0.12})
    sure = ~back.is_undecided
    sure[:5] = False  # what came before the log is in no row
    assert np.abs(back.force - back.nominal - 0.5 * np.sign(back.v))[sure].max() < 0.05
    assert np.abs(late - data.nominal - friction)[sure].max() > 0.2


def test_late_velocity_is_seen_where_a_stamp_repeats():
    data = motion(800)
    late = np.column_stack([np.interp(data.t_s - 0.2, data.t_s, v) for v in data.v.T])
    stamps = data.t_s.copy()
    stamps[100] = stamps[99]
    (lag,) = (kind() for kind in EFFECTS if kind.__name__ == "VelocityLag")
    seen = lag.seen_in(replace(data, t_s=stamps, v=late))
    assert {name: tau for name, (tau, _) in seen.items()} == pytest.approx(
        {f"tau_v_{axis}": 0.2 for axis in AXES}, abs=0.02
    )
    assert lag.seen_in(replace(data, t_s=stamps)) == {}


def test_passive_joint_of_an_axis_at_rest_has_no_friction():
    data = holds(50, 1)
    data = replace(data, v=data.v * [1.0, 0.0, 0.0])
    sliding = effect_named("passive_joint_friction").predict(data, {"fc_prismatic_n": 2.0, "fc_rotary_nm": 0.0})
    np.testing.assert_allclose(sliding[:, 1:], 0.0, atol=1e-6)


def test_passive_joint_that_reverses_leaves_its_friction_in_doubt():
    """v read on a grid of 1 mm/s: where a joint's speed could have either sign, all of its friction may be wrong."""
    data = replace(holds(400, 1), v=np.round(1e3 * motion(400).v) * 1e-3)
    effect = effect_named("passive_joint_friction")
    doubt = effect.doubt(data, {"fc_prismatic_n": 2.0, "fc_rotary_nm": 0.0})
    jacobian = data.robot.passive_jacobian(data.q)[:, :3]
    slow = np.abs(np.einsum("npk,nk->np", jacobian, data.v)) < np.einsum("npk,nk->np", np.abs(jacobian), data.dead_band)
    assert 0.01 < slow.mean() < 0.9
    np.testing.assert_allclose(doubt, 2.0 * np.einsum("npk,np->nk", np.abs(jacobian), slow), atol=1e-9)
    assert not effect_named("coulomb_friction").doubt(data, {"fc_1": 1.0}).any()


@pytest.mark.parametrize("n_runs", [1, 2])
def test_how_friction_stood_when_a_motion_began_is_in_doubt(n_runs):
    """Between fc and -fc, fading along the way: 2 fc exp(-way/s). A second run may have begun anywhere again."""
    data = motion(600)
    data = replace(data, run=np.repeat(np.arange(n_runs), 600 // n_runs))
    doubt = effect_named("presliding_hysteresis").doubt(data, {"fc_1": 1.5, "s_1": 0.01})
    step = np.where(data.is_first, 0.0, np.abs(np.diff(data.q[:, 0], prepend=data.q[0, 0])))
    way = np.concatenate([np.cumsum(own) for own in np.split(step, n_runs)])
    np.testing.assert_allclose(doubt[:, 0], 3.0 * np.exp(-way / 0.01), atol=1e-9)
    assert not doubt[:, 1:].any()


def test_side_of_a_gap_is_in_doubt_until_it_was_crossed():
    """The gap times the stiffness of the model; none is left when the joint has come as far as its travel."""
    data, travel_m = motion(600), 0.02
    effect = next(kind() for kind in EFFECTS if kind.name == "backlash" and "travel" in kind.scales)
    doubt = effect.doubt(data, {"gap_2": 1e-3, "travel_2": travel_m})
    stiffness = np.abs(data.sensitivity[..., 1])
    np.testing.assert_allclose(doubt[0], 1e-3 * stiffness[0], rtol=1e-9)
    assert (doubt <= 1e-3 * stiffness + 1e-12).all()
    come = np.flatnonzero(np.abs(data.q[:, 1] - data.q[0, 1]) > travel_m)[0]
    assert not doubt[come:].any()
    assert doubt[: come // 2].all()


def test_drift_over_time_is_the_same_on_a_log_with_temperature():
    data, drift = holds(50, 1), {"gain_1": 0.03, "tau_s": 120.0}
    effect = effect_named("thermal_drift")
    np.testing.assert_array_equal(effect.predict(data, drift), effect.predict(replace(data, temp_c=None), drift))


def test_drift_over_temperature_is_refused_on_a_log_without():
    model = Model(effects=[("thermal_drift", {"gain_1": 1e-3, "t0_1": 25.0})])
    with pytest.raises(InputError, match="temp_c"):
        model.predict(replace(holds(50, 1), temp_c=None))


def test_fit_of_data_without_noise_is_certain():
    data = holds(50, 1)
    term = Term(effect_named("coulomb_friction"), tuple(Parameter("fc", axis) for axis in range(3)))
    entry = fit_terms(data, np.sign(data.v), np.arange(50), [term], [], np.full(3, 1e-9)).effects[0]
    assert entry.p_value == 0.0


@pytest.mark.parametrize(("effect", "parameters", "level_n"), [
    ("PreslidingHysteresis", {"fc_1": 1.5, "s_1": 0.02}, 1.5),
    ("BacklashInMotion", {"gap_1": 0.004, "travel_1": 0.02}, -100.0 * 0.004 / 2),
])  # fmt: skip
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_motion_that_begins_at_rest_came_from_where_it_then_goes(effect, parameters, level_n, way):
    """Its first speeds tell no direction. Friction has slid and play is crossed, as if it had moved so before."""
    t = 0.05 * np.arange(200)
    q, v = way * 0.05 * (1.0 - np.cos(0.3 * t))[:, None], way * 0.015 * np.sin(0.3 * t)[:, None]
    model = np.zeros_like(q) + 100.0 * q
    data = Measurement("slide", t, q, v, model, model, "N", ("m",), None, lambda at: 100.0 * at, None)
    assert data.begins_motion[0]
    assert data.direction[0, 0] == 0.0
    own = next(kind() for kind in EFFECTS if kind.__name__ == effect)
    given = {Parameter.parse(name): value for name, value in parameters.items()}
    assert own.predict(data, given)[:, 0] == pytest.approx(way * level_n * np.ones(200), abs=1e-9)
