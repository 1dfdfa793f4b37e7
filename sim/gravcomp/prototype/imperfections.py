"""What the virtual prototype's physics can have and the analytic model lacks.

Each effect acts where it would in the machine: on the engine's model (masses, springs, dampers, friction in joints),
as a force on the carriages, on the encoder's reading, or on the current that the drive reports. Signs are chosen so
that the measured effort is f_exp = f_model(q) + effect, with q as read and the effect as its class states it. SI units.
"""

from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from gravcomp.errors import InputError
from gravcomp.prototype.body import TIME_STEP_S, Prototype

N_AXES = 3


class Range(NamedTuple):
    """From where a parameter is drawn: its size log-uniform in low..high, one of the signs; three values if per_axis.

    Zero to zero: a parameter that is only used when it is given.
    """

    low: float
    high: float
    per_axis: bool = True
    signs: tuple[float, ...] = (1.0,)


EITHER = (-1.0, 1.0)
NOT_DRAWN = Range(0.0, 0.0)


@dataclass
class State:
    """What an effect may see of the prototype in one time step; arrays are (3,), one value per motor."""

    t_s: float = 0.0
    temperature_c: float = 0.0
    q_m: np.ndarray = field(default_factory=lambda: np.zeros(N_AXES))
    v_mps: np.ndarray = field(default_factory=lambda: np.zeros(N_AXES))
    motor_n: np.ndarray = field(default_factory=lambda: np.zeros(N_AXES))
    statics_n: np.ndarray = field(default_factory=lambda: np.zeros(N_AXES))


class Effect:
    """One effect; parameters become attributes, (3,) arrays where they are per axis.

    A parameter that isn't given takes the geometric middle of its range. ``name`` for all axes, ``name1`` for one.
    Raises InputError for a parameter that the effect doesn't have or a value that isn't finite.
    """

    name: ClassVar[str]
    on_list: ClassVar[bool] = True  # does the diagnosis' vocabulary have it?
    ranges: ClassVar[dict[str, Range]] = {}

    def __init__(self, **given: float):
        for name, span in self.ranges.items():
            middle = span.signs[-1] * np.sqrt(span.low * span.high)
            value = np.full(N_AXES, given.pop(name, middle)) if span.per_axis else given.pop(name, middle)
            for axis in range(N_AXES) if span.per_axis else ():
                value[axis] = given.pop(f"{name}{axis + 1}", value[axis])
            if not np.all(np.isfinite(value)):
                raise InputError(f"--effect {self.name}: {name} = {value} is not a finite number; give one")
            setattr(self, name, value)
        if given:
            known = ", ".join(self.ranges) or "none"
            raise InputError(f"--effect {self.name}: unknown parameter {next(iter(given))}; it has {known}")

    @classmethod
    def draw(cls, rng: np.random.Generator) -> "Effect":
        """An effect of random size; the axes differ by up to 30 %."""
        drawn = {}
        for name, span in cls.ranges.items():
            if span.high == 0.0:
                continue
            size = np.exp(rng.uniform(np.log(span.low), np.log(span.high)))
            values = size * (rng.uniform(0.7, 1.3, N_AXES) if span.per_axis else np.ones(1))
            values = values * rng.choice(span.signs, values.size)
            suffixes = ("1", "2", "3") if span.per_axis else ("",)
            drawn |= {f"{name}{suffix}": float(v) for suffix, v in zip(suffixes, values, strict=True)}
        return cls(**drawn)

    def parameters(self) -> dict:
        """Parameters as plain numbers and lists."""
        return {name: np.asarray(getattr(self, name)).tolist() for name in self.ranges}

    def install(self, robot: Prototype) -> None:
        """Change the engine's model, once."""

    def reset(self, state: State) -> None:
        """The robot is put somewhere else, after long travel with this velocity."""

    def friction_n(self, state: State):
        """Coulomb friction level of the carriages in this state, N."""
        return 0.0

    def force_n(self, state: State):
        """Force on the carriages, N, positive along +q."""
        return 0.0

    def shift_m(self, state: State):
        """What the encoders read minus where the carriages are, m."""
        return 0.0

    def effort_n(self, effort_n: np.ndarray, state: State) -> np.ndarray:
        """What the drive reports, N, for what the motors exert."""
        return effort_n


