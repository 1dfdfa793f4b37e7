"""What the virtual prototype's physics can have and the analytic model lacks.

Each effect acts where it would in the machine: on the engine's model (masses, springs, dampers, friction in joints),
as a force on the axes, on the encoder's reading, or on the current that the drive reports. Signs are chosen so that the
measured effort is f_exp = f_model(q) + effect, with q as read and the effect as its class states it. SI units: efforts
f in N of linear axes and N m of rotary ones, positions q in m and rad.

Ranges are stated for the Sphe.I.Ro.; on another machine they follow its sizes.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from gravcomp.errors import InputError
from gravcomp.prototype.body import Prototype
from gravcomp.prototype.engine import TIME_STEP_S, Engine
from gravcomp.prototype.sizes import SPHEIRO, Sizes

# Powers of effort, position, mass and length.
_DIMENSIONS = {
    "": (0, 0, 0, 0), "f": (1, 0, 0, 0), "q": (0, 1, 0, 0), "f/q": (1, -1, 0, 0), "q/f": (-1, 1, 0, 0),
    "f/q^2": (1, -2, 0, 0), "kg": (0, 0, 1, 0), "m": (0, 0, 0, 1), "kg m": (0, 0, 1, 1),
}  # fmt: skip


class Range(NamedTuple):
    """From where a parameter is drawn: its size log-uniform in low..high, in a unit, one of the signs.

    per: a value per "axis", per passive slide ("m") or hinge ("rad"), or one of the "machine". Zero to zero: a
    parameter that is only used when it is given. must_be: what a given value is held to, a key of _ALLOWED.
    """

    low: float
    high: float
    unit: str = ""
    per: str = "axis"
    signs: tuple[float, ...] = (1.0,)
    must_be: str = "a finite number"

    def size(self, sizes: Sizes) -> np.ndarray | float:
        """What low and high are multiplied with on a machine."""
        return sizes.of(self.per, *_DIMENSIONS[self.unit])


_ALLOWED = {
    "a finite number": np.isfinite,
    "a finite number of 0 or more": lambda value: np.isfinite(value) & (value >= 0.0),
    "a finite number above 0": lambda value: np.isfinite(value) & (value > 0.0),  # as the effect divides by it
}
NOT_NEGATIVE, DIVIDES = list(_ALLOWED)[1:]
EITHER = (-1.0, 1.0)
NOT_DRAWN = Range(0.0, 0.0)


@dataclass
class PlantState:
    """What an effect may see of the prototype in one time step; arrays are (n,), one value per axis: where it is, how
    fast, what its motor exerts, what the model says that holds it."""

    q: np.ndarray
    v: np.ndarray
    motor: np.ndarray
    statics: np.ndarray
    t_s: float = 0.0
    temperature_c: float = 0.0


class Imperfection:
    """One effect on a machine of given sizes; parameters become attributes, arrays where they are per axis or joint.

    A parameter that isn't given takes the geometric middle of its range. ``name`` for all axes, ``name1`` for one.
    Raises InputError for a parameter that the effect doesn't have or a value that its range doesn't allow.
    """

    name: ClassVar[str]
    on_list: ClassVar[bool] = True  # does the diagnosis' vocabulary have it?
    ranges: ClassVar[dict[str, Range]] = {}

    def __init__(self, sizes: Sizes = SPHEIRO, /, **given: float):
        self.sizes = sizes
        for name, span in self.ranges.items():
            middle = span.signs[-1] * np.sqrt(span.low * span.high) * span.size(sizes)
            count = sizes.count(span.per)
            value = np.full(count, given.pop(name, middle)) if count else given.pop(name, middle)
            for axis in range(count):
                value[axis] = given.pop(f"{name}{axis + 1}", value[axis])
            if not np.all(_ALLOWED[span.must_be](value)):
                raise InputError(f"--effect {self.name}: {name} = {value} is not {span.must_be}; give one")
            setattr(self, name, value)
        if given:
            known = ", ".join(self.ranges) or "none"
            raise InputError(f"--effect {self.name}: unknown parameter {next(iter(given))}; it has {known}")

    @classmethod
    def is_of(cls, engine: Engine, sizes: Sizes) -> bool:
        """Can a machine have it?"""
        return True

    @classmethod
    def draw(cls, rng: np.random.Generator, sizes: Sizes = SPHEIRO, **given) -> "Imperfection":
        """An effect of random size; the axes differ by up to 30 %. given: parameters that are not drawn."""
        drawn = {}
        for name, span in cls.ranges.items():
            count = sizes.count(span.per)
            if span.high == 0.0 or (span.per in sizes.n_passive and not count):
                continue
            size = np.exp(rng.uniform(np.log(span.low), np.log(span.high)))
            values = size * (rng.uniform(0.7, 1.3, count) if count else np.ones(1))
            values = values * rng.choice(span.signs, values.size) * span.size(sizes)
            suffixes = [str(k + 1) for k in range(count)] or [""]
            drawn |= {f"{name}{suffix}": float(v) for suffix, v in zip(suffixes, values, strict=True)}
        return cls(sizes, **drawn, **given)

    def parameters(self) -> dict:
        """Parameters as plain numbers and lists."""
        return {name: np.asarray(getattr(self, name)).tolist() for name in self.ranges}

    def install(self, robot: Engine) -> None:
        """Change the engine's model, once."""

    def reset(self, state: PlantState) -> None:
        """The robot is put somewhere else, after long travel with this velocity."""

    def friction(self, state: PlantState):
        """Coulomb friction level of the axes in this state."""
        return 0.0

    def force(self, state: PlantState):
        """Effort on the axes, positive along +q."""
        return 0.0

    def shift(self, state: PlantState):
        """What the encoders read minus where the axes are."""
        return 0.0

    def reported(self, effort: np.ndarray, state: PlantState) -> np.ndarray:
        """What the drive reports for what the motors exert."""
        return effort


