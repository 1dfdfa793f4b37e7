"""What a BiSS C encoder sends, bit by bit, and the CRC over it. gc_biss.vhd has the frame."""

from collections.abc import Sequence

CRC_BITS, POLYNOMIAL = 6, 0x43  # x**6 + x + 1


def crc6(bits: Sequence[int]) -> int:
    """Remainder of the bits, the first one the highest, followed by six zeros, modulo the polynomial."""
    remainder = 0
    for bit in [*bits, *[0] * CRC_BITS]:
        remainder = remainder << 1 | bit
        if remainder >> CRC_BITS:
            remainder ^= POLYNOMIAL
    return remainder


def bits_of(value: int, n_bits: int) -> list[int]:
    """The lowest bits of a value, the highest of them first."""
    return [value >> k & 1 for k in reversed(range(n_bits))]


def frame(position: int, position_bits: int, *, error: bool = False, warning: bool = False) -> list[int]:
    """Start bit, CDS bit, position, nE, nW, inverted CRC."""
    data = [*bits_of(position, position_bits), int(not error), int(not warning)]
    return [1, 0, *data, *bits_of(~crc6(data), CRC_BITS)]
