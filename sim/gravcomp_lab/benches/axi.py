"""The host of gc_system in a test: register accesses by name over AXI4-Lite."""

from collections.abc import Callable, Coroutine, Iterator

from cocotb.task import resume
from cocotb.triggers import SimTimeoutError, with_timeout
from cocotbext.axi import AxiLiteBus, AxiLiteMaster, AxiResp

from gravcomp_lab.benches.codes import fixed_network
from gravcomp_lab.registers.map import registers_of

# A core that does not answer in this time never will: the test ends instead of waiting.
ANSWER_US = 100


class BusError(RuntimeError):
    """The access got another response than OKAY."""


class Registers:
    """Registers of a dut with s_axi_* ports and the network under test, by name and axis, as unsigned 32-bit words."""

    def __init__(self, dut):
        bus = AxiLiteBus.from_prefix(dut, "s_axi")
        self.master = AxiLiteMaster(bus, dut.s_axi_aclk, dut.s_axi_aresetn, reset_active_level=False)
        for channel in (self.master.write_if, self.master.read_if):
            channel.log.setLevel("WARNING")
        self.map = registers_of(fixed_network().n_axes)
        self.is_silent = False

    def pause(self, pauses: Callable[[], Iterator[bool]]) -> None:
        """Stall each channel in the clocks in which its own iterator of pauses says True."""
        write, read = self.master.write_if, self.master.read_if
        channels = (write.aw_channel, write.w_channel, write.b_channel, read.ar_channel, read.r_channel)
        for channel in channels:
            channel.set_pause_generator(pauses())

    async def _answer(self, access: Coroutine):
        if self.is_silent:
            access.close()
            raise BusError("no access is tried after one without an answer")
        try:
            return await with_timeout(access, ANSWER_US, "us")
        except SimTimeoutError:
            self.is_silent = True
            raise

    async def read_at(self, address: int) -> int:
        answer = await self._answer(self.master.read(address, 4))
        if answer.resp != AxiResp.OKAY:
            raise BusError(f"read at {address:#x}: {answer.resp.name}")
        return int.from_bytes(answer.data, "little")

    async def write_at(self, address: int, word: int) -> None:
        answer = await self._answer(self.master.write(address, (word & 0xFFFFFFFF).to_bytes(4, "little")))
        if answer.resp != AxiResp.OKAY:
            raise BusError(f"write at {address:#x}: {answer.resp.name}")

    async def read(self, name: str, axis: int = 0) -> int:
        return await self.read_at(self.map[name].address + 4 * axis)

    async def write(self, name: str, word: int, axis: int = 0) -> None:
        await self.write_at(self.map[name].address + 4 * axis, word)

    async def read_axes(self, name: str) -> list[int]:
        """The signed words of all axes."""
        words = [await self.read(name, axis) for axis in range(self.map[name].count)]
        return [word - (word >> 31 << 32) for word in words]

    async def write_axes(self, name: str, values) -> None:
        for axis, value in enumerate(values):
            await self.write(name, int(value), axis)

    async def write_all(self, name: str, value: int) -> None:
        """The same to the registers of all axes; to the one register of a name that has no more."""
        await self.write_axes(name, [value] * self.map[name].count)

    async def field(self, name: str, field: str) -> int:
        return self.map[name].field(field, await self.read(name))


class SimulatedBus:
    """Blocking accesses for code that runs in cocotb.bridge, and a record of them."""

    def __init__(self, registers):
        self.read_at, self.write_at = resume(registers.read_at), resume(registers.write_at)
        self.written = []

    def read(self, offset: int) -> int:
        return self.read_at(offset)

    def write(self, offset: int, word: int) -> None:
        self.written.append((offset, word))
        self.write_at(offset, word)
