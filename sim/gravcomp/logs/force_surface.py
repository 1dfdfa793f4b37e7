"""f_model as a function of position, recovered from its values at the samples."""

import numpy as np
from sklearn.preprocessing import PolynomialFeatures

_DEGREES = {1: 7, 2: 5, 3: 4}
_TOLERANCE = 1e-3  # of the model's own variation
_FIT_SAMPLES = 4000


def fit_force_function(q: np.ndarray, nominal: np.ndarray, position_units: list[str]):
    """Polynomial f(q), in sin q and cos q for rotary axes; q, nominal (n, k).

    Returns a function (n, k) -> (n, k), or None when the predictions do not follow from the positions alone (a model
    with inertia or friction in it) or there are too many axes.
    """
    n, k = q.shape
    if k not in _DEGREES or nominal.std() == 0.0:
        return None
    centre, scale = q.mean(axis=0), np.maximum(q.std(axis=0), 1e-12)
    rotary = np.array([unit == "rad" for unit in position_units])
    degree = 3 if rotary.any() else _DEGREES[k]
    expand = PolynomialFeatures(degree)

    def features(at: np.ndarray) -> np.ndarray:
        linear = ((at - centre) / scale)[:, ~rotary]
        return expand.fit_transform(np.hstack([linear, np.sin(at[:, rotary]), np.cos(at[:, rotary])]))

    rows = np.linspace(0, n - 1, min(n, _FIT_SAMPLES)).astype(int)
    basis = features(q[rows])
    if len(rows) < 3 * basis.shape[1]:
        return None
    weights = np.linalg.lstsq(basis, nominal[rows], rcond=1e-10)[0]
    misfit = np.abs(basis @ weights - nominal[rows]).max()
    return (lambda at: features(at) @ weights) if misfit < _TOLERANCE * nominal.std() * 10 else None
