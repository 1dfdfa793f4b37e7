"""gc_system as the toplevel: a test drives its pins, as encoders and their wires do."""

import numpy as np
from cocotb.clock import Clock

from gravcomp.twin.encoder import quadrature
from gravcomp_lab.benches.axi import Registers
from gravcomp_lab.benches.system import ALL_FAULTS, KICK, System

AXES = 3
INDEX = 2  # a count in the index phase
MOTION_CLOCKS = 10  # from count to count
PINS = ("a", "b", "z")


class Board(System):
    """System whose axes are at position, have a mark at index and, if period is not 0, every so many counts.

    wires: levels of pins that do not follow the encoder, by (pin, axis).
    """

    _clocks: tuple[Clock, ...] = ()

    async def start(self) -> None:
        dut = self.dut
        self.position = [INDEX - 8] * AXES
        self.period = 0
        self.wires: dict[tuple[str, int], int] = {}
        for clock in Board._clocks:  # of the test before
            clock.stop()
        Board._clocks = (Clock(dut.clk, 25, "ns"), Clock(dut.s_axi_aclk, 25, "ns"))
        for clock in Board._clocks:
            clock.start()
        for port in ("awvalid", "wvalid", "bready", "arvalid", "rready"):
            getattr(dut, f"s_axi_{port}").value = 0
        dut.estop_n.value = 1
        dut.pin_error.value = 0
        dut.s_axi_aresetn.value = 0
        self.drive()
        await self.clocks(40)
        self.registers = Registers(dut)
        dut.s_axi_aresetn.value = 1
        await self.clocks(60)

    def drive(self) -> None:
        """The pins as they are at these positions."""
        position = np.array(self.position)
        behind = (position - INDEX) % self.period if self.period else position - INDEX
        levels = dict(zip(PINS, (*quadrature(position), behind == 0), strict=True))
        for pin, values in levels.items():
            wires = [self.wires.get((pin, axis), int(value)) for axis, value in enumerate(values)]
            getattr(self.dut, f"pin_{pin}").value = sum(level << axis for axis, level in enumerate(wires))

    async def move(self, axis: int, counts: int, clocks: int = MOTION_CLOCKS) -> int:
        """Move an axis, clocks per count, as long as its brake is released; returns the counts that it went."""
        for k in range(abs(counts)):
            if not self.is_released():
                return k
            self.position[axis] += 1 if counts > 0 else -1
            self.drive()
            await self.clocks(clocks)
        return abs(counts)

    def is_released(self) -> bool:
        return bool(self.dut.brake_release.value)

    async def home(self) -> None:
        """Begin homing and take all axes over their index by hand, from two cycles before it to two behind and back."""
        await self.registers.write_axes("index_position", [INDEX] * AXES)
        await self.registers.write_axes("index_period", [self.period] * AXES)
        await self.registers.write("control", 0)
        await self.clocks(40)  # the core must see it: of two writes close together it may see only the second
        await self.registers.write("control", self.homing)
        await self.clocks(40)
        for target in (INDEX - 8, INDEX + 8, INDEX):
            while set(self.position) != {target}:
                self.position = [p + (p < target) - (p > target) for p in self.position]
                self.drive()
                await self.clocks(MOTION_CLOCKS)
        await self.clocks(40)

    async def run(self, pause: int = 250) -> None:
        """Home, pause so many clocks, tick and release the brakes; all is well then."""
        await self.home()
        await self.registers.write("control", self.homing | 2)
        await self.registers.write("command", KICK)
        await self.clocks(pause)
        await self.registers.write("fault", ALL_FAULTS)
        await self.wait_for_state("braked")
        await self.registers.write("control", self.homing | 3)
        await self.wait_for_state("run")
        assert self.is_released()
        assert await self.registers.read("fault") == 0
        await self.clocks(1)  # an access ends at the other edge: the first level would be too short
