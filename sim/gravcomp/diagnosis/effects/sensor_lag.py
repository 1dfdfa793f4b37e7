"""Effort or velocity are logged late: a filter in the drive, a bus, a clock of its own."""

from dataclasses import replace

import numpy as np

from gravcomp.diagnosis.candidate import Parameter, axes_in
from gravcomp.diagnosis.effects.base import Effect
from gravcomp.diagnosis.thresholds import (
    LAG_AGREE,
    LAG_GRID,
    LAG_LEVELS,
    LAG_MATTERS,
    LAG_OF_V,
    LAG_REVERSAL,
    LAG_REVERSALS,
    LAG_ROWS,
    LAG_SETTLED,
    LAG_STEPS,
    LAG_SURE,
    LAG_TURNS,
    MAD_TO_SIGMA,
    SURELY_LESS,
    TINY,
)
from gravcomp.logs.clock import derivative, usual_step
from gravcomp.logs.measurement import Measurement, velocity_from_position


class SensorLag(Effect):
    """f_exp(t) = f(t - tau): to first order -tau df/dt, on all axes alike; v_i(t) = dq_i/dt(t - tau_v_i)."""

    name = "sensor_lag"
    driver = "f"
    equation = "f(t - tau) - f(t), f the true effort; v_i(t) = dq_i/dt at t - tau_v_i"
    hardware = "none"
    sensor = "the filter of the effort, which comes late"
    units = {"tau": "s", "tau_v": "s"}  # noqa: RUF012
    is_certain = False  # play and presliding are late, too

    def unavailable(self, data):
        return "" if data.has_velocity and data.is_motion.mean() > 0.8 else "no motion along time"

    def shapes(self, data):
        return []

    def columns(self, data, shape):
        return {}

    def seen_in(self, data):
        """From the smooth parts of a motion, where the model's effort changes and friction does not; where no model
        tells, as on a vertical axis, from the jumps of friction at reversals.
        """
        if self.unavailable(data) or len(data.t_s) < LAG_ROWS:
            return {}
        if not (np.ptp(data.nominal, axis=0) > 0.0).any():
            return _lag_of_jumps(data)
        found = _lags(data)
        found = [(lag, error) for lag, error, part in found if abs(part) >= LAG_MATTERS]
        if not found:
            return {}
        lag, error = np.array(found).T
        common, own = _mean(lag, error)
        agree = np.abs(lag - common) < np.maximum(LAG_AGREE[0] * error, LAG_AGREE[1] * abs(common))
        if common < LAG_SURE * own or not agree.all():
            return {}
        for _ in range(LAG_TURNS):  # the effort is that of tau before, which tau df/dt is for a short one only
            rest = np.array([(lag, error) for lag, error, _ in _lags(_delayed(data, common))])
            if not len(rest):  # so late that too little of the motion is left to tell
                return {}
            more, own = _mean(*rest.T)
            common = max(common + more, 0.0)
            if abs(more) < own:
                break
        return {Parameter("tau_s"): (common, 1.96 * own)}

    def corrected(self, data, parameters):
        """v of tau_v later; the effort beside the pose of tau before: where a reversal has not settled the direction is
        not sure.
        """
        data, tau = _hastened(data, parameters), parameters.get("tau_s", 0.0)
        if not tau:
            return data
        late = _delayed(data, tau)
        if late.v is None:
            return late
        started = data.t_s[np.flatnonzero(data.is_first)][np.cumsum(data.is_first) - 1]
        before = (data.t_s - started < tau)[:, None]  # what came before the log is in no row
        wide = int(np.ceil(LAG_SETTLED * tau / usual_step(data.t_s, data.runs)))
        return replace(late, unsure=_near_reversal(late, wide) | before)