class CoulombFriction(Effect):
    """fc sign(v) on the carriages; ``skew`` adds to it in the positive direction and takes away in the negative."""

    name = "coulomb_friction"
    ranges: ClassVar = {"fc": Range(0.4, 4.0), "skew": NOT_DRAWN}

    def install(self, robot):
        robot.model.dof_frictionloss[robot.motor_dofs] += self.fc

    def force_n(self, state):
        return -self.skew


class ViscousFriction(Effect):
    """b v."""

    name = "viscous_friction"
    ranges: ClassVar = {"b": Range(60.0, 400.0)}

    def install(self, robot):
        robot.model.dof_damping[robot.motor_dofs] += self.b


class StribeckFriction(Effect):
    """(fc + (fs - fc) exp(-(v/vs)^2)) sign(v)."""

    name = "stribeck_friction"
    ranges: ClassVar = {"fc": Range(0.6, 2.0), "fs": Range(2.5, 5.0), "vs": Range(0.002, 0.005, per_axis=False)}

    def friction_n(self, state):
        return self.fc + (self.fs - self.fc) * np.exp(-((state.v_mps / self.vs) ** 2))


class PassiveJointFriction(Effect):
    """Friction in the passive joints: fc_b of the prismatic pairs, N, and fc_phi of the turning pairs, N m."""

    name = "passive_joint_friction"
    ranges: ClassVar = {"fc_b": Range(0.8, 4.0), "fc_phi": Range(0.05, 0.3)}

    def install(self, robot):
        robot.model.dof_frictionloss[robot.dofs("slide")] += self.fc_b
        robot.model.dof_frictionloss[robot.dofs("turn")] += self.fc_phi


class LoadDependentFriction(Effect):
    """mu |f_model| sign(v)."""

    name = "load_dependent_friction"
    ranges: ClassVar = {"mu": Range(0.01, 0.06)}

    def friction_n(self, state):
        return self.mu * np.abs(state.statics_n)


class Backlash(Effect):
    """f_model(q - gap/2 sign(v)) - f_model(q): the encoder, on the motor's side, leads by half the gap."""

    name = "backlash"
    ranges: ClassVar = {"gap": Range(0.0015, 0.004)}

    def reset(self, state):
        self._last_m, self._lead_m = state.q_m, np.sign(state.v_mps) * self.gap / 2

    def shift_m(self, state):
        self._lead_m = np.clip(self._lead_m + state.q_m - self._last_m, -self.gap / 2, self.gap / 2)
        self._last_m = state.q_m
        return self._lead_m


class Cogging(Effect):
    """a1 sin(2 pi q/pitch + p1) + a2 sin(4 pi q/pitch + p2)."""

    name = "cogging"
    ranges: ClassVar = {
        "a": Range(0.4, 3.0),
        "a_second": Range(0.1, 0.5),
        "phase": Range(0.5, 6.0),
        "phase_second": Range(0.5, 6.0),
        "pitch": Range(0.016, 0.048, per_axis=False),
    }

    def force_n(self, state):
        turn = 2 * np.pi * state.q_m / self.pitch
        return -self.a * np.sin(turn + self.phase) - self.a_second * np.sin(2 * turn + self.phase_second)


class Payload(Effect):
    """A mass m, kg, at (x, y, z), m, of the platform frame."""

    name = "payload"
    ranges: ClassVar = {
        "m": Range(0.3, 2.0, per_axis=False),
        **{axis: Range(0.02, 0.12, per_axis=False, signs=EITHER) for axis in "xyz"},
    }

    def install(self, robot):
        robot.model.body("payload").mass[:] = self.m
        robot.model.body("payload").ipos[:] = (self.x, self.y, self.z)


class BaseTilt(Effect):
    """The base, and so gravity as it sees it, turned by small angles about x, y, z of the base."""

    name = "base_tilt"
    ranges: ClassVar = {f"{axis}_deg": Range(0.3, 2.0, per_axis=False, signs=EITHER) for axis in "xyz"}

    def install(self, robot):
        turn = Rotation.from_rotvec([self.x_deg, self.y_deg, self.z_deg], degrees=True)
        robot.model.opt.gravity[:] = turn.apply(robot.model.opt.gravity)


