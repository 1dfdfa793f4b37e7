"""Logic and clock of a peer's design: the flow that our core goes through, on LFE5U-85F."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from gravcomp_lab.peers.design import PeerDesign
from gravcomp_lab.synthesis.place_route import PlacedDesign, place_and_route
from gravcomp_lab.synthesis.yosys import synthesise

PART = "85k"


@dataclass(frozen=True)
class PeerRow:
    """One design of the comparison.

    comb, ff, mult, ram: cells used (TRELLIS_COMB, TRELLIS_FF, MULT18X18D, DP16KD). clock_mhz: best clock by speed
    grade, of n_seeds placements. latency, interval, error: as in PeerDesign, as is latency_claimed.
    """

    name: str
    comb: int
    ff: int
    mult: int
    ram: int
    clock_mhz: dict[int, float]
    n_seeds: int
    latency: int
    latency_claimed: int
    interval: int
    error: float

    def latency_ns(self, speed: int) -> float:
        return self.latency / self.clock_mhz[speed] * 1e3

    def latency_claimed_ns(self, speed: int) -> float:
        return self.latency_claimed / self.clock_mhz[speed] * 1e3

    def rate_mhz(self, speed: int) -> float:
        """Inferences per microsecond."""
        return self.clock_mhz[speed] / self.interval


def common_speeds(rows: Iterable[PeerRow]) -> list[int]:
    """The speed grades at which all of the rows have a clock."""
    return sorted(set.intersection(*(set(row.clock_mhz) for row in rows)))


def measure(design: PeerDesign, speeds: Sequence[int], seeds: Sequence[int], progress: Callable[[], None]) -> PeerRow:
    """Synthesise and place a peer's design beside its Verilog; progress is called after every placement."""
    folder, placed = design.verilog.parent, []
    netlist = synthesise(design.verilog, design.top, "ecp5", folder / "ecp5").json
    for speed in speeds:
        for seed in seeds:
            out = folder / f"speed{speed}-seed{seed}"
            placed.append((speed, place_and_route(netlist, part=PART, speed=speed, seed=seed, out=out)))
            progress()
    return row(design, placed)


def row(design: PeerDesign, placed: Sequence[tuple[int, PlacedDesign]]) -> PeerRow:
    """The best clock of all placements at each speed grade, with the cells of the first one."""
    used, speeds = placed[0][1].used, sorted({speed for speed, _ in placed})
    best = {speed: max(found.clock.mhz for grade, found in placed if grade == speed) for speed in speeds}
    return PeerRow(
        name=design.name,
        comb=used["TRELLIS_COMB"],
        ff=used["TRELLIS_FF"],
        mult=used.get("MULT18X18D", 0),
        ram=used.get("DP16KD", 0),
        clock_mhz=best,
        n_seeds=len(placed) // len(speeds),
        latency=design.latency,
        latency_claimed=design.latency_claimed,
        interval=design.interval,
        error=design.error,
    )
