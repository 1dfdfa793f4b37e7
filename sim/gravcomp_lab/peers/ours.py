"""What the core reaches: the results of `make synth`, and its error against the float network."""

import json
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from gravcomp.core.quantised import quantised
from gravcomp.errors import InputError
from gravcomp.network.weights import load_network
from gravcomp.robot.machine import load_machine
from gravcomp.twin.bounds import fixed_point_error_mn
from gravcomp_lab.peers.jitter import PERCENTILES, Timing
from gravcomp_lab.peers.measure import PeerRow
from gravcomp_lab.shipped import SPHEIRO

LANES = {1, 4, 20}


def core_rows(build: Path, error: float = math.nan) -> dict[int, PeerRow]:
    """Those of the shipped core with 1, 4 and 20 lanes that `make synth` left; InputError when there are none."""
    path = build / "synth" / SPHEIRO.name / "synth.json"
    try:
        rows = {result["lanes"]: _row(result, error) for result in json.loads(path.read_text())}
    except (OSError, ValueError, KeyError, TypeError):
        rows = {}
    if not rows.keys() & LANES:
        raise InputError(f"{path}: no result for 1, 4 or 20 lanes, or a damaged one; start `make synth`")
    return {lanes: rows[lanes] for lanes in sorted(rows.keys() & LANES)}


def core_error(weights: Path, n_poses: int, seed: int) -> float:
    """Largest distance from the float network, in full scale of an output, at random poses of the workspace.

    From encoder counts to mN: unlike that of a peer it has the rounding of counts and forces in it.
    """
    network, machine = load_network(weights), load_machine(weights)
    error_mn = fixed_point_error_mn(network, quantised(machine, network, weights), machine, n_poses, seed)
    return float(np.abs(error_mn / (1000.0 * network.f_scale)).max())


def core_timings(rows: dict[int, PeerRow]) -> Iterator[Timing]:
    """The core's latency per number of lanes and speed grade; every percentile is the same."""
    for row in rows.values():
        for speed in sorted(row.clock_mhz):
            yield Timing(f"{row.name}, speed {speed}", (row.latency_ns(speed),) * len(PERCENTILES))


def _row(result: dict, error: float) -> PeerRow:
    used = result["cells"]["placed"]
    return PeerRow(
        name=f"this core, {result['lanes']} lane{'s' * (result['lanes'] > 1)}",
        comb=used["TRELLIS_COMB"],
        ff=used["TRELLIS_FF"] - result["port_flip_flops"],
        mult=used.get("MULT18X18D", 0),
        ram=used.get("DP16KD", 0),
        clock_mhz={int(speed): mhz for speed, mhz in result["quoted_mhz"].items()},
        n_seeds=min(map(len, result["clock_mhz"].values())),
        latency=result["latency"],
        latency_claimed=result["latency"],
        interval=result["interval"],
        error=error,
    )
