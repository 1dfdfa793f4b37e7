"""Gram matrices of all regressors on one residual: any set of them is solved without touching a sample again."""

from itertools import pairwise

import numpy as np

from gravcomp.diagnosis.candidate import Regressor
from gravcomp.diagnosis.thresholds import SINGULAR, TINY


class Gram:
    """regressors; residual, weight (m, k); variance (k,) of the noise; independent (k,) number of independent samples.

    ``place`` holds, per regressor, the indices of its columns; an index array stands for a set of columns below.
    """

    def __init__(self, regressors: list[Regressor], residual, weight, variance, independent):
        self.independent, self.variance = independent, variance
        sizes = [len(regressor.term.labels) for regressor in regressors]
        starts = np.concatenate([[0], np.cumsum(sizes)]).astype(int)
        self.place = [np.arange(a, b) for a, b in pairwise(starts)]
        n_columns, n_axes = starts[-1], residual.shape[1]
        self.gram = np.zeros((n_axes, n_columns, n_columns))
        self.cross = np.zeros((n_axes, n_columns))
        self.energy = np.zeros(n_axes)
        scale = np.zeros(n_columns)
        for i in range(n_axes):
            here = [k for k, regressor in enumerate(regressors) if regressor.by_axis[i] is not None]
            w = weight[:, i] * (independent[i] / max(weight[:, i].sum(), TINY))
            self.energy[i] = w @ residual[:, i] ** 2
            if not here:
                continue
            index = np.concatenate([self.place[k] for k in here])
            x = np.hstack([regressors[k].by_axis[i] for k in here])
            xw = x * w[:, None]
            self.gram[i][np.ix_(index, index)] = xw.T @ x
            self.cross[i][index] = xw.T @ residual[:, i]
            scale[index] += np.einsum("nk,nk->k", xw, x) / variance[i]
        self.scale = np.zeros(n_columns)
        np.divide(1.0, np.sqrt(scale), out=self.scale, where=scale > 0.0)
        self.normed_gram = np.einsum("iab,i->ab", self.gram, 1.0 / variance) * self.scale[:, None] * self.scale
        self.normed_cross = np.einsum("ia,i->a", self.cross, 1.0 / variance) * self.scale

    def solve(self, index: np.ndarray) -> tuple[np.ndarray, np.ndarray, int]:
        """Coefficients of the columns, their covariance and the rank."""
        s = self.scale[index]
        inverse, rank = pseudo_inverse(self.normed_gram[np.ix_(index, index)])
        return inverse @ self.normed_cross[index] * s, inverse * s[:, None] * s, rank

    def fitted(self, index: np.ndarray, theta: np.ndarray) -> np.ndarray:
        """Energy of these columns with coefficients theta, per axis."""
        return np.einsum("iab,a,b->i", self.gram[:, index[:, None], index], theta, theta)

    def left(self, index: np.ndarray) -> np.ndarray:
        """Residual sum of squares per axis once these columns are fitted."""
        if not len(index):
            return self.energy
        theta, _, _ = self.solve(index)
        return self.energy - 2.0 * self.cross[:, index] @ theta + self.fitted(index, theta)

    def gains(self, inside: np.ndarray, candidates: list[np.ndarray]) -> list[tuple[float, int]]:
        """What each candidate would take off the normed residual beside the columns inside, and by how many
        coefficients: Schur complements, one inverse for all of them.
        """
        inverse, _ = pseudo_inverse(self.normed_gram[np.ix_(inside, inside)])
        away = inverse @ self.normed_gram[inside]
        left = self.normed_cross - away.T @ self.normed_cross[inside]
        out = []
        for own in candidates:
            schur = self.normed_gram[np.ix_(own, own)] - self.normed_gram[np.ix_(own, inside)] @ away[:, own]
            inverse, rank = pseudo_inverse(schur)
            out.append((float(left[own] @ inverse @ left[own]), rank))
        return out


def pseudo_inverse(gram: np.ndarray) -> tuple[np.ndarray, int]:
    """Inverse within the span of the well-determined directions, and their number."""
    if not gram.size:
        return gram, 0
    values, vectors = np.linalg.eigh(gram)
    keep = values > SINGULAR * max(values[-1], 1.0)
    return (vectors[:, keep] / values[keep]) @ vectors[:, keep].T, int(keep.sum())
