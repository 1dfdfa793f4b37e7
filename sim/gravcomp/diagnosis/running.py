"""States that follow each row from the one before, for all rows at once.

Where two steps of a form are one step of the same form, runs of 1, 2, 4, ... of them are joined, all rows together, in
log2(n) turns (Hillis and Steele, 1986).
"""

from collections.abc import Callable

import numpy as np

Steps = tuple[np.ndarray, ...]  # parameters (n,) of n steps


def running(join: Callable[[Steps, Steps], Steps], steps: Steps) -> Steps:
    """All steps up to each, (n,), as one step; join(first, second) is the one that both are."""
    run = 1
    while run < len(steps[0]):
        joined = join(tuple(own[:-run] for own in steps), tuple(own[run:] for own in steps))
        steps = tuple(np.concatenate([old[:run], new]) for old, new in zip(steps, joined, strict=True))
        run *= 2
    return steps


def after_clips(start: float, shift: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """States (n,) of x -> clip(x + shift, low, high), row by row."""

    def join(first: Steps, second: Steps) -> Steps:
        (a, *ends), (b, least, most) = first, second
        return a + b, *(np.clip(end + b, least, most) for end in ends)

    shift, low, high = running(join, (shift, low, high))
    return np.clip(start + shift, low, high)


def after_lines(start: float, gain: np.ndarray, offset: np.ndarray) -> np.ndarray:
    """States (n,) of x -> gain x + offset, row by row."""
    gain, offset = running(
        lambda first, second: (first[0] * second[0], second[0] * first[1] + second[1]), (gain, offset)
    )
    return gain * start + offset


def next_told(direction: np.ndarray) -> np.ndarray:
    """Directions (n,) with the next one that v tells in the place of each that it does not; 0 where none follows."""
    n = len(direction)
    after = np.minimum.accumulate(np.where(direction != 0.0, np.arange(n), n)[::-1])[::-1]
    return np.append(direction, 0.0)[after]
