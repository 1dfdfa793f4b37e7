"""Measured data in memory, and what is derived from it: direction, acceleration, which rows are motion."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.signal import savgol_filter

from gravcomp.logs import thresholds as given
from gravcomp.logs.clock import derivative
from gravcomp.logs.places import Places, places
from gravcomp.robot.protocol import HasBodies, Robot


@dataclass(frozen=True)
class Measurement:
    """n samples of k axes.

    t_s (n,); q (n, k), m or rad; v (n, k) signed velocity (of a hold: of its approach) or None; force (n, k) and
    nominal (n, k) measured and modelled effort in ``unit``; temp_c (n,) or None; position_units one per axis;
    force_at: f_model as a function of q (n, k) -> (n, k), or None when only its values at the samples are known;
    robot: what the model is of, or None where its values alone are known; run (n,): which run a row belongs to, where
    runs were joined; unsure (n, k): samples at which the direction is not sure for another reason than v;
    slow (n, k): samples at which the direction of what is no axis is not told, or where it came from; units: of
    effort per axis, where they differ; notes: what reading the log had to put right, a line each; n_dropped: rows
    without a value, or with a mark for one, that are not here; is_predicted: nominal is the log's own, not robot's.
    """

    name: str
    t_s: np.ndarray
    q: np.ndarray
    v: np.ndarray | None
    force: np.ndarray
    nominal: np.ndarray
    unit: str
    position_units: tuple[str, ...]
    temp_c: np.ndarray | None = None
    force_at: Callable[[np.ndarray], np.ndarray] | None = field(default=None, repr=False)
    robot: Robot | None = field(default=None, repr=False)
    run: np.ndarray | None = field(default=None, repr=False)
    unsure: np.ndarray | None = field(default=None, repr=False)
    slow: np.ndarray | None = field(default=None, repr=False)
    units: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    n_dropped: int = 0
    is_predicted: bool = False

    @property
    def shape(self) -> tuple[int, int]:
        return self.q.shape

    @property
    def n_axes(self) -> int:
        return self.q.shape[1]

    @property
    def effort_units(self) -> tuple[str, ...]:
        return self.units or (self.unit,) * self.n_axes

    @property
    def runs(self) -> np.ndarray:
        """Number of the run of each row, (n,)."""
        return np.zeros(len(self.t_s), int) if self.run is None else self.run

    @cached_property
    def is_first(self) -> np.ndarray:
        """Rows that begin a run, (n,)."""
        return np.diff(self.runs, prepend=-1) != 0

    @property
    def has_velocity(self) -> bool:
        return self.v is not None

    @cached_property
    def direction(self) -> np.ndarray:
        """sign(v), 0 within the noise of v, (n, k)."""
        return np.where(np.abs(self.v) > self.dead_band, np.sign(self.v), 0.0)

    @cached_property
    def is_reversing(self) -> np.ndarray:
        """Entries (n, k) whose direction v doesn't tell: at a reversal friction may hold any force up to its level.

        None on an axis that stands still for long: there the model's sign(0) = 0 stands.
        """
        if self.v is None:
            return np.zeros(self.shape, bool)
        still = self.direction == 0.0
        still &= still.mean(axis=0) < given.STANDS_STILL
        return still if self.slow is None else still | self.slow

    @property
    def is_undecided(self) -> np.ndarray:
        """Entries (n, k) whose direction is not sure, at a reversal or for another reason: no fit counts them."""
        return self.is_reversing if self.unsure is None else self.is_reversing | self.unsure

    @cached_property
    def dead_band(self) -> np.ndarray:
        """Speed below which the direction is not sure, (n, k): DEAD_BAND_GRID steps of the grid that v was read on; in
        motion also DEAD_BAND_NOISE times the noise of v, at most DEAD_BAND_CAP of the usual speed.
        """
        moving = self.is_motion
        band = np.zeros(self.shape)
        for rows in (moving, ~moving):
            band[rows] = [given.DEAD_BAND_GRID * _grid_step(v) for v in self.v[rows].T]
        if np.count_nonzero(moving) < given.DEAD_BAND_ROWS:
            return band
        v = self.v[moving]
        noise = np.median(np.abs(np.diff(v, 4, axis=0)), axis=0) / given.MAD / np.sqrt(given.FOURTH_DIFFERENCE)
        cap = given.DEAD_BAND_CAP * np.quantile(np.abs(v), given.USUAL_TOP, axis=0)
        return np.maximum(band, np.minimum(given.DEAD_BAND_NOISE * noise, cap) * moving[:, None])

    @cached_property
    def is_motion(self) -> np.ndarray:
        """Rows that belong to one continuous motion: q advances as v says, (n,)."""
        nothing = np.zeros(len(self.t_s), bool)
        if self.v is None or len(self.t_s) < given.MOTION_ROWS:
            return nothing
        scale = self._scale  # axes in metres and in radians count alike
        step = np.diff(self.q, axis=0) / scale
        told = 0.5 * (self.v[1:] + self.v[:-1]) * np.diff(self.t_s)[:, None] / scale
        size = np.abs(told).sum(axis=1)
        rounding = given.MOTION_ROUNDING * (np.ptp(self.q, axis=0) > 0).any()
        keeps = np.abs(step - told).sum(axis=1) <= given.MOTION_TOLERANCE * size + rounding
        around = np.ones(given.MOTION_AROUND)
        near = np.convolve(keeps, around, "same") > given.MOTION_MOST * np.convolve(np.ones(len(keeps)), around, "same")
        return np.append(near, near[-1]) if near.mean() > given.MOTION_LEAST else nothing

    @cached_property
    def begins_motion(self) -> np.ndarray:
        """Rows in motion (n,) that follow from none before: the first of a run, or of a motion behind holds. Where the
        machine came from is not told there.
        """
        return self.is_motion & (self.is_first | ~np.append(False, self.is_motion[:-1]))

    @cached_property
    def is_ordered(self) -> bool:
        """Neighbours in time are neighbours in pose."""
        if len(self.t_s) < given.MOTION_ROWS:
            return False
        inside = ~self.is_first[1:]
        q = self.q / self._scale
        step = np.diff(q, axis=0)[inside].var(axis=0).sum() / max(2.0 * q.var(axis=0).sum(), np.finfo(float).tiny)
        return bool(step < given.ORDERED)

    @cached_property
    def places(self) -> tuple[Places | None, ...]:
        """Places at which each axis was held; None where its positions gather nowhere."""
        reach = np.ptp(self.q, axis=0)
        others = [max((reach[j] for j in range(self.n_axes) if self._alike(i, j)), default=0.0)
                  for i in range(self.n_axes)]  # fmt: skip
        return tuple(places(self.q[:, i], others[i]) for i in range(self.n_axes))

    def _alike(self, i: int, j: int) -> bool:
        return not self.position_units or self.position_units[i] == self.position_units[j]

    @cached_property
    def poses(self) -> np.ndarray:
        """Positions (n, k), each at its place where it has one: rows of one pose are equal."""
        return np.column_stack([q if own is None else own.centre for q, own in zip(self.q.T, self.places, strict=True)])

    @property
    def is_held(self) -> tuple[bool, ...]:
        """Axes that were held at places, several rows at each: their v is that of an approach."""
        return tuple(own is not None and own.count < given.HELD * len(self.t_s) for own in self.places)

    @cached_property
    def axis_as_time(self) -> int | None:
        """The axis (from 0) whose places were visited one after the other, once in each direction: time cannot be told
        from it. None where there is no such axis.
        """
        t = self.t_s - self.t_s.mean()
        for i in np.flatnonzero(self.is_held):
            way = np.zeros(len(t)) if self.v is None else np.sign(self.v[:, i])
            of = np.unique(np.column_stack([self.places[i].centre, way]), axis=0, return_inverse=True)[1].ravel()
            sums = np.bincount(of, t)
            if np.sum(sums**2 / np.bincount(of)) > given.AS_TIME * (t @ t):
                return int(i)
        return None

    @property
    def spacing(self) -> np.ndarray:
        """Distance of neighbouring places, (k,): a ripple that is not much longer can't be seen; 0 without places."""
        return np.array([0.0 if own is None else own.spacing for own in self.places])

    @property
    def scaled_positions(self) -> np.ndarray:
        """Positions (n, k) in parts of the range."""
        return self.q / self._scale

    @property
    def _scale(self) -> np.ndarray:
        """Range of each axis; 1 where it stands."""
        reach = np.ptp(self.q, axis=0)
        if len(set(self.position_units)) < 2:
            reach = np.full(self.n_axes, reach.max())
        return np.where(reach > 0.0, reach, 1.0)

    @cached_property
    def acceleration(self) -> np.ndarray | None:
        """Derivative of v along t, (n, k), zero outside motion; None without motion."""
        if self.v is None or not self.is_motion.any():
            return None
        return derivative(self.v, self.t_s, self.runs, _window(len(self.t_s)), _smoothed) * self.is_motion[:, None]

    @cached_property
    def modelled(self) -> np.ndarray:
        """The model as a function, at the positions of the log, (n, k)."""
        return self.force_at(self.q)

    @cached_property
    def sensitivity(self) -> np.ndarray | None:
        """dF_i/dq_j of the model by central differences, (n, k, k); None without force_at."""
        if self.force_at is None:
            return None
        step = given.CENTRAL_STEP * (np.ptp(self.q, axis=0).max() or 1.0)
        columns = [
            (self.force_at(self.q + step * unit) - self.force_at(self.q - step * unit)) / (2 * step)
            for unit in np.eye(self.n_axes)
        ]
        return np.stack(columns, axis=-1)

    def once(self, function: Callable[["Measurement"], np.ndarray]) -> np.ndarray:
        """What a function of this log gives, computed at its first call: what a robot tells of every row is dear."""
        if function not in self._known:
            self._known[function] = function(self)
        return self._known[function]

    @cached_property
    def _known(self) -> dict:
        return {}

    @cached_property
    def body_moments(self) -> np.ndarray | None:
        """Efforts per kg m of first moment on each body of the robot, (n, k, b, 3); None where they are not known."""
        return self.robot.moment_regressors(self.q) if isinstance(self.robot, HasBodies) else None


def _grid_step(v: np.ndarray) -> float:
    """Step of the grid that the values (n,) lie on, as encoder counts over a fixed time do; 0 if they lie on none."""
    values = np.unique(np.abs(v))
    if not given.FEWEST_ON_GRID <= len(values) <= given.GRID_SHARE * len(v):
        return 0.0
    step = np.diff(values).min()
    return float(step) if np.all(np.abs(values / step - np.round(values / step)) < given.OFF_GRID) else 0.0


def velocity_from_position(t_s: np.ndarray, q: np.ndarray, run: np.ndarray) -> np.ndarray:
    """Velocity of a slow motion from its positions: quadratic Savitzky-Golay smoothing, then central differences."""
    return derivative(q, t_s, run, _window(len(t_s)), _smoothed)


def _window(n: int) -> int:
    return int(np.clip(n // given.SMOOTH_PART, given.SMOOTH_FEWEST, given.SMOOTH_MOST)) * 2 + 1


def _smoothed(values: np.ndarray, window: int) -> np.ndarray:
    return savgol_filter(values, window, 2, axis=0)
