"""Twin of gc_adc_spi: codes to currents, and what its frames carry. gc_adc_spi.vhd has the equation."""

SCALE_FRACTION = 8


def current_ua(code: int, zero: int, scale: int) -> int:
    """uA of a code; scale in uA per code with 8 bits behind the point. Saturated to 32 bits."""
    return max(-(2**31), min(2**31 - 1, (code - zero) * scale >> SCALE_FRACTION))


def command(channel: int, base: int = 0x0806, shift: int = 7) -> int:
    """The frame that asks for a channel: MAX11123 and MAX11125, mode manual, CHAN_ID = 1, SWCNV = 1."""
    return base + (channel << shift)
