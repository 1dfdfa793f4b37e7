"""Terms that do not hold where they were not fitted are withdrawn: cross-validation within the training."""

import numpy as np

from gravcomp.diagnosis.candidate import Term
from gravcomp.diagnosis.samples.split import folds
from gravcomp.diagnosis.search.gram import pseudo_inverse
from gravcomp.diagnosis.thresholds import TINY
from gravcomp.logs.measurement import Measurement


def confirmed(
    data: Measurement, residual: np.ndarray, rows: np.ndarray, blocks: np.ndarray, effects: list[Term],
    corrections: list[Term], noise: np.ndarray, left_out: np.ndarray,
) -> tuple[list[Term], list[Term]]:  # fmt: skip
    """The effects and corrections without which blocks that were not fitted are predicted worse.

    residual (n, k); rows: of the training; left_out (rows, k). The weakest goes first, while that predicts better;
    effects among themselves, as corrections may imitate any of them, then corrections beside the effects that stay.
    """
    terms = [*effects, *corrections]
    if not terms or not (parts := [test for _, test in folds(blocks[rows])]):
        return effects, corrections
    weight = (~data.is_undecided[rows] & ~left_out) / np.maximum(noise, TINY)
    sizes = [len(term.labels) for term in terms]
    x = np.concatenate([term.columns(data)[rows] for term in terms], axis=-1) * weight[..., None]
    y = residual[rows] * weight
    x = x / np.maximum(np.sqrt(np.mean(x**2, axis=(0, 1))), TINY)
    place = np.split(np.arange(x.shape[-1]), np.cumsum(sizes)[:-1])
    grams = [np.einsum("nka,nkb->ab", x[test], x[test]) for test in parts]
    crosses = [np.einsum("nka,nk->a", x[test], y[test]) for test in parts]

    def error(members) -> float:
        """Sum of squares where it was not fitted, less a constant."""
        if not members:
            return 0.0
        index, total = np.concatenate([place[k] for k in members]), 0.0
        for gram, cross in zip(grams, crosses, strict=True):
            inverse, _ = pseudo_inverse((sum(grams) - gram)[np.ix_(index, index)])
            theta = inverse @ (sum(crosses) - cross)[index]
            total += theta @ gram[np.ix_(index, index)] @ theta - 2.0 * theta @ cross[index]
        return float(total)

    named = _upheld(error, range(len(effects)), ())
    plain = _upheld(error, range(len(effects), len(terms)), named)
    return [terms[k] for k in named], [terms[k] for k in plain]


def _upheld(error, candidates, beside) -> list[int]:
    """The candidates without which the error grows, beside those that stay anyway."""
    kept = list(candidates)
    while kept:
        without = {k: error([*beside, *(j for j in kept if j != k)]) for k in kept}
        worst = min(without, key=without.get)
        if without[worst] > error([*beside, *kept]):
            break
        kept.remove(worst)
    return kept
