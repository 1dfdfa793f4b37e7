"""A robot of another package: a planar arm of rotary joints, registered as kind "arm" by arm-1.0.dist-info beside it.

Joint i turns link i against link i - 1; at zero all links lie along x, gravity is along -y. tau_i is what joint i
must exert: the potential's derivative, g times the sum over links k >= i of m_k (x_k - p_i), x_k the centre of mass of
link k and p_i the place of joint i.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gravcomp.robot.protocol import Bounds

G_MPS2 = 9.81


@dataclass(frozen=True)
class Arm:
    """lengths_m, masses_kg (n,), centres of mass in the middle of the links; reach_rad (n,): the joints' range, +-."""

    lengths_m: np.ndarray
    masses_kg: np.ndarray
    reach_rad: np.ndarray

    @property
    def n_axes(self) -> int:
        return len(self.lengths_m)

    @property
    def position_units(self) -> tuple[str, ...]:
        return ("rad",) * self.n_axes

    def forces(self, q: np.ndarray) -> np.ndarray:
        along = self.lengths_m * np.cos(np.cumsum(q, axis=-1))
        joint = np.cumsum(along, axis=-1) - along
        centre = joint + along / 2
        lever = centre[..., None, :] - joint[..., :, None]  # [joint, link]
        return G_MPS2 * (np.triu(lever) @ self.masses_kg)

    def workspace(self, n_poses: int, seed: int) -> np.ndarray:
        return self.reach_rad * np.random.default_rng(seed).uniform(-1.0, 1.0, (n_poses, self.n_axes))

    @cached_property
    def bounds(self) -> Bounds:
        """Efforts: no lever is longer than the arm that hangs on its joint."""
        behind = np.cumsum(self.lengths_m[::-1])[::-1]
        most = G_MPS2 * np.cumsum((self.masses_kg * behind)[::-1])[::-1] + 1e-3
        return Bounds(-self.reach_rad, self.reach_rad, -self.reach_rad, self.reach_rad, -most, most)


def from_table(table: dict, where: str) -> Arm:
    """The arm of robot.toml: [model] lengths_m, masses_kg; [workspace] reach_rad."""
    model, workspace = table["model"], table["workspace"]
    return Arm(*(np.array(values) for values in (model["lengths_m"], model["masses_kg"], workspace["reach_rad"])))


def arm_toml(n_axes: int, counts_per_turn: str = "100000", inputs: Sequence[str] = ()) -> str:
    """robot.toml of an arm whose links get shorter and lighter; every axis has another drive. inputs: by axis, or all
    positions."""
    axes = [
        f"[[axis]]\ncounts_per_turn = {counts_per_turn}\neffort_per_ampere = {40.0 / (k + 1)}\n" for k in range(n_axes)
    ]
    axes = [axis + f'input = "{kind}"\n' for axis, kind in zip(axes, inputs, strict=True)] if inputs else axes
    lengths, masses, reach = ([value * 0.7**k for k in range(n_axes)] for value in (0.4, 3.0, 1.5))
    return (
        f'name = "arm"\nclock_hz = 40e6\n\n[network]\nactivation = "gamma"\n\n[model]\nkind = "arm"\n'
        f"lengths_m = {lengths}\nmasses_kg = {masses}\n\n[workspace]\nreach_rad = {reach}\n\n" + "\n".join(axes)
    )
