"""What the core is meant to reach beside its peers, each claim decided by the measured rows."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from gravcomp.peers.measure import SPEEDS, Row

ERROR_LIMIT = 2.5e-4  # of full scale


@dataclass(frozen=True)
class Claim:
    """A claim, whether it is reached, and the figures that decide."""

    text: str
    is_reached: bool
    figures: str


def claims(ours: Mapping[int, Row], peers: Sequence[Row]) -> list[Claim]:
    """The claims about 1, 4 and 20 lanes. A clock or a latency has to hold at every speed grade.

    The latency of a peer is the one that its tool claims where that is shorter than the one at its ports.
    """
    parallel = [row for row in peers if row.interval == 1]
    serial = [row for row in peers if row.interval > 1]
    quadratic = [row for row in parallel if "quadratic" in row.name]
    return [
        _lower_latency(ours[4], quadratic),
        _share("4 lanes: under a fifth of its logic", ours[4], _quickest(quadratic), 1 / 5),
        _higher_clock("20 lanes: higher clock than every build of da4ml", ours[20], parallel, 1.0),
        _share("20 lanes: under three quarters of the logic of da4ml's smallest", ours[20], _smallest(parallel), 3 / 4),
        _higher_clock("1 lane: at least twice the clock of every serial peer", ours[1], serial, 2.0),
        _share("1 lane: under an eighth of NNgen's logic", ours[1], _smallest(serial), 1 / 8),
        _error(ours),
    ]


def _quickest(rows: Sequence[Row]) -> Row:
    return min(rows, key=lambda row: row.latency_claimed_ns(SPEEDS[0]))


def _smallest(rows: Sequence[Row]) -> Row:
    return min(rows, key=lambda row: row.comb)


def _lower_latency(core: Row, rows: Sequence[Row]) -> Claim:
    pairs = [(core.latency_ns(speed), min(row.latency_claimed_ns(speed) for row in rows)) for speed in SPEEDS]
    return Claim(
        "4 lanes: lower latency than da4ml's quickest quadratic build",
        all(mine < theirs for mine, theirs in pairs),
        _at_each_speed(f"{mine:.0f} against {theirs:.0f} ns" for mine, theirs in pairs),
    )


def _higher_clock(text: str, core: Row, rows: Sequence[Row], factor: float) -> Claim:
    pairs = [(core.clock_mhz[speed], max(row.clock_mhz[speed] for row in rows)) for speed in SPEEDS]
    return Claim(
        text,
        all(mine > factor * theirs if factor == 1 else mine >= factor * theirs for mine, theirs in pairs),
        _at_each_speed(f"{mine:.0f} against {theirs:.0f} MHz" for mine, theirs in pairs),
    )


def _share(text: str, core: Row, row: Row, limit: float) -> Claim:
    share = core.comb / row.comb
    return Claim(text, share < limit, f"{core.comb} against {row.comb} TRELLIS_COMB: {share:.3f}")


def _error(ours: Mapping[int, Row]) -> Claim:
    error = max(row.error for row in ours.values())
    text = f"error against float below {ERROR_LIMIT:.1e} of full scale"
    return Claim(text, error < ERROR_LIMIT, f"{error:.1e}")


def _at_each_speed(figures) -> str:
    return "; ".join(f"speed {speed}: {text}" for speed, text in zip(SPEEDS, figures, strict=True))
