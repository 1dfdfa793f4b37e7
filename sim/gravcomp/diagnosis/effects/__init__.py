"""The vocabulary: every effect that a diagnosis can name. One file per effect, one line here."""

from gravcomp.diagnosis.effects.backlash import Backlash, BacklashInMotion
from gravcomp.diagnosis.effects.base import Effect
from gravcomp.diagnosis.effects.base_tilt import BaseTilt
from gravcomp.diagnosis.effects.cable_spring import CableSpring
from gravcomp.diagnosis.effects.cogging import Cogging
from gravcomp.diagnosis.effects.coulomb_friction import CoulombFriction, DirectionalCoulombFriction
from gravcomp.diagnosis.effects.current_offset import CurrentOffset
from gravcomp.diagnosis.effects.encoder_offset import EncoderOffset
from gravcomp.diagnosis.effects.inertia import Inertia
from gravcomp.diagnosis.effects.link_compliance import LinkCompliance
from gravcomp.diagnosis.effects.load_dependent_friction import LoadDependentFriction
from gravcomp.diagnosis.effects.passive_joint_friction import PassiveJointFriction
from gravcomp.diagnosis.effects.payload import Payload
from gravcomp.diagnosis.effects.presliding_hysteresis import PreslidingHysteresis
from gravcomp.diagnosis.effects.stribeck_friction import StribeckFriction
from gravcomp.diagnosis.effects.thermal_drift import ThermalDrift
from gravcomp.diagnosis.effects.thrust_constant import ThrustConstant
from gravcomp.diagnosis.effects.viscous_friction import DirectionalViscousFriction, ViscousFriction

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