class CoulombFriction(Imperfection):
    """fc sign(v) on the carriages; ``skew`` adds to it in the positive direction and takes away in the negative."""

    name = "coulomb_friction"
    ranges: ClassVar = {"fc": Range(0.4, 4.0, "f", must_be=NOT_NEGATIVE), "skew": NOT_DRAWN}

    def install(self, robot):
        robot.model.dof_frictionloss[robot.motor_dofs] += self.fc

    def force(self, state):
        return -self.skew


class ViscousFriction(Imperfection):
    """b v."""

    name = "viscous_friction"
    ranges: ClassVar = {"b": Range(60.0, 400.0, "f/q", must_be=NOT_NEGATIVE)}

    def install(self, robot):
        robot.model.dof_damping[robot.motor_dofs] += self.b


class StribeckFriction(Imperfection):
    """(fc + (fs - fc) exp(-(v/vs)^2)) sign(v)."""

    name = "stribeck_friction"
    ranges: ClassVar = {
        "fc": Range(0.6, 2.0, "f", must_be=NOT_NEGATIVE),
        "fs": Range(2.5, 5.0, "f", must_be=NOT_NEGATIVE),
        "vs": Range(0.002, 0.005, "q", per="machine", must_be=DIVIDES),
    }

    def friction(self, state):
        return self.fc + (self.fs - self.fc) * np.exp(-((state.v / self.vs) ** 2))


class PassiveJointFriction(Imperfection):
    """Friction in the passive joints: fc_b of the prismatic pairs, N, and fc_phi of the turning pairs, N m."""

    name = "passive_joint_friction"
    ranges: ClassVar = {
        "fc_b": Range(0.8, 4.0, "f", "m", must_be=NOT_NEGATIVE),
        "fc_phi": Range(0.05, 0.3, "f", "rad", must_be=NOT_NEGATIVE),
    }

    @classmethod
    def is_of(cls, engine, sizes):
        return any(sizes.n_passive.values())

    def install(self, robot):
        robot.model.dof_frictionloss[robot.passive_dofs("m")] += self.fc_b
        robot.model.dof_frictionloss[robot.passive_dofs("rad")] += self.fc_phi


class LoadDependentFriction(Imperfection):
    """mu |f_model| sign(v)."""

    name = "load_dependent_friction"
    ranges: ClassVar = {"mu": Range(0.01, 0.06, must_be=NOT_NEGATIVE)}

    def friction(self, state):
        return self.mu * np.abs(state.statics)


class DirectionalLoadFriction(Imperfection):
    """mu |f_model| sign(v), another mu where the motor drives the load than where the load drives the motor."""

    name = "directional_load_friction"
    ranges: ClassVar = {
        "mu_motor": Range(0.02, 0.08, must_be=NOT_NEGATIVE),
        "mu_load": Range(0.005, 0.02, must_be=NOT_NEGATIVE),
    }

    def friction(self, state):
        return np.where(state.statics * state.v > 0.0, self.mu_motor, self.mu_load) * np.abs(state.statics)