class ThrustConstant(Effect):
    """gain f."""

    name = "thrust_constant"
    ranges: ClassVar = {"gain": Range(0.005, 0.06, signs=EITHER)}

    def effort_n(self, effort_n, state):
        return (1.0 + self.gain) * effort_n


class EncoderOffset(Effect):
    """f_model(q + offset) - f_model(q): the carriage is at the reading plus the offset."""

    name = "encoder_offset"
    ranges: ClassVar = {"offset": Range(0.001, 0.004, signs=EITHER)}

    def shift_m(self, state):
        return -self.offset


class CurrentOffset(Effect):
    """o."""

    name = "current_offset"
    ranges: ClassVar = {"o": Range(0.2, 3.0, signs=EITHER)}

    def effort_n(self, effort_n, state):
        return effort_n + self.o


class CableSpring(Effect):
    """k (q - q0)."""

    name = "cable_spring"
    ranges: ClassVar = {"k": Range(6.0, 60.0), "q0": Range(0.01, 0.06, signs=EITHER)}

    def force_n(self, state):
        return -self.k * (state.q_m - self.q0)


class LinkCompliance(Effect):
    """f_model(q + c f) - f_model(q); c, m/N, is negative, as what is pushed gives way."""

    name = "link_compliance"
    ranges: ClassVar = {"c": Range(1.2e-5, 3e-5, signs=(-1.0,))}

    def reset(self, state):
        self._force_n = state.motor_n

    def shift_m(self, state):
        self._force_n = self._force_n + 0.05 * (state.motor_n - self._force_n)  # bending takes some 20 ms
        return -self.c * self._force_n


class ThermalDrift(Effect):
    """gain (1 - exp(-t/tau)) f, plus gain_per_k (T - 22 deg C) f."""

    name = "thermal_drift"
    ranges: ClassVar = {
        "gain": Range(0.02, 0.1, per_axis=False, signs=EITHER),
        "tau_s": Range(150.0, 1000.0, per_axis=False),
        "gain_per_k": NOT_DRAWN._replace(per_axis=False),
    }

    def effort_n(self, effort_n, state):
        warm = self.gain * (1.0 - np.exp(-state.t_s / self.tau_s)) + self.gain_per_k * (state.temperature_c - 22.0)
        return (1.0 + warm) * effort_n


class Inertia(Effect):
    """A mass m, kg, more on each carriage, carried by a counterweight; slow motion hides it."""

    name = "inertia"
    ranges: ClassVar = {"m": Range(2.0, 20.0)}

    def install(self, robot):
        robot.model.dof_armature[robot.motor_dofs] += self.m


class PreslidingHysteresis(Effect):
    """Dahl friction: dF/dq = (fc/travel)(1 - F sign(v)/fc)."""

    name = "presliding_hysteresis"
    ranges: ClassVar = {"fc": Range(0.6, 3.0), "travel": Range(0.002, 0.006, per_axis=False)}

    def reset(self, state):
        self._friction_n = self.fc * np.sign(state.v_mps)

    def force_n(self, state):
        step = state.v_mps * TIME_STEP_S
        limit = self.fc * np.sign(step)
        self._friction_n = limit + (self._friction_n - limit) * np.exp(-np.abs(step) / self.travel)
        return -self._friction_n


class SoftStop(Effect):
    """k (q - q0)^2 beyond q0 on the positive side."""

    name = "soft_stop"
    on_list = False
    ranges: ClassVar = {"k": Range(600.0, 3000.0), "q0": Range(0.03, 0.07)}

    def force_n(self, state):
        return -self.k * np.maximum(state.q_m - self.q0, 0.0) ** 2


class FrictionBump(Effect):
    """Friction at one place of the guide: fc exp(-((q - q0)/width)^2) sign(v)."""

    name = "friction_bump"
    on_list = False
    ranges: ClassVar = {"fc": Range(1.5, 6.0), "q0": Range(0.005, 0.05, signs=EITHER), "width": Range(0.01, 0.03)}

    def friction_n(self, state):
        return self.fc * np.exp(-(((state.q_m - self.q0) / self.width) ** 2))