class VelocityLag(SensorLag):
    """v_i(t) = dq_i/dt(t - tau_v_i), seen where both are in the log."""

    sensor = "the filter of the velocity, which comes late"
    is_certain = True  # of a position and a velocity in one log

    def seen_in(self, data):
        """Least squares of v beside dq/dt at t - tau and its derivative, for both."""
        if data.v is None or not data.is_ordered or len(data.t_s) < LAG_ROWS:
            return {}
        slope = velocity_from_position(data.t_s, data.q, data.runs)
        step = usual_step(data.t_s, data.runs)
        found = {i: _lag_of_velocity(data, i, slope[:, i]) for i in np.flatnonzero(~np.array(data.is_held))}
        return {
            Parameter("tau_v", int(i)): (lag, 1.96 * error)
            for i, (lag, error, part) in found.items()
            if lag > max(LAG_STEPS * step, LAG_SURE * error) and part > LAG_OF_V
        }


def _lag_of_velocity(data: Measurement, i: int, slope: np.ndarray) -> tuple[float, float, float]:
    """Lag of v of one axis behind dq/dt, its standard error, and how much of v it makes."""
    t, v, lag, first = data.t_s, data.v[:, i], 0.0, data.runs == data.runs[0]
    t, v, slope = t[first], v[first], slope[first]
    turn = derivative(slope[:, None], t, np.zeros(len(t)), 0, lambda values, window: values)[:, 0]  # stamps repeat
    for _ in range(LAG_TURNS):
        x = np.column_stack([np.interp(t - lag, t, slope), -np.interp(t - lag, t, turn)])
        inverse = np.linalg.pinv(x.T @ x, rcond=1e-12)
        size, more = inverse @ (x.T @ v)
        if size <= 0.0:
            return 0.0, np.inf, 0.0
        lag = float(np.clip(lag + more / size, 0.0, 0.1 * np.ptp(t)))
    left = v - x @ [size, more]
    if left.std() > 0.3 * v.std():  # no copy of dq/dt, however late
        return 0.0, np.inf, 0.0
    error = float(np.sqrt(inverse[1, 1]) * left.std() / size)
    return lag, error, float(lag * turn.std() / max(slope.std(), TINY))


def _hastened(data: Measurement, parameters) -> Measurement:
    late = axes_in(parameters, "tau_v")
    if not late or data.v is None:
        return data
    v = data.v.copy()
    for i in late:
        for rows in (np.flatnonzero(data.runs == run) for run in np.unique(data.runs)):
            t = data.t_s[rows]
            v[rows, i] = np.interp(t + parameters[Parameter("tau_v", i)], t, v[rows, i])
    return replace(data, v=v)


def _delayed(data: Measurement, tau_s: float) -> Measurement:
    """The log with position, speed and prediction of tau before beside each effort."""
    q, v, nominal = (None if x is None else x.copy() for x in (data.q, data.v, data.nominal))
    for rows in (np.flatnonzero(data.runs == run) for run in np.unique(data.runs)):
        for x in (x for x in (q, v, nominal) if x is not None):
            x[rows] = _at(data.t_s[rows] - tau_s, data.t_s[rows], x[rows])
    return replace(data, q=q, v=v, nominal=nominal)


def _at(when: np.ndarray, t_s: np.ndarray, x: np.ndarray) -> np.ndarray:
    return np.column_stack([np.interp(when, t_s, column) for column in x.T])


def _near_reversal(data: Measurement, wide: int) -> np.ndarray:
    """Rows (n, k) at most ``wide`` rows from a change of direction of the axis."""
    turns = np.abs(np.diff(np.sign(data.v), axis=0, prepend=np.sign(data.v[:1]))) > 0
    window = np.ones(2 * wide + 1)
    return np.column_stack([np.convolve(turn, window, mode="same") > 0 for turn in turns.T])


