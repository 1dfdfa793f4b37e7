"""Ports as integers, for what looks at them in every clock.

``handle.value`` makes an array of logic values of what the simulator answers as text, which takes several times as
long as a clock of a small entity; where a bench compares codes, the text is all that it needs.
"""

from collections.abc import Callable

from cocotb.handle import LogicArrayObject, LogicObject


def is_high(handle: LogicObject) -> Callable[[], bool]:
    """Asks whether a port is '1'; 'U' and 'X' are not."""
    text = _text(handle)
    return lambda: text() == "1"


def unsigned(handle: LogicObject | LogicArrayObject) -> Callable[[], int]:
    """Asks for the code of a port. ValueError where a bit is neither 0 nor 1."""
    text = _text(handle)
    return lambda: int(text(), 2)


def signed(handle: LogicObject | LogicArrayObject) -> Callable[[], int]:
    """Asks for the code of a port, of a vector in two's complement. ValueError where a bit is neither 0 nor 1."""
    if isinstance(handle, LogicObject):
        return unsigned(handle)
    text, period = _text(handle), 1 << len(handle)

    def ask() -> int:
        bits = text()
        code = int(bits, 2)
        return code - period if bits[0] == "1" else code

    return ask


def driver(handle) -> Callable[[int], None]:
    """Drives a port that nobody else does: a value that it was given last costs nothing."""
    last = None

    def drive(value: int) -> None:
        nonlocal last
        if value != last:
            handle.value = last = value

    return drive


def _text(handle: LogicObject | LogicArrayObject) -> Callable[[], str]:
    """Asks for the bits, highest first. Not public in cocotb, which has no quicker way that is."""
    return handle._handle.get_signal_val_binstr
