"""Bit-true twin of gc_setpoint: all axes from where they are to a target, together, along minimum jerk.

setpoint = start + (target - start) s(u), s = u**3 (10 - 15 u + 6 u**2); u goes from 0 to 1 in equal steps. Source: T.
Flash, N. Hogan, "The coordination of arm movements", J. Neuroscience 5, 1985.
"""

from collections.abc import Sequence

PHASE_BITS, FACTOR_FRACTION = 32, 28
SPEED_FRACTION, ACCELERATION_FRACTION = 16, 24  # cfg_speed, counts per tick; cfg_acceleration, counts per tick**2
_ONE = 1 << PHASE_BITS


def keeps_limits(rate: int, spans: Sequence[int], speed: Sequence[int], acceleration: Sequence[int]) -> bool:
    """Whether a step of u keeps both limits of every axis: peaks of 15/8 and 47/8 the means, rounded up."""
    for span, fastest, strongest in zip(spans, speed, acceleration, strict=True):
        velocity = -(-abs(span) * rate >> PHASE_BITS - SPEED_FRACTION)
        if 15 * velocity > 8 * fastest:
            return False
        change = -(-velocity * rate >> PHASE_BITS + SPEED_FRACTION - ACCELERATION_FRACTION)
        if 47 * change > 8 * strongest:
            return False
    return True


def rate_of(ticks: int, spans: Sequence[int], speed: Sequence[int], acceleration: Sequence[int]) -> int:
    """The step of u, 2**-32, for a move over spans (counts) in so many ticks or, for the limits, more; 0: refused."""
    rate = _ONE // max(ticks, 2)
    while rate and not keeps_limits(rate, spans, speed, acceleration):
        rate -= max(1, rate >> 4)
    return rate


def ticks_of(rate: int) -> int:
    """Ticks of a move with this step of u."""
    return -(-_ONE // rate)


def blend(phase: int) -> int:
    """s(u), 2**-32, every product rounded down: between 0 and the exact value."""
    square = phase * phase >> PHASE_BITS
    cube = square * phase >> PHASE_BITS
    factor = (10 << PHASE_BITS) - 15 * phase + 6 * square >> PHASE_BITS - FACTOR_FRACTION
    return cube * factor >> FACTOR_FRACTION


def path(start: Sequence[int], target: Sequence[int], rate: int) -> list[list[int]]:
    """Setpoints (ticks, axes) after each tick of a move; the last row is the target."""
    spans = [b - a for a, b in zip(start, target, strict=True)]
    rows = [
        [a + (span * blend(k * rate) + (_ONE >> 1) >> PHASE_BITS) for a, span in zip(start, spans, strict=True)]
        for k in range(1, ticks_of(rate))
    ]
    return [*rows, list(target)]