class Backlash(Imperfection):
    """f_model(q - gap/2 sign(v)) - f_model(q): the encoder, on the motor's side, leads by half the gap."""

    name = "backlash"
    ranges: ClassVar = {"gap": Range(0.0015, 0.004, "q", must_be=NOT_NEGATIVE)}

    def reset(self, state):
        self._last, self._lead = state.q, np.sign(state.v) * self.gap / 2

    def shift(self, state):
        self._lead = np.clip(self._lead + state.q - self._last, -self.gap / 2, self.gap / 2)
        self._last = state.q
        return self._lead


class Cogging(Imperfection):
    """a1 sin(2 pi q/pitch + p1) + a2 sin(4 pi q/pitch + p2)."""

    name = "cogging"
    ranges: ClassVar = {
        "a": Range(0.4, 3.0, "f"),
        "a_second": Range(0.1, 0.5, "f"),
        "phase": Range(0.5, 6.0),
        "phase_second": Range(0.5, 6.0),
        "pitch": Range(0.016, 0.048, "q", per="machine", must_be=DIVIDES),
    }

    def force(self, state):
        turn = 2 * np.pi * state.q / self.pitch
        return -self.a * np.sin(turn + self.phase) - self.a_second * np.sin(2 * turn + self.phase_second)


class Payload(Imperfection):
    """A mass m, kg, at (x, y, z), m, in the frame of the body that takes a payload, of the Sphe.I.Ro. the platform."""

    name = "payload"
    ranges: ClassVar = {
        "m": Range(0.3, 2.0, "kg", per="machine"),
        **{axis: Range(0.02, 0.12, "m", "machine", EITHER) for axis in "xyz"},
    }

    def install(self, robot):
        robot.add_mass(self.m, np.array([self.x, self.y, self.z]))


class BaseTilt(Imperfection):
    """The base, and so gravity as it sees it, turned by small angles about x, y, z of the base."""

    name = "base_tilt"
    ranges: ClassVar = {f"{axis}_deg": Range(0.3, 2.0, per="machine", signs=EITHER) for axis in "xyz"}

    def install(self, robot):
        turn = Rotation.from_rotvec([self.x_deg, self.y_deg, self.z_deg], degrees=True)
        robot.model.opt.gravity[:] = turn.apply(robot.model.opt.gravity)


class ThrustConstant(Imperfection):
    """gain f."""

    name = "thrust_constant"
    ranges: ClassVar = {"gain": Range(0.005, 0.06, signs=EITHER)}

    def reported(self, effort, state):
        return (1.0 + self.gain) * effort


class EncoderOffset(Imperfection):
    """f_model(q + offset) - f_model(q): the carriage is at the reading plus the offset."""

    name = "encoder_offset"
    ranges: ClassVar = {"offset": Range(0.001, 0.004, "q", signs=EITHER)}

    def shift(self, state):
        return -self.offset


class CurrentOffset(Imperfection):
    """o."""

    name = "current_offset"
    ranges: ClassVar = {"o": Range(0.2, 3.0, "f", signs=EITHER)}

    def reported(self, effort, state):
        return effort + self.o


class CableSpring(Imperfection):
    """k (q - q0)."""

    name = "cable_spring"
    ranges: ClassVar = {"k": Range(6.0, 60.0, "f/q"), "q0": Range(0.01, 0.06, "q", signs=EITHER)}

    def force(self, state):
        return -self.k * (state.q - self.q0)


class LinkCompliance(Imperfection):
    """f_model(q + c f) - f_model(q); c, m/N, is negative, as what is pushed gives way."""

    name = "link_compliance"
    ranges: ClassVar = {"c": Range(1.2e-5, 3e-5, "q/f", signs=(-1.0,))}

    def reset(self, state):
        self._force = state.motor

    def shift(self, state):
        self._force = self._force + 0.05 * (state.motor - self._force)  # bending takes some 20 ms
        return -self.c * self._force


