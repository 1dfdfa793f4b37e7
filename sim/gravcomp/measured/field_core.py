"""The core after the loop: what was found in measured data, brought into network and compensator of the hardware.

What the found effects add at rest changes the statics: the network is trained on them again. What they add with the
direction or speed of motion is reduced, axis by axis, to the compensator's equation.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import nnls

from gravcomp.measured.fit import Fit
from gravcomp.measured.measurement import Measurement
from gravcomp.network import bittrue
from gravcomp.network.compensation import FixedCompensation, compensator, period_of, quantise_compensation
from gravcomp.network.compensation_csv import Compensation, no_compensation
from gravcomp.network.levenberg_marquardt import ACTIVATIONS, Problem, Stop, levenberg_marquardt
from gravcomp.network.quantise import FixedNetwork, quantise
from gravcomp.network.scaling import workspace_scaling
from gravcomp.network.training import RIDGE, one_blas_thread, snapped
from gravcomp.network.weights import Network
from gravcomp.robot.kinematics import direct_kinematics, inverse_kinematics, jacobian
from gravcomp.robot.parameters import RobotParameters
from gravcomp.robot.statics import holding_forces_at
from gravcomp.robot.workspace import sample_workspace

CLOCK_HZ = 100e6
_V_DEAD_MPS, _V_FULL_MPS = 2e-6, 4e-6  # far below any approach; slower, the direction is not known
_RETRAINING = Stop(steps=150)


@dataclass(frozen=True)
class FieldCore:
    """Integers of network and compensator; forces() are those of the bit-true models."""

    network: FixedNetwork
    constants: Compensation
    compensation: FixedCompensation
    parameters: RobotParameters

    def forces(self, data: Measurement) -> np.ndarray:
        """Forces (n, 3), N, at the counts of data.q and the speed meter's periods at steady speeds data.v."""
        count = np.rint(data.q / self.parameters.encoder_m_per_count).astype(np.int64)
        period = period_of(data.v, self.constants, self.parameters)
        force_mn, _ = compensator(bittrue.core(count, self.network).force_mn, count, period, self.compensation)
        return 1e-3 * force_mn


def build_core(fit: Fit, field: Measurement, start: Network, p: RobotParameters, n_poses: int, seed: int) -> FieldCore:
    """Retrain start on the statics with the fit's effects; reduce the rest at speeds like those of field.v (n, 3)."""
    q_m = inverse_kinematics(sample_workspace(n_poses, p, seed), p)
    moving = _imagined(q_m, _directions(q_m, field, p, seed), p)
    resting = replace(moving, v=np.zeros_like(moving.v))
    at_rest_n = fit.predict(resting)
    statics_n = resting.nominal + at_rest_n
    constants = reduce_to_axes(moving.v, statics_n, fit.predict(moving) - at_rest_n)
    network = quantise(_retrained(start, q_m, statics_n, p), p)
    return FieldCore(network, constants, quantise_compensation(constants, p), p)


def reduce_to_axes(v_mps: np.ndarray, force_n: np.ndarray, effect_n: np.ndarray) -> Compensation:
    """The compensator's constants that come closest to an effect (n, 3), N, at speeds v and forces f (n, 3).

    Per axis: fc_pos, fc_neg, b_pos, b_neg and mu, none negative, by least squares.
    """
    found = no_compensation(v_mps.shape[1])
    for axis, (v, f, effect) in enumerate(zip(v_mps.T, force_n.T, effect_n.T, strict=True)):
        columns = [v > 0, -1.0 * (v < 0), np.maximum(v, 0.0), np.minimum(v, 0.0), np.abs(f) * np.sign(v)]
        scale = np.array([max(np.linalg.norm(column), 1e-12) for column in columns])
        values = nnls(np.stack(columns, axis=-1) / scale, effect)[0] / scale
        for name, value in zip(("fc_pos_n", "fc_neg_n", "b_pos_ns_per_m", "b_neg_ns_per_m", "mu"), values, strict=True):
            getattr(found, name)[axis] = value
    found.clock_hz[:] = CLOCK_HZ
    found.v_dead_mps[:], found.v_full_mps[:] = _V_DEAD_MPS, _V_FULL_MPS
    found.v_max_mps[:] = np.abs(v_mps).max(axis=0)  # beyond what was measured, friction is not extrapolated
    return found


def _directions(q_m: np.ndarray, field: Measurement, p: RobotParameters, seed: int) -> np.ndarray:
    """Velocities (n, 3), m/s, in random directions, as fast as those of the field on average."""
    side = np.random.default_rng([seed, 1]).standard_normal(q_m.shape)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    v = np.einsum("nij,nj->ni", jacobian(direct_kinematics(q_m, p), p), side)
    return v * np.sqrt(np.mean(field.v**2) / np.mean(v**2))


def _imagined(q_m: np.ndarray, v_mps: np.ndarray, p: RobotParameters) -> Measurement:
    """Samples at which the found effects are asked for; nothing was measured there."""
    nominal = holding_forces_at(q_m, p)
    return Measurement(
        "workspace",
        np.zeros(len(q_m)),
        q_m,
        v_mps,
        nominal,
        nominal,
        "N",
        ("m",) * 3,
        force_at=lambda at: holding_forces_at(at, p),
        robot=p,
    )


def _retrained(start: Network, q_m: np.ndarray, force_n: np.ndarray, p: RobotParameters) -> Network:
    scaling = workspace_scaling(p)
    x, y = scaling.x(q_m), scaling.y(force_n)
    problem = Problem(x, y, start.n_hidden, ACTIVATIONS["gamma"], None, RIDGE)
    hidden = np.c_[start.hidden_weights, start.hidden_bias]
    with one_blas_thread():
        return snapped(levenberg_marquardt(problem, hidden, _RETRAINING), problem, scaling, p)