class CurrentCrosstalk(Effect):
    """Each drive also reports a part c of the next axis' effort."""

    name = "current_crosstalk"
    on_list = False
    ranges: ClassVar = {"c": Range(0.01, 0.06, signs=EITHER)}

    def effort_n(self, effort_n, state):
        return effort_n + self.c * np.roll(effort_n, -1)


class MagneticSaturation(Effect):
    """Iron saturates: the current of an effort f grows as f (1 + (f/f_sat)^2)."""

    name = "magnetic_saturation"
    on_list = False
    ranges: ClassVar = {"f_sat": Range(250.0, 600.0)}

    def effort_n(self, effort_n, state):
        return effort_n * (1.0 + (effort_n / self.f_sat) ** 2)


class PeriodicDisturbance(Effect):
    """a sin(2 pi t/period): a machine next door."""

    name = "periodic_disturbance"
    on_list = False
    ranges: ClassVar = {"a": Range(0.4, 2.0), "period_s": Range(15.0, 60.0, per_axis=False)}

    def effort_n(self, effort_n, state):
        return effort_n + self.a * np.sin(2 * np.pi * state.t_s / self.period_s)


class StepChange(Effect):
    """The effort jumps by a at t0: something came loose."""

    name = "step_change"
    on_list = False
    ranges: ClassVar = {"a": Range(0.4, 3.0, signs=EITHER), "t0_s": Range(100.0, 600.0, per_axis=False)}

    def effort_n(self, effort_n, state):
        return effort_n + self.a * (state.t_s > self.t0_s)


class UniversalJointFriction(Effect):
    """Friction in both hinges of the universal joints, N m."""

    name = "universal_joint_friction"
    on_list = False
    ranges: ClassVar = {"fc": Range(0.1, 0.5)}

    def install(self, robot):
        for joint in ("inner", "outer"):
            robot.model.dof_frictionloss[robot.dofs(joint)] += self.fc


class PlatformHose(Effect):
    """A hose from the platform to the base: linear springs between the forks' hinges, N m/rad."""

    name = "platform_hose"
    on_list = False
    ranges: ClassVar = {"k": Range(0.3, 2.0)}

    def install(self, robot):
        robot.model.jnt_stiffness[robot.dofs("outer")] += self.k


EFFECTS = {effect.name: effect for effect in Effect.__subclasses__()}
LISTED = [name for name, effect in EFFECTS.items() if effect.on_list]
UNLISTED = [name for name, effect in EFFECTS.items() if not effect.on_list]
# Inertia is asked for by name, with a --speed that shows it.
_RANDOM = {"random": [name for name in LISTED if name != "inertia"], "random_unlisted": UNLISTED}


def parse_effect(text: str, rng: np.random.Generator) -> list[Effect]:
    """Effects named by one --effect: none, one drawn at random, or one by name and parameters. Raises InputError."""
    name, _, settings = text.partition(":")
    if name == "none":
        return []
    if name in _RANDOM:
        return [EFFECTS[str(rng.choice(_RANDOM[name]))].draw(rng)]
    if name not in EFFECTS:
        raise InputError(f"--effect {name}: not known; give one of none, {', '.join([*_RANDOM, *EFFECTS])}")
    given = {}
    for setting in filter(None, settings.split(",")):
        parameter, _, value = setting.partition("=")
        try:
            given[parameter] = float(value)
        except ValueError:
            raise InputError(f"--effect {name}: {setting!r} is not PARAM=NUMBER; correct it") from None
    return [EFFECTS[name](**given)]


def field_effects() -> list[Effect]:
    """What the paper finds in the real robot: friction of the passive joints, static friction, deformation and play.

    The sizes make the analytic model err by about 3.8 % on average at torsion 0, as in the paper's Table 2.
    """
    return [
        PassiveJointFriction(fc_b=2.0, fc_phi=0.35),
        CoulombFriction(fc=0.3),
        LinkCompliance(c=-2e-5),
        Backlash(gap=0.001),
    ]