class ThermalDrift(Imperfection):
    """gain (1 - exp(-t/tau)) f, plus gain_per_k (T - 22 deg C) f."""

    name = "thermal_drift"
    ranges: ClassVar = {
        "gain": Range(0.02, 0.1, per="machine", signs=EITHER),
        "tau_s": Range(150.0, 1000.0, per="machine", must_be=DIVIDES),
        "gain_per_k": NOT_DRAWN._replace(per="machine"),
    }

    def reported(self, effort, state):
        warm = self.gain * (1.0 - np.exp(-state.t_s / self.tau_s)) + self.gain_per_k * (state.temperature_c - 22.0)
        return (1.0 + warm) * effort


class Inertia(Imperfection):
    """A mass m, kg, more on each carriage, carried by a counterweight; slow motion hides it."""

    name = "inertia"
    ranges: ClassVar = {"m": Range(2.0, 20.0, "f/q")}

    def install(self, robot):
        robot.model.dof_armature[robot.motor_dofs] += self.m


class PreslidingHysteresis(Imperfection):
    """Dahl friction: dF/dq = (fc/travel)(1 - F sign(v)/fc)."""

    name = "presliding_hysteresis"
    ranges: ClassVar = {
        "fc": Range(0.6, 3.0, "f", must_be=NOT_NEGATIVE),
        "travel": Range(0.002, 0.006, "q", per="machine", must_be=DIVIDES),
    }

    def reset(self, state):
        self._friction = self.fc * np.sign(state.v)

    def force(self, state):
        step = state.v * TIME_STEP_S
        limit = self.fc * np.sign(step)
        self._friction = limit + (self._friction - limit) * np.exp(-np.abs(step) / self.travel)
        return -self._friction


class BodyMoment(Imperfection):
    """A first moment (x, y, z), kg m, in the frame of a body: its mass is not where the model has it."""

    name = "body_moment"
    ranges: ClassVar = {axis: Range(0.02, 0.2, "kg m", "machine", EITHER) for axis in "xyz"}

    def __init__(self, sizes: Sizes = SPHEIRO, /, body: str = "", **given: float):
        super().__init__(sizes, **given)
        self.body = body

    @classmethod
    def is_of(cls, engine, sizes):
        return bool(engine.heavy_bodies)

    def parameters(self):
        return {"body": self.body, **super().parameters()}

    def install(self, robot):
        self.body = self.body or robot.heavy_bodies[-1]
        robot.add_moment(self.body, np.array([self.x, self.y, self.z]))


class SoftStop(Imperfection):
    """k (q - q0)^2 beyond q0 on the positive side."""

    name = "soft_stop"
    on_list = False
    ranges: ClassVar = {"k": Range(600.0, 3000.0, "f/q^2"), "q0": Range(0.03, 0.07, "q")}

    def force(self, state):
        return -self.k * np.maximum(state.q - self.q0, 0.0) ** 2


class FrictionBump(Imperfection):
    """Friction at one place of the guide: fc exp(-((q - q0)/width)^2) sign(v)."""

    name = "friction_bump"
    on_list = False
    ranges: ClassVar = {
        "fc": Range(1.5, 6.0, "f", must_be=NOT_NEGATIVE),
        "q0": Range(0.005, 0.05, "q", signs=EITHER),
        "width": Range(0.01, 0.03, "q", must_be=DIVIDES),
    }

    def friction(self, state):
        return self.fc * np.exp(-(((state.q - self.q0) / self.width) ** 2))


class CurrentCrosstalk(Imperfection):
    """Each drive also reports a part c of the next axis' effort."""

    name = "current_crosstalk"
    on_list = False
    ranges: ClassVar = {"c": Range(0.01, 0.06, signs=EITHER)}

    def reported(self, effort, state):
        return effort + self.c * self.sizes.effort * np.roll(effort / self.sizes.effort, -1)


class MagneticSaturation(Imperfection):
    """Iron saturates: the current of an effort f grows as f (1 + (f/f_sat)^2)."""

    name = "magnetic_saturation"
    on_list = False
    ranges: ClassVar = {"f_sat": Range(250.0, 600.0, "f", must_be=DIVIDES)}

    def reported(self, effort, state):
        return effort * (1.0 + (effort / self.f_sat) ** 2)


class PeriodicDisturbance(Imperfection):
    """a sin(2 pi t/period): a machine next door."""

    name = "periodic_disturbance"
    on_list = False
    ranges: ClassVar = {"a": Range(0.4, 2.0, "f"), "period_s": Range(15.0, 60.0, per="machine", must_be=DIVIDES)}

    def reported(self, effort, state):
        return effort + self.a * np.sin(2 * np.pi * state.t_s / self.period_s)


