"""Facts that VHDL and C have, too. Written by `make regs` from rtl/registers, facts.toml and gc_registers.rdl."""

from enum import IntEnum, IntFlag

MAX_AXES = 8

# Loading: the key, and words of an image from kick to kick.
LOAD_KEY = 0x4B455953
WORDS_PER_KICK = 64

# Words of records that can be read at once, from record_word on.
RECORD_WINDOW = 64


class State(IntEnum):
    """States of the brakes."""

    BRAKED = 0
    HOLDING = 3
    RUN = 5
    FAULT = 6
    FAULTED = FAULT  # as in C, where GRAVCOMP_FAULT is a result


class Cause(IntEnum):
    """Causes of a fault, bits of the register fault."""

    ESTOP = 0
    ENCODER = 1
    CRC = 2
    ROM = 3
    SPEED = 4
    POSITION = 5
    SATURATION = 6
    WATCHDOG = 7
    RESULT = 8
    UNREFERENCED = 9
    COMMAND = 10
    HOLD = 11
    BRAKE = 12
    CLOCK = 13
    CORE = 14
    UPSET = 15
    FOLLOWING = 16

    @property
    def mask(self) -> int:
        """The cause in a register of causes."""
        return 1 << self


# Causes that are faults while braked, too.
ALWAYS = 0xD00F


class Event(IntFlag):
    """What interrupts."""

    RESULT = 1
    FAULT = 2
    MISSED_TICK = 4
    CORE_STOPPED = 8


OPERAND_BITS = 18
IMAGE_WORD_BITS = 32
SPEED_ADDRESS_BITS = 9
POSITION_ADDRESS_BITS = 8

# Latencies.
ACTIVATION_CLOCKS = 3
SPEED_METER_CLOCKS = 3
COMPENSATOR_CLOCKS = 14
CURRENT_SCALER_CLOCKS = 4
DRIVE_CLOCKS = 6

# An image: its sections, and the scalars of the last one with the name of their width.
IMAGE_SECTIONS = ("hidden", "output", "friction", "mu", "position", "scalar")
IMAGE_SCALARS = {
    "count_low": "count",
    "count_high": "count",
    "input_scale": "operand",
    "x_low": "operand",
    "x_high": "operand",
    "output_bias": "output_sum",
    "output_scale": "operand",
    "current_scale": "operand",
    "phase_step": "phase_step",
}
