"""What the core is meant to reach beside its peers, each claim decided by the measured rows."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from operator import ge, gt

from gravcomp_lab.peers.measure import PeerRow, common_speeds

ERROR_LIMIT = 2.5e-4  # of full scale


@dataclass(frozen=True)
class PeerClaim:
    """A claim, whether it is reached (None: not measured), and the figures that decide."""

    text: str
    is_reached: bool | None
    figures: str


def claims(ours: Mapping[int, PeerRow], peers: Sequence[PeerRow]) -> list[PeerClaim]:
    """The claims about the core by number of lanes. A clock or a latency has to hold at every speed grade.

    The latency of a peer is the one that its tool claims where that is shorter than the one at its ports.
    """
    parallel = [row for row in peers if row.interval == 1]
    serial = [row for row in peers if row.interval > 1]
    quadratic = [row for row in parallel if "quadratic" in row.name]
    checks = [
        (4, "lower latency than da4ml's quickest quadratic build", partial(_lower_latency, rows=quadratic)),
        (4, "under a fifth of its logic", partial(_share, row=_quickest(quadratic), limit=1 / 5)),
        (20, "higher clock than every build of da4ml", partial(_clock, rows=parallel, factor=1, is_reached=gt)),
        (20, "under three quarters of da4ml's smallest logic", partial(_share, row=_smallest(parallel), limit=3 / 4)),
        (1, "at least twice the clock of every serial peer", partial(_clock, rows=serial, factor=2, is_reached=ge)),
        (1, "under an eighth of NNgen's logic", partial(_share, row=_smallest(serial), limit=1 / 8)),
    ]
    found = []
    for lanes, text, check in checks:
        is_reached, figures = check(ours[lanes]) if lanes in ours else (None, "")
        found.append(PeerClaim(f"{lanes} lane{'s' * (lanes > 1)}: {text}", is_reached, figures))
    return [*found, _error(ours)]


def _quickest(rows: Sequence[PeerRow]) -> PeerRow:
    return min(rows, key=lambda row: row.latency_claimed_ns(min(row.clock_mhz)))


def _smallest(rows: Sequence[PeerRow]) -> PeerRow:
    return min(rows, key=lambda row: row.comb)


def _lower_latency(core: PeerRow, rows: Sequence[PeerRow]) -> tuple[bool, str]:
    speeds = common_speeds([core, *rows])
    claimed = {speed: (core.latency_ns(speed), min(row.latency_claimed_ns(speed) for row in rows)) for speed in speeds}
    at_ports = {speed: (core.latency_ns(speed), min(row.latency_ns(speed) for row in rows)) for speed in speeds}
    figures = f"as da4ml counts, {_at_each_speed(claimed, 'ns')} (at its ports, {_at_each_speed(at_ports, 'ns')})"
    return all(mine < theirs for mine, theirs in claimed.values()), figures


def _clock(core: PeerRow, rows: Sequence[PeerRow], factor: float, is_reached: Callable) -> tuple[bool, str]:
    speeds = common_speeds([core, *rows])
    pairs = {speed: (core.clock_mhz[speed], max(row.clock_mhz[speed] for row in rows)) for speed in speeds}
    return all(is_reached(mine, factor * theirs) for mine, theirs in pairs.values()), _at_each_speed(pairs, "MHz")


def _share(core: PeerRow, row: PeerRow, limit: float) -> tuple[bool, str]:
    share = core.comb / row.comb
    return share < limit, f"{core.comb} against {row.comb} TRELLIS_COMB: {share:.3f}"


def _error(ours: Mapping[int, PeerRow]) -> PeerClaim:
    error = max(row.error for row in ours.values())
    text = f"error against float below {ERROR_LIMIT:.1e} of full scale"
    return PeerClaim(text, error < ERROR_LIMIT, f"{error:.1e}")


def _at_each_speed(pairs: Mapping[int, tuple[float, float]], unit: str) -> str:
    return "; ".join(f"speed {s}: {mine:.2f} against {theirs:.2f} {unit}" for s, (mine, theirs) in pairs.items())
