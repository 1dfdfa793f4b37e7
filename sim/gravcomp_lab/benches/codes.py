"""Integer codes to and from packed ports: value 0 lowest, two's complement; the machine whose ROM is simulated."""

import os
from collections.abc import Iterable
from functools import cache
from pathlib import Path

import numpy as np

from gravcomp.core.compensation import load_compensation
from gravcomp.core.compensator_tables import FixedCompensation, quantise_compensation
from gravcomp.core.folder import folder_hash
from gravcomp.core.formats import FixedNetwork
from gravcomp.core.quantised import quantised
from gravcomp.network.weights import load_network
from gravcomp.robot.machine import load_machine
from gravcomp_lab.shipped import ROOT


def weights_under_test() -> Path:
    """The weights folder that the ROM under test was made from: weights/spheiro, or the one in WEIGHTS."""
    return ROOT / os.environ.get("WEIGHTS", "weights/spheiro")


def hash_under_test() -> str:
    """SHA-256 of the machine folder under test, as its ROM tells it."""
    folder = weights_under_test()
    return folder_hash(folder, load_machine(folder))


def fixed_network() -> FixedNetwork:
    """The network under test as the hardware holds it."""
    return _fixed_network(*_folder_and_times())


def fixed_compensation() -> FixedCompensation:
    """The compensator's tables under test as the hardware holds them."""
    return _fixed_compensation(*_folder_and_times())


def _folder_and_times() -> tuple[Path, frozenset[tuple[str, int]]]:
    """The weights folder under test, and when each of its files was written.

    A simulation asks for its constants at every turn: they are read once, until a file is written anew.
    """
    folder = weights_under_test()
    return folder, frozenset((file.name, file.stat().st_mtime_ns) for file in folder.iterdir())


@cache
def _fixed_network(folder: Path, times: frozenset[tuple[str, int]]) -> FixedNetwork:
    return quantised(load_machine(folder), load_network(folder), folder)


@cache
def _fixed_compensation(folder: Path, times: frozenset[tuple[str, int]]) -> FixedCompensation:
    constants = load_compensation(folder, _fixed_network(folder, times).n_axes)
    return quantise_compensation(constants, load_machine(folder).drive, folder)


def pack(values: Iterable[int], bits: int) -> int:
    """Unsigned integer that holds the values side by side, value 0 lowest."""
    return sum((int(value) & (1 << bits) - 1) << bits * i for i, value in enumerate(values))


def pack_rows(values: np.ndarray, bits: int) -> np.ndarray:
    """pack of each row (k, n) of integers of at most 62 bits; Python's integers (k,)."""
    codes = (values & (1 << bits) - 1).astype(object)
    return sum(codes[:, i] << bits * i for i in range(codes.shape[1]))


def unpack(packed: Iterable[int], bits: int, n_values: int) -> np.ndarray:
    """Signed values (k, n_values) of k packed integers: the inverse of pack."""
    sign, mask = 1 << bits - 1, (1 << bits) - 1
    return np.array([[((word >> bits * i & mask) ^ sign) - sign for i in range(n_values)] for word in packed])


def corners_and_random(bits: int, shape: tuple[int, ...], rng: np.random.Generator) -> np.ndarray:
    """Signed codes (..., n): uniform, with one in four replaced by a corner of the format (extremes, 0, +-1)."""
    low, high = -(1 << bits - 1), (1 << bits - 1) - 1
    values = rng.integers(low, high, shape, endpoint=True)
    corners = rng.choice([low, low + 1, -1, 0, 1, high - 1, high], shape)
    return np.where(rng.random(shape) < 0.25, corners, values)
