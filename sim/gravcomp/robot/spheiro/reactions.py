"""Forces across the passive slides of the Sphe.I.Ro. at rest, in closed form.

A leg pushes the platform at its universal joint P_i with F_i = x_e e_i + x_t t_i + x_w w_i and the moment m_i c_i,
c_i = t_i x R u_i, about the one axis that the joint does not turn about. Link 2 slides, so x_w bears its weight alone;
the leg turns about e_i, which gives x_t. Six balances of the platform give x_e and m of three legs.
"""

import numpy as np

from gravcomp.robot.spheiro.kinematics import link_axes, platform_axes
from gravcomp.robot.spheiro.parameters import RobotParameters


def slide_reactions(rotation: np.ndarray, p: RobotParameters) -> np.ndarray:
    """Size of the force, N, that each passive slide bears across its direction, (..., 3); rotation (..., 3, 3)."""
    return np.linalg.norm(_across(rotation, p)[0], axis=-1)


def _across(rotation: np.ndarray, p: RobotParameters) -> tuple[np.ndarray, np.ndarray]:
    """Forces of link 1 on link 2 across the slides, and of the legs on the platform, (..., 3, 3), a row per leg."""
    a, e, g = np.swapaxes(platform_axes(rotation), -1, -2), np.eye(3), p.gravity_mps2
    points = p.d_m * a
    b, w = link_axes(points)
    t = np.cross(e, w)
    c = np.cross(t, a)
    lever = (p.link1_com_m * p.link1_mass_kg + (b - p.link2_com_m) * p.link2_mass_kg) / b
    known = (lever * (t @ g))[..., None] * t + (p.link2_mass_kg * (w @ g))[..., None] * w
    weight = p.platform_mass_kg * g
    load = np.concatenate(
        [
            known.sum(axis=-2) + weight,
            np.cross(points, known).sum(axis=-2) + np.cross(rotation @ p.platform_com_m, weight),
        ],
        axis=-1,
    )
    by_moment = t / p.d_m  # force that goes with a moment of one
    unknown = np.concatenate(
        [
            np.concatenate([np.broadcast_to(e, points.shape), np.cross(points, e)], axis=-1),
            np.concatenate([by_moment, np.cross(points, by_moment) + c], axis=-1),
        ],
        axis=-2,
    )
    solved = np.linalg.solve(np.swapaxes(unknown, -1, -2), -load[..., None])[..., 0]
    force = known + solved[..., :3, None] * e + solved[..., 3:, None] * by_moment
    borne = force - p.link2_mass_kg * g
    return borne - (borne * w).sum(axis=-1, keepdims=True) * w, force
