"""Two stages that the compensator lacks, measured before anything is built: play, and friction of passive joints.

Play: the encoder leads the joint by half the gap, so the force errs by f(q - gap/2 z) - f(q), z = +-1 the side of the
gap; a stage would hold z per axis and subtract. Passive joints' friction: f = J_p^T (fc sign(J_p v)), now in the
compensator as the Coulomb friction of each axis that is nearest to it; a stage would hold J_p(q) as a polynomial.
"""

from dataclasses import dataclass

import numpy as np
from sklearn.preprocessing import PolynomialFeatures

from gravcomp.prototype.experiment import measure
from gravcomp.prototype.imperfections import EFFECTS
from gravcomp.robot.machine import Machine
from gravcomp.robot.spheiro.kinematics import inverse_kinematics, jacobian
from gravcomp.robot.spheiro.robot import spheiro_of
from gravcomp.robot.spheiro.workspace import sample_workspace

N_POSES = 4000
GAPS_M = (1e-5, 2e-5, 5e-5, 1e-4, 2e-4)
DEGREES = (0, 1, 2, 3)


@dataclass(frozen=True)
class Motions:
    """Poses drawn from the workspace, moving each in a random direction: q, v, force (n, 3), J_p (n, 6, 3)."""

    q: np.ndarray
    v: np.ndarray
    force: np.ndarray
    passive: np.ndarray
    is_prismatic: np.ndarray

    @classmethod
    def draw(cls, machine: Machine, seed: int = 1) -> "Motions":
        rng, p = np.random.default_rng(seed), spheiro_of(machine)
        rotation = sample_workspace(N_POSES, p, seed)
        q = inverse_kinematics(rotation, p)
        v = np.einsum("nij,nj->ni", jacobian(rotation, p), rng.standard_normal(q.shape))
        robot = machine.robot
        is_prismatic = np.array([unit == "m" for unit in robot.passive_units])
        return cls(q, v, robot.forces(q), robot.passive_jacobian(q), is_prismatic)

    @property
    def is_test(self) -> np.ndarray:
        return np.arange(len(self.q)) % 4 == 3


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def play_error(machine: Machine, motions: Motions, gap_m: float) -> np.ndarray:
    """Force error (n, 3), N, of a play that no stage corrects; the side is that of the motion."""
    return machine.robot.forces(motions.q - gap_m / 2.0 * np.sign(motions.v)) - motions.force


def friction(jacobian: np.ndarray, v: np.ndarray) -> np.ndarray:
    """J^T sign(J v) (n, 3): friction of one newton or newton metre in every joint; jacobian (n, p, 3)."""
    return np.einsum("npk,np->nk", jacobian, np.sign(np.einsum("npk,nk->np", jacobian, v)))


def by_axis(force: np.ndarray, v: np.ndarray, is_test: np.ndarray) -> np.ndarray:
    """The Coulomb friction of each axis that is nearest to it on the training poses, as the compensator has it."""
    level = np.mean((force * np.sign(v))[~is_test], axis=0)
    return level * np.sign(v)


def fitted_jacobian(motions: Motions, degree: int) -> np.ndarray:
    """J_p (n, 6, 3) as polynomials of the positions, fitted on the training poses."""
    x = PolynomialFeatures(degree).fit_transform(motions.q / np.abs(motions.q).max())
    flat, train = motions.passive.reshape(len(x), -1), ~motions.is_test
    return (x @ np.linalg.lstsq(x[train], flat[train], rcond=None)[0]).reshape(motions.passive.shape)


def friction_left(motions: Motions, joints: np.ndarray) -> dict[str, tuple[float, int]]:
    """RMS in N that a stage leaves of one newton or newton metre in the joints (6,), held out; its multiplications."""
    own, test = motions.passive[:, joints], motions.is_test
    true = friction(own, motions.v)
    nearest = by_axis(true, motions.v, test)
    out = {"none": (rms(true[test]), 0), "Coulomb friction of each axis": (rms((true - nearest)[test]), 0)}
    n_entries = motions.passive[0].size  # of all joints: a stage holds them together
    for degree in DEGREES:
        found = friction(fitted_jacobian(motions, degree)[:, joints], motions.v)
        n_terms = len(PolynomialFeatures(degree).fit(motions.q[:1]).powers_) - 1
        # terms of the polynomial, their products beyond degree 1, and J v; the signs choose additions
        products = n_entries * n_terms + max(n_terms - 3, 0) + n_entries
        out[f"J_p(q) of degree {degree}"] = (rms((true - found)[test]), products)
    return out


def prototype_left(machine: Machine, n_holds: int, seed: int = 3) -> dict[str, float]:
    """RMS in N that each stage leaves of the passive joints' friction of the virtual prototype, held out, no noise; the
    two levels of the friction are fitted to the other holds.
    """
    log = measure(machine, [EFFECTS["passive_joint_friction"]()], n_holds, seed, mode="static", noise=0.0)
    robot, rows = machine.robot, np.arange(n_holds)
    units = np.array([unit == "m" for unit in robot.passive_units])
    motions = Motions(log.q, log.v, robot.forces(log.q), robot.passive_jacobian(log.q), units)
    true, test = log.effort - motions.force, rows % 4 == 3
    out = {"none": rms(true[test]), "Coulomb friction of each axis": rms((true - by_axis(true, log.v, test))[test])}
    jacobians = {f"J_p(q) of degree {degree}": fitted_jacobian(motions, degree) for degree in DEGREES}
    for name, own in {**jacobians, "J_p(q) itself": motions.passive}.items():
        x = np.stack([friction(own[:, joints], log.v) for joints in (units, ~units)], axis=-1)
        level = np.linalg.lstsq(x[~test].reshape(-1, 2), true[~test].ravel(), rcond=None)[0]
        out[name] = rms((true - x @ level)[test])
    return out


def tables(machine: Machine, network_rms_n: float, n_holds: int) -> str:
    """The page's tables."""
    motions = Motions.draw(machine)
    lines = ["| gap, um | error without a stage, N RMS | N at most | of the network's error |", "|---|---|---|---|"]
    for gap in GAPS_M:
        error = play_error(machine, motions, gap)
        part = rms(error) / network_rms_n
        lines.append(f"| {1e6 * gap:.0f} | {rms(error):.4f} | {np.abs(error).max():.3f} | {part:.2f} |")
    one_sided = 100.0 * np.mean(motions.force > 0)
    lines += ["", f"{one_sided:.1f} % of the efforts at rest press to the same side of their play.", "",
              "| left by | of 1 N in prismatic joints | of 1 Nm in turning joints | of the prototype | products |",
              "|---|---|---|---|---|"]  # fmt: skip
    prismatic, turning = (friction_left(motions, joints) for joints in (motions.is_prismatic, ~motions.is_prismatic))
    measured = prototype_left(machine, n_holds)
    for stage, (left, products) in prismatic.items():
        other, more = turning[stage]
        lines.append(f"| {stage} | {left:.3f} | {other:.3f} | {measured[stage]:.3f} | {max(products, more) or '-'} |")
    lines.append(f"| J_p(q) itself | 0 | 0 | {measured['J_p(q) itself']:.3f} | - |")
    return "\n".join(lines)