def _lag_of_jumps(data: Measurement) -> dict[Parameter, tuple[float, float]]:
    """The lag at which sign(v), beside what is smooth, leaves least of the effort; all axes alike."""
    t, first = data.t_s, data.runs == data.runs[0]
    turns = np.abs(np.diff(np.sign(data.v[first]), axis=0)).astype(bool).sum(axis=0)
    own = np.flatnonzero(turns >= LAG_REVERSALS)
    if not len(own):
        return {}
    t, v, r = t[first], data.v[first], (data.force - data.nominal)[first]
    smooth = [np.linalg.qr(np.column_stack([np.ones(len(t)), v[:, i], data.q[first, i]]))[0] for i in own]
    left = [r[:, i] - q @ (q.T @ r[:, i]) for i, q in zip(own, smooth, strict=True)]

    def unlikely(lag: float) -> float:
        """Twice the negative log likelihood, but for a constant."""
        total = 0.0
        for i, q, y in zip(own, smooth, left, strict=True):
            jump = np.sign(np.interp(t - lag, t, v[:, i]))
            jump -= q @ (q.T @ jump)
            total += len(t) * np.log(max(y @ y - (jump @ y) ** 2 / max(jump @ jump, TINY), TINY))
        return total

    most = float(np.ptp(t) / turns.max() / 4.0)
    lags = np.linspace(0.0, most, LAG_GRID)
    for _ in range(LAG_LEVELS):
        scores = np.array([unlikely(lag) for lag in lags])
        best, near = lags[scores.argmin()], 2.0 * (lags[1] - lags[0])
        lags = np.linspace(max(best - near, 0.0), min(best + near, most), LAG_GRID)
    if best <= LAG_STEPS * usual_step(data.t_s, data.runs) or unlikely(0.0) - scores.min() < SURELY_LESS:
        return {}
    return {Parameter("tau_s"): (float(best), usual_step(data.t_s, data.runs) / 2.0)}


def _mean(lag: np.ndarray, error: np.ndarray) -> tuple[float, float]:
    """Weighted by their errors, and its own."""
    weight = 1.0 / error**2
    return float(np.sum(weight * lag) / np.sum(weight)), float(1.0 / np.sqrt(np.sum(weight)))


def _lags(data: Measurement) -> list[tuple[float, float, float]]:
    """What ``_lag_of_axis`` tells of the axes whose model changes along time."""
    slope = derivative(data.nominal, data.t_s, data.runs, 0, lambda values, window: values)
    found = [_lag_of_axis(data, i, slope[:, i]) for i in range(data.n_axes) if np.ptp(slope[:, i]) > 0.0]
    return [own for own in found if own is not None]


def _lag_of_axis(data: Measurement, i: int, slope: np.ndarray) -> tuple[float, float, float] | None:
    """Lag of one axis, its standard error, and what it makes in parts of what is left, beside all that a smooth effect
    could do; None where too few samples are left.
    """
    use = ~_near_reversal(data, LAG_REVERSAL)[:, i] & ~data.is_undecided[:, i] & data.is_motion
    if use.sum() < LAG_ROWS:
        return None
    direction, v, f = data.direction[:, i], data.v[:, i], data.nominal[:, i]
    beside = [np.ones(len(v)), direction, v, np.abs(f) * direction, data.q[:, i], f, data.acceleration[:, i]]
    if data.sensitivity is not None:
        beside += [*(data.sensitivity[:, i, :] * data.direction).T, *data.sensitivity[:, i, :].T]
    x = np.column_stack([-slope, *beside])[use]
    y = (data.force - data.nominal)[use, i]
    x = x / np.maximum(np.linalg.norm(x, axis=0), TINY) * np.sqrt(len(y))
    for _ in range(2):  # once more without gross errors
        theta = np.linalg.lstsq(x, y, rcond=1e-8)[0]
        left = y - x @ theta
        keep = np.abs(left) <= 5.0 * MAD_TO_SIGMA * np.median(np.abs(left)) + TINY
        x, y, left = x[keep], y[keep], left[keep]
    inverse = np.linalg.pinv(x.T @ x, rcond=1e-10)
    lagged = left[1:] @ left[:-1] / max(left @ left, TINY)
    widened = (1 + max(lagged, 0.0)) / (1 - min(max(lagged, 0.0), 0.95))
    unit = np.sqrt(np.mean(slope[use] ** 2))
    error = np.sqrt(inverse[0, 0] * np.mean(left**2) * widened)
    return theta[0] / unit, error / unit, theta[0] / max(left.std(), TINY)
