"""Gram matrices of all regressors on one residual: any set of them is solved without touching a sample again."""

from itertools import pairwise

import numpy as np

from gravcomp.diagnosis.candidate import Regressor
from gravcomp.diagnosis.thresholds import SINGULAR, TINY


class Gram:
    """regressors; residual, weight (m, k); variance (k,) of the noise; independent (k,) number of independent samples.

    ``place`` holds, per regressor, the indices of its columns; an index array stands for a set of columns below. A
    correction has columns on one axis only, so an axis keeps the matrix of its own columns.
    """

    def __init__(self, regressors: list[Regressor], residual, weight, variance, independent):
        self.independent, self.variance = independent, variance
        sizes = [len(regressor.term.labels) for regressor in regressors]
        starts = np.concatenate([[0], np.cumsum(sizes)]).astype(int)
        self.place = [np.arange(a, b) for a, b in pairwise(starts)]
        self.n_columns, n_axes = int(starts[-1]), residual.shape[1]
        self.cross = np.zeros((n_axes, self.n_columns))
        self.energy = np.zeros(n_axes)
        self._own, self.matrices, self._blocks = [], [], {}
        self.local = np.full((n_axes, self.n_columns), -1)  # place of a column in the matrix of an axis
        scale = np.zeros(self.n_columns)
        for i in range(n_axes):
            here = [k for k, regressor in enumerate(regressors) if regressor.by_axis[i] is not None]
            w = weight[:, i] * (independent[i] / max(weight[:, i].sum(), TINY))
            self.energy[i] = w @ residual[:, i] ** 2
            index = np.concatenate([np.zeros(0, int), *(self.place[k] for k in here)])
            x = np.hstack([np.zeros((len(residual), 0)), *(regressors[k].by_axis[i] for k in here)])
            xw = x * w[:, None]
            self._own.append(index)
            self.matrices.append(xw.T @ x)
            self.local[i, index] = np.arange(len(index))
            self.cross[i, index] = xw.T @ residual[:, i]
            scale[index] += np.diag(self.matrices[i]) / variance[i]
        self.scale = np.zeros(self.n_columns)
        np.divide(1.0, np.sqrt(scale), out=self.scale, where=scale > 0.0)
        self.normed_cross = np.einsum("ia,i->a", self.cross, 1.0 / variance) * self.scale

    def of(self, index: np.ndarray) -> "Subset":
        return Subset(self, index)

    def gains(self, inside: np.ndarray, candidates: list[np.ndarray]) -> list[tuple[float, int]]:
        """What each candidate would take off the normed residual beside the columns inside, and by how many
        coefficients: Schur complements, one inverse for all of them.
        """
        inverse, _ = pseudo_inverse(self.of(inside).normed())
        rows = self._normed_rows(inside)
        away = inverse @ rows
        left = self.normed_cross - away.T @ self.normed_cross[inside]
        out = [(0.0, 0)] * len(candidates)
        for size in {len(own) for own in candidates}:
            which = [a for a, own in enumerate(candidates) if len(own) == size]
            columns = np.array([candidates[a] for a in which])
            schur = np.array([self._block(own) for own in columns])
            schur -= rows[:, columns].transpose(1, 2, 0) @ away[:, columns].transpose(1, 0, 2)
            values, vectors = np.linalg.eigh(schur)
            keep = values > SINGULAR * np.maximum(values[:, -1:], 1.0)
            along = np.einsum("npa,np->na", vectors, left[columns])
            gain = np.sum(np.where(keep, along**2 / np.where(keep, values, 1.0), 0.0), axis=1)
            for a, own_gain, rank in zip(which, gain, keep.sum(axis=1), strict=True):
                out[a] = float(own_gain), int(rank)
        return out

    def _normed_rows(self, index: np.ndarray) -> np.ndarray:
        """Rows of that matrix of all columns."""
        out = np.zeros((len(index), self.n_columns))
        for local, own, gram, variance in zip(
            self.local[:, index], self._own, self.matrices, self.variance, strict=True
        ):
            at = np.flatnonzero(local >= 0)
            out[np.ix_(at, own)] += gram[local[at]] / variance
        return out * self.scale[index][:, None] * self.scale

    def _block(self, index: np.ndarray) -> np.ndarray:
        key = index.tobytes()
        if key not in self._blocks:
            self._blocks[key] = self.of(index).normed()
        return self._blocks[key]


class Subset:
    """A set of columns: their matrices are taken out of the Gram matrices once."""

    def __init__(self, gram: Gram, index: np.ndarray):
        self.gram, self.index, self._by_axis = gram, index, []  # per axis: which have a part there, their matrix
        for local, matrix in zip(gram.local[:, index], gram.matrices, strict=True):
            at = np.flatnonzero(local >= 0)
            self._by_axis.append((at, matrix[local[at][:, None], local[at]]))

    def normed(self) -> np.ndarray:
        """Matrix over all axes, each axis in units of its noise and each column of size one."""
        s = self.gram.scale[self.index]
        return self._sum(1.0 / self.gram.variance) * s[:, None] * s

    def solve(self) -> tuple[np.ndarray, np.ndarray, int]:
        """Coefficients of the columns, their covariance and the rank."""
        s = self.gram.scale[self.index]
        inverse, rank = pseudo_inverse(self.normed())
        return inverse @ self.gram.normed_cross[self.index] * s, inverse * s[:, None] * s, rank

    def left(self, theta: np.ndarray) -> np.ndarray:
        """Residual sum of squares per axis with coefficients theta."""
        fitted = np.array([theta[at] @ matrix @ theta[at] for at, matrix in self._by_axis])
        return self.gram.energy - 2.0 * self.gram.cross[:, self.index] @ theta + fitted

    def energies(self, theta: np.ndarray, ends: np.ndarray) -> tuple[float, float]:
        """Energy over all axes of the whole, and the sum over the energies of its parts, which begin at ``ends``."""
        matrix = self._sum(np.ones(len(self._by_axis)))
        each = theta[:, None] * matrix * theta
        parts = np.add.reduceat(np.add.reduceat(each, ends, axis=0), ends, axis=1)
        return float(each.sum()), float(np.trace(parts))

    def _sum(self, factors: np.ndarray) -> np.ndarray:
        out = np.zeros((len(self.index), len(self.index)))
        for (at, matrix), factor in zip(self._by_axis, factors, strict=True):
            out[at[:, None], at] += factor * matrix
        return out


def pseudo_inverse(gram: np.ndarray) -> tuple[np.ndarray, int]:
    """Inverse within the span of the well-determined directions, and their number."""
    if not gram.size:
        return gram, 0
    values, vectors = np.linalg.eigh(gram)
    keep = values > SINGULAR * max(values[-1], 1.0)
    return (vectors[:, keep] / values[keep]) @ vectors[:, keep].T, int(keep.sum())
