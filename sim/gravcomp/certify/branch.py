"""Branch and bound: boxes are split until none can hold an error above what is to be proven.

The worst boxes are split first, so that whenever the time is up the largest bound of all boxes is a bound for every
pose: a looser one, but proven.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from tqdm import tqdm

_CHUNK = 1024  # boxes that are split at once: the models of their halves stay in the processor's cache


@dataclass(frozen=True)
class Boxes:
    """N boxes low to high (k, N) of k variables; bound (n, N) of the error of n axes in each, and the variable (N,)
    to split it along."""

    low: np.ndarray
    high: np.ndarray
    bound: np.ndarray
    split: np.ndarray

    def __len__(self) -> int:
        return self.low.shape[1]

    def __getitem__(self, which) -> "Boxes":
        return Boxes(*(values[..., which] for values in vars(self).values()))

    def __add__(self, other: "Boxes") -> "Boxes":
        both = zip(vars(self).values(), vars(other).values(), strict=True)
        return Boxes(*(np.concatenate(pair, axis=-1) for pair in both))

    def halves(self) -> tuple[np.ndarray, np.ndarray]:
        """Both halves of every box, low and high (k, 2 N): the lower ones, then the upper ones."""
        n = np.arange(len(self))
        middle = (self.low[self.split, n] + self.high[self.split, n]) / 2
        low, high = np.tile(self.low, 2), np.tile(self.high, 2)
        high[self.split, n], low[self.split, n + len(self)] = middle, middle
        return low, high


@dataclass(frozen=True)
class Bounded:
    """bound (n,) of the error of each axis over all poses; open: the box that kept its bound above what was to be
    proven when the time was up, or None: all is proven; boxes: how many were looked at."""

    bound: np.ndarray
    open: Boxes | None
    n_boxes: int


def branch_and_bound(
    evaluate: Callable[[np.ndarray, np.ndarray], Boxes],
    wanted: Callable[[], np.ndarray],
    low: np.ndarray,
    high: np.ndarray,
    seconds: float,
) -> Bounded:
    """Bound the errors over the box low to high (k,) until each axis is below wanted() (n,), or the time is up.

    evaluate: boxes with their bounds. wanted is asked again each time: what is proven may follow what is found.
    """
    began = time.monotonic()
    boxes = evaluate(low[:, None], high[:, None])
    n_boxes, settled = 1, np.zeros(len(boxes.bound))
    with tqdm(desc="certify", unit=" boxes", delay=2.0) as bar:
        while True:
            excess = (boxes.bound / wanted()[:, None]).max(axis=0)
            settled = np.maximum(settled, boxes.bound[:, excess <= 1.0].max(axis=1, initial=0.0))
            boxes, excess = boxes[excess > 1.0], excess[excess > 1.0]
            bar.update(n_boxes - bar.n)
            bar.set_postfix_str(f"{len(boxes)} open, worst {excess.max(initial=1.0):.4g} x the bound", refresh=False)
            if not len(boxes) or time.monotonic() - began > seconds:
                break
            order = np.argpartition(-excess, min(_CHUNK, len(boxes) - 1))
            worst, boxes = boxes[order[:_CHUNK]], boxes[order[_CHUNK:]]
            parts = evaluate(*worst.halves())
            # What holds for a box holds for its halves.
            np.minimum(parts.bound, np.tile(worst.bound, 2), out=parts.bound)
            boxes, n_boxes = boxes + parts, n_boxes + len(parts)
    is_worst = np.argmax(excess)[None] if len(boxes) else None
    bound = np.maximum(settled, boxes.bound.max(axis=1, initial=0.0))
    return Bounded(bound, boxes[is_worst] if len(boxes) else None, n_boxes)
