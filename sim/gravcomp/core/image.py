"""The image: all constants of a core that is built, as the words with which they are loaded into it at run time.

A record is a whole number of 32-bit words, the low one first, its fields side by side from bit 0, signed ones in two's
complement, the bits above them zero. In order:

    hidden layer        a record per neuron: weights of the inputs, bias
    output layer        a record per neuron: weights of the outputs
    friction, mu        a record per node: value, step; axis 1 first
    position            likewise
    scalars             one record: per axis lower and upper limit of the count, those of x, input scale, output bias,
                        output scale, current scale, phase step

Formats are those of the ROM that the core was built with. The image's CRC is CRC-32 (zlib) of its words as
little-endian bytes.
"""

import zlib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gravcomp.core import formats as q
from gravcomp.core.compensator_tables import PHASE_STEP_BITS, FixedCompensation, quantise_compensation
from gravcomp.core.folder import load_folder
from gravcomp.core.formats import FixedNetwork, quantise
from gravcomp.errors import InputError
from gravcomp.twin.precision import Precision, certified, precision

WORD_BITS = 32


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

    Raises InputError when one of them cannot be read, when the network has another size or the core another clock, or
    when a format of the core cannot hold a value or a sum, or costs too much.
    """
    built, given = load_folder(rom), load_folder(folder)
    if given.machine.clock_hz != built.machine.clock_hz:
        raise InputError(
            f"{given.machine.where}: clock_hz = {given.machine.clock_hz:g}, but the core of {rom} runs at "
            f"{built.machine.clock_hz:g}; give that"
        )
    drive = given.machine.drive
    formats = quantise(built.network, built.machine.drive, rom)
    network = quantise(given.network, drive, folder, formats)
    cost = certified(precision(given.network, network, drive.unit_per_count, built.network), folder, rom)
    compensation = quantise_compensation(given.compensation, drive, folder)
    return Image(image_words(network, compensation), network, compensation, cost)


def image_words(network: FixedNetwork, compensation: FixedCompensation) -> np.ndarray:
    """The words (n,) of an image, uint32."""
    records = [
        [*_operands(weights), (bias, network.hidden_sum_bits)]
        for weights, bias in zip(network.hidden_weights, network.hidden_bias, strict=True)
    ]
    records += [_operands(weights) for weights in network.output_weights.T]
    for table in (compensation.friction, compensation.mu, compensation.position):
        records += [_operands(node) for node in table.reshape(-1, 2)]
    records += [_scalars(network, compensation)]
    return np.array([word for record in records for word in _words(record)], dtype=np.uint32)


def _operands(values: np.ndarray) -> list[tuple[int, int]]:
    return [(value, q.OPERAND_BITS) for value in values]


def _scalars(network: FixedNetwork, compensation: FixedCompensation) -> list[tuple[int, int]]:
    fields = (
        (network.count_low, q.COUNT_BITS),
        (network.count_high, q.COUNT_BITS),
        (network.x_low, q.OPERAND_BITS),
        (network.x_high, q.OPERAND_BITS),
        (network.input_scale, q.OPERAND_BITS),
        (network.output_bias, network.output_sum_bits),
        (network.output_scale, q.OPERAND_BITS),
        (network.current_scale, q.OPERAND_BITS),
        (compensation.phase_step, PHASE_STEP_BITS),
    )
    return [(value, bits) for values, bits in fields for value in values]


def _words(fields: Iterable[tuple[int, int]]) -> list[int]:
    """The words of a record of (value, bits), first field lowest."""
    record, low = 0, 0
    for value, bits in fields:
        record |= (int(value) & (1 << bits) - 1) << low
        low += bits
    return [record >> bit & (1 << WORD_BITS) - 1 for bit in range(0, low, WORD_BITS)]
