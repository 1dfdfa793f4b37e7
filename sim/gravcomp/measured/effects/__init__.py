"""The vocabulary: every effect that a diagnosis can name. One file per effect, one line here."""

from gravcomp.measured.effects.backlash import Backlash, BacklashInMotion
from gravcomp.measured.effects.base import Effect
from gravcomp.measured.effects.base_tilt import BaseTilt
from gravcomp.measured.effects.cable_spring import CableSpring
from gravcomp.measured.effects.cogging import Cogging
from gravcomp.measured.effects.coulomb_friction import CoulombFriction, DirectionalCoulombFriction
from gravcomp.measured.effects.current_offset import CurrentOffset
from gravcomp.measured.effects.encoder_offset import EncoderOffset
from gravcomp.measured.effects.inertia import Inertia
from gravcomp.measured.effects.link_compliance import LinkCompliance
from gravcomp.measured.effects.load_dependent_friction import LoadDependentFriction
from gravcomp.measured.effects.passive_joint_friction import PassiveJointFriction
from gravcomp.measured.effects.payload import Payload
from gravcomp.measured.effects.presliding_hysteresis import PreslidingHysteresis
from gravcomp.measured.effects.stribeck_friction import StribeckFriction
from gravcomp.measured.effects.thermal_drift import ThermalDrift
from gravcomp.measured.effects.thrust_constant import ThrustConstant
from gravcomp.measured.effects.viscous_friction import DirectionalViscousFriction, ViscousFriction

EFFECTS = (
    CoulombFriction,
    DirectionalCoulombFriction,
    ViscousFriction,
    DirectionalViscousFriction,
    StribeckFriction,
    PassiveJointFriction,
    LoadDependentFriction,
    Backlash,
    BacklashInMotion,
    Cogging,
    Payload,
    BaseTilt,
    ThrustConstant,
    EncoderOffset,
    CurrentOffset,
    CableSpring,
    LinkCompliance,
    ThermalDrift,
    Inertia,
    PreslidingHysteresis,
)
NAMES = tuple(dict.fromkeys(effect.name for effect in EFFECTS))


def effect_named(name: str) -> Effect:
    """An effect by its name; KeyError when it is not in the vocabulary."""
    return {effect.name: effect for effect in reversed(EFFECTS)}[name]()