class OffsetStep(Imperfection):
    """The effort jumps by a at t0: something came loose."""

    name = "offset_step"
    ranges: ClassVar = {"a": Range(0.4, 3.0, "f", signs=EITHER), "t0_s": Range(100.0, 600.0, per="machine")}

    def reported(self, effort, state):
        return effort + self.a * (state.t_s > self.t0_s)


class UniversalJointFriction(Imperfection):
    """Friction in both hinges of the universal joints, N m."""

    name = "universal_joint_friction"
    ranges: ClassVar = {"fc": Range(0.1, 0.5, must_be=NOT_NEGATIVE)}

    @classmethod
    def is_of(cls, engine, sizes):
        return isinstance(engine, Prototype)

    def install(self, robot):
        for joint in ("inner", "outer"):
            robot.model.dof_frictionloss[robot.dofs(joint)] += self.fc


class PlatformHose(Imperfection):
    """A hose from the platform to the base: linear springs between the forks' hinges, N m/rad."""

    name = "platform_hose"
    ranges: ClassVar = {"k": Range(0.3, 2.0)}

    @classmethod
    def is_of(cls, engine, sizes):
        return isinstance(engine, Prototype)

    def install(self, robot):
        robot.model.jnt_stiffness[robot.dofs("outer")] += self.k


EFFECTS = {effect.name: effect for effect in Imperfection.__subclasses__()}
LISTED = [name for name, effect in EFFECTS.items() if effect.on_list]
UNLISTED = [name for name, effect in EFFECTS.items() if not effect.on_list]
# Inertia is asked for by name, with a --speed that shows it.
_RANDOM = {"random": [name for name in LISTED if name != "inertia"], "random_unlisted": UNLISTED}


def drawable(names: Sequence[str], engine: Engine, sizes: Sizes) -> list[str]:
    """Those of the effects by name that a machine can have."""
    return [name for name in names if EFFECTS[name].is_of(engine, sizes)]


def drawn(name: str, rng: np.random.Generator, engine: Engine, sizes: Sizes) -> Imperfection:
    """The effect of a name, of random size, on a random body if it is of one."""
    given = {"body": str(rng.choice(engine.heavy_bodies))} if name == BodyMoment.name else {}
    return EFFECTS[name].draw(rng, sizes, **given)


def parse_effect(text: str, rng: np.random.Generator, engine: Engine, sizes: Sizes) -> list[Imperfection]:
    """Effects named by one --effect: none, one drawn at random, or one by name and parameters. Raises InputError."""
    name, _, settings = text.partition(":")
    if settings and (name == "none" or name in _RANDOM):
        raise InputError(f"--effect {name}: takes no parameters, {settings!r} is left over; remove it")
    if name == "none":
        return []
    if name in _RANDOM:
        return [drawn(str(rng.choice(drawable(_RANDOM[name], engine, sizes))), rng, engine, sizes)]
    if name not in EFFECTS:
        raise InputError(f"--effect {name}: not known; give one of none, {', '.join([*_RANDOM, *EFFECTS])}")
    if not EFFECTS[name].is_of(engine, sizes):
        known = ", ".join(drawable(list(EFFECTS), engine, sizes))
        raise InputError(f"--effect {name}: this machine has nothing for it to act on; give one of {known}")
    return [EFFECTS[name](sizes, **_settings(name, settings))]


def _settings(name: str, text: str) -> dict:
    given = {}
    for setting in filter(None, text.split(",")):
        parameter, _, value = setting.partition("=")
        if parameter in given:
            raise InputError(f"--effect {name}: {parameter} is given twice; remove one")
        if name == BodyMoment.name and parameter == "body":
            given[parameter] = value
            continue
        try:
            given[parameter] = float(value)
        except ValueError:
            raise InputError(f"--effect {name}: {setting!r} is not PARAM=NUMBER; correct it") from None
    return given


def field_effects() -> list[Imperfection]:
    """What the paper finds in the real robot: friction of the passive joints, static friction, deformation and play.

    The sizes make the analytic model err by about 3.8 % on average at torsion 0, as in the paper's Table 2.
    """
    return [
        PassiveJointFriction(fc_b=2.0, fc_phi=0.35),
        CoulombFriction(fc=0.3),
        LinkCompliance(c=-2e-5),
        Backlash(gap=0.001),
    ]
