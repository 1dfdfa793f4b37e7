"""The image: all constants of a core that is built, as the words with which they are loaded into it at run time.

A record is a whole number of 32-bit words, the low one first, its fields side by side from bit 0, signed ones in two's
complement, the bits above them zero. The sections, in the order of gravcomp.facts.IMAGE_SECTIONS:

    hidden, output          a record per neuron: weights of the inputs and bias; weights of the outputs
    friction, mu, position  a record per node, axis 1 first: value, step
    scalar                  one record: those of gravcomp.facts.IMAGE_SCALARS in order, axis 1 first

Formats are those of the ROM that the core was built with. The image's CRC is CRC-32 (zlib) of its words as
little-endian bytes.
"""

import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gravcomp.core import formats as q
from gravcomp.core.compensator_tables import PHASE_STEP_BITS, FixedCompensation, quantise_compensation
from gravcomp.core.folder import load_folder
from gravcomp.core.formats import FixedNetwork
from gravcomp.core.quantised import quantised
from gravcomp.errors import InputError
from gravcomp.facts import IMAGE_SCALARS, IMAGE_SECTIONS, IMAGE_WORD_BITS
from gravcomp.twin.precision import Precision, certified, precision

Record = list[tuple[int, int]]  # (value, bits), the first one lowest


@dataclass(frozen=True)
class Image:
    """An image and what it holds. words (n,): unsigned, 32 bits."""

    words: np.ndarray
    network: FixedNetwork
    compensation: FixedCompensation
    precision: Precision

    @property
    def data(self) -> bytes:
        """The words as little-endian bytes."""
        return self.words.astype("<u4").tobytes()

    @property
    def crc32(self) -> int:
        return zlib.crc32(self.data)


def load_image(folder: Path | str, rom: Path | str) -> Image:
    """The image of a machine folder for a core whose ROM was made from the folder rom.

    Raises InputError when one of them cannot be read, when the network has another size or form or the core another
    clock, or when a format of the core cannot hold a value or a sum, or costs too much.
    """
    built, given = load_folder(rom), load_folder(folder)
    if given.machine.clock_hz != built.machine.clock_hz:
        raise InputError(
            f"{given.machine.where}: clock_hz = {given.machine.clock_hz:g}, but the core of {rom} runs at "
            f"{built.machine.clock_hz:g}; give that"
        )
    drive = given.machine.drive
    formats = quantised(built.machine, built.network, rom)
    network = quantised(given.machine, given.network, folder, formats)
    cost = certified(precision(given.network, network, drive.unit_per_count, built.network), folder, rom)
    compensation = quantise_compensation(given.compensation, drive, folder)
    return Image(image_words(network, compensation), network, compensation, cost)


def image_words(network: FixedNetwork, compensation: FixedCompensation) -> np.ndarray:
    """The words (n,) of an image, uint32."""
    records = image_records(network, compensation)
    words = [word for section in IMAGE_SECTIONS for record in records[section] for word in record_words(record)]
    return np.array(words, dtype=np.uint32)


def image_records(network: FixedNetwork, compensation: FixedCompensation) -> dict[str, list[Record]]:
    """The records of each section."""
    hidden = zip(network.hidden_weights, network.hidden_bias, strict=True)
    records = {
        "hidden": [[*_operands(weights), (bias, network.hidden_sum_bits)] for weights, bias in hidden],
        "output": [_operands(weights) for weights in network.output_weights.T],
        "scalar": [_scalars(network, compensation)],
    }
    for name in ("friction", "mu", "position"):
        records[name] = [_operands(node) for node in getattr(compensation, name).reshape(-1, 2)]
    return records


def _operands(values: np.ndarray) -> Record:
    return [(value, q.OPERAND_BITS) for value in values]


def _scalars(network: FixedNetwork, compensation: FixedCompensation) -> Record:
    widths = {
        "count": q.COUNT_BITS,
        "operand": q.OPERAND_BITS,
        "output_sum": network.output_sum_bits,
        "phase_step": PHASE_STEP_BITS,
    }
    values = vars(network) | {"phase_step": compensation.phase_step}
    return [(value, widths[bits]) for name, bits in IMAGE_SCALARS.items() for value in values[name]]


def record_words(record: Record) -> list[int]:
    """The words of a record."""
    whole, low = 0, 0
    for value, bits in record:
        whole |= (int(value) & (1 << bits) - 1) << low
        low += bits
    return [whole >> bit & (1 << IMAGE_WORD_BITS) - 1 for bit in range(0, low, IMAGE_WORD_BITS)]
