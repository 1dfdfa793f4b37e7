"""The cogging of an axis as its motor's shaft sees it: harmonics of one turn of the motor."""

from dataclasses import dataclass

import numpy as np

from gravcomp.core.compensation import Compensation
from gravcomp.errors import InputError
from gravcomp.robot.machine import Axis

MAX_DRIFT_RAD = 0.1  # of the highest harmonic's phase over the axis' range: a tenth of its amplitude


@dataclass(frozen=True)
class Motor:
    """What turns an axis: q = zero + turn theta, theta in turns of the motor as the drive's encoder counts them.

    turn: travel per turn, m or rad, negative where the axis falls as the motor's position rises; zero: m or rad.
    """

    turn: float
    zero: float


@dataclass(frozen=True)
class MotorCogging:
    """torque(theta) = sum of amplitude_nm sin(2 pi order theta + phase_rad), theta in turns; order, amplitude and phase
    (k,). Positive along +theta. Ideal transmission: torque dtheta = effort dq."""

    order: np.ndarray
    amplitude_nm: np.ndarray
    phase_rad: np.ndarray
    amperes_per_nm: float

    def torque_nm(self, theta_turns: np.ndarray) -> np.ndarray:
        """Nm at the motor's shaft (...), at theta_turns (...)."""
        angle = 2 * np.pi * np.asarray(theta_turns)[..., None] * self.order + self.phase_rad
        return np.sum(self.amplitude_nm * np.sin(angle), axis=-1)

    def current_a(self, theta_turns: np.ndarray) -> np.ndarray:
        """Amperes (...), positive where the motor drives along +theta."""
        return self.amperes_per_nm * self.torque_nm(theta_turns)


def motor_cogging(c: Compensation, index: int, axis: Axis, motor: Motor) -> MotorCogging:
    """Harmonics of the motor's turn. Raises InputError where the pitch is no whole part of a turn.

    effort = a sin(2 pi h q / pitch + p) becomes torque = a turn/(2 pi) sin(2 pi h n theta + 2 pi h zero/pitch + p),
    n = turn/pitch, which has to be whole: a drive's table ends with the motor's turn.
    """
    harmonic = np.flatnonzero(c.amplitude[index]) + 1
    pitch = c.pitch[index]
    per_turn = round(motor.turn / pitch)
    travel = max(abs(axis.low - motor.zero), abs(axis.high - motor.zero))
    drift = np.inf if per_turn == 0 else 2 * np.pi * harmonic.max() * travel * abs(1 / pitch - per_turn / motor.turn)
    if drift > MAX_DRIFT_RAD:
        raise InputError(f"--turn: axis {index + 1}: its pitch of {pitch:g} {axis.unit} is no whole part of "
                         f"{motor.turn:g} {axis.unit}, the travel per turn of the motor (over the axis' range the wave "
                         f"would shift by {drift:.2g} rad); correct --turn, or measure the pitch again")  # fmt: skip
    phase = c.phase_rad[index, harmonic - 1] + 2 * np.pi * harmonic * motor.zero / pitch
    wave = c.amplitude[index, harmonic - 1] * motor.turn / (2 * np.pi) * np.exp(1j * phase)
    wave = wave if per_turn > 0 else -np.conj(wave)  # sin(-x + p) = -sin(x - p)
    amperes_per_nm = 2 * np.pi / (abs(motor.turn) * axis.effort_per_ampere)
    return MotorCogging(harmonic * abs(per_turn), np.abs(wave), np.angle(wave), amperes_per_nm)
