"""Bit-true twin of gc_servo, a tick at a time: a PID per axis beside the feed-forward. Integers without a width.

gc_servo.vhd has the equations. Every sum here is exact, so that equality with the RTL on corners also says that none of
its sums overflows; ``intervals`` bounds them for every input.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

GAIN_BITS, DISTANCE_BITS, CURRENT_BITS = 32, 24, 32
# Bits behind the point: of a product and of the integral, of the lag as its gain sees it, of the low-passed position.
PROPORTIONAL_FRACTION, INTEGRAL_FRACTION, LAG_FRACTION, SLOW_FRACTION = 12, 20, 4, 19
STEPS = 9  # clocks per axis


@dataclass(frozen=True)
class Gains:
    """One axis: gains in their raw units, filter the power of two of its ticks, limit in uA, astray in counts;
    speed_feed: the setpoint's speed is fed forward."""

    proportional: int = 0
    integral: int = 0
    derivative: int = 0
    filter: int = 0
    limit: int = 2**31 - 1
    astray: int = 2**32 - 1
    speed_feed: bool = False


def gains_of(
    stiffness_ua: float,
    integral_ua: float,
    damping_ua: float,
    tick_s: float,
    filter_: int,
    limit_ua: float,
    speed_feed: bool = False,
) -> Gains:
    """Gains from uA per count, uA per count and second, and uA per count and second of speed, rounded.

    The derivative gain acts on the lag, 2**filter_ ticks of speed. ValueError: a gain is negative or too large.
    """
    raw = {
        "proportional": round(stiffness_ua * 2**PROPORTIONAL_FRACTION),
        "integral": round(integral_ua * tick_s * 2**INTEGRAL_FRACTION),
        "derivative": round(damping_ua / (tick_s * 2**filter_) * 2 ** (PROPORTIONAL_FRACTION - LAG_FRACTION)),
    }
    for name, value in raw.items():
        if not 0 <= value < 2**GAIN_BITS:
            raise ValueError(f"{name} gain: {value} is not within 0 and {2**GAIN_BITS - 1}")
    return Gains(**raw, filter=filter_, limit=round(limit_ua), speed_feed=speed_feed)


def clip(value: int, limit: int) -> int:
    """The value within +- limit."""
    return max(-limit, min(limit, value))


def saturate(value: int, bits: int) -> int:
    """The value within the range of a signed number of so many bits."""
    return max(-(2 ** (bits - 1)), min(2 ** (bits - 1) - 1, value))


@dataclass
class ServoAxis:
    """One axis of gc_servo: state, and the values that the sums of its last tick had."""

    summed: int = 0
    slow: int | None = None
    feeds: bool = False
    correction: int = 0
    is_astray: bool = False
    sums: dict[str, int] = field(default_factory=dict)

    def stop(self) -> None:
        """run = '0'."""
        self.summed, self.slow, self.correction, self.is_astray = 0, None, 0, False

    def tick(self, count: int, setpoint: int, gains: Gains) -> int:
        """One tick; returns the correction, uA."""
        error = setpoint - count
        place = -error if gains.speed_feed else count
        is_new = self.slow is None or self.feeds != gains.speed_feed
        self.feeds = gains.speed_feed
        lag = 0 if is_new else (place << SLOW_FRACTION) - self.slow
        self.slow = place << SLOW_FRACTION if is_new else self.slow + (lag >> gains.filter)
        self.is_astray = abs(error) > gains.astray
        error_2 = saturate(error, DISTANCE_BITS)
        lag_2 = saturate(lag >> SLOW_FRACTION - LAG_FRACTION, DISTANCE_BITS)
        sum_6 = self.summed + gains.integral * error_2
        kept = clip(sum_6, gains.limit << INTEGRAL_FRACTION) if gains.integral else 0
        swing = gains.proportional * error_2 - gains.derivative * lag_2
        total = swing + (kept >> INTEGRAL_FRACTION - PROPORTIONAL_FRACTION)
        whole = total >> PROPORTIONAL_FRACTION
        self.sums = {
            "error_1": error,
            "place_1": place,
            "lag_2": lag,
            "slow": self.slow,
            "sum_6": sum_6,
            "swing_7": swing,
            "total_8": total,
        }
        self.correction = clip(whole, gains.limit)
        winds_up = self.correction != whole and whole * error_2 > 0 and gains.integral
        self.summed = self.summed if winds_up else kept
        return self.correction


def servo(
    counts: Sequence[Sequence[int]], setpoints: Sequence[Sequence[int]], gains: Sequence[Gains]
) -> list[list[int]]:
    """Corrections, uA, (ticks, axes) from counts and setpoints (ticks, axes), from the first tick after run rose."""
    axes = [ServoAxis() for _ in gains]
    return [
        [axis.tick(int(c), int(s), g) for axis, c, s, g in zip(axes, count, setpoint, gains, strict=True)]
        for count, setpoint in zip(counts, setpoints, strict=True)
    ]


def intervals() -> dict[str, tuple[int, int]]:
    """Lowest and highest value of each sum of gc_servo by name: for every gain, count, setpoint and state."""
    low, high = -(2 ** (CURRENT_BITS - 1)), 2 ** (CURRENT_BITS - 1) - 1
    product = (2**GAIN_BITS - 1) * 2 ** (DISTANCE_BITS - 1)
    summed = high << INTEGRAL_FRACTION
    total = 2 * product + (summed >> INTEGRAL_FRACTION - PROPORTIONAL_FRACTION) + 1
    place = high - low
    lag = 2 * place << SLOW_FRACTION
    return {
        "error_1": (-place, place),
        "place_1": (-place, place),
        "lag_2": (-lag, lag),
        "slow": (-place << SLOW_FRACTION, place << SLOW_FRACTION),  # between places
        "sum_6": (-summed - product, summed + product),
        "swing_7": (-2 * product, 2 * product),
        "total_8": (-total, total),
    }
