"""gc_serial_system as the toplevel: its line from frames or through a pseudo terminal, its axes as Board's."""

import contextlib
import os
import tty

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, Timer
from cocotbext.uart import UartSink, UartSource

from support.board import INDEX, Board

BAUD = 3_000_000
BUS_HZ = 24_000_000
# The core's clock is slow, to simulate less; it counts its times at the rate of its ROM.
CORE_NS = 250
GAP_BITS = 36  # 3.5 characters and a bit


class SerialBoard(Board):
    """Board behind its serial pins."""

    async def start(self) -> None:
        dut = self.dut
        self.position, self.period, self.wires = [INDEX - 8] * 3, 0, {}
        for clock in Board._clocks:  # of the test before
            clock.stop()
        Board._clocks = (Clock(dut.clk, CORE_NS, "ns"), Clock(dut.bus_clk, 2 * round(5e11 / BUS_HZ), "ps"))
        for clock in Board._clocks:
            clock.start()
        dut.estop_n.value = 1
        dut.pin_error.value = 0
        self.drive()
        self.source, self.sink = UartSource(dut.pin_rx, baud=BAUD, bits=8), UartSink(dut.pin_tx, baud=BAUD, bits=8)
        for end in (self.source, self.sink):
            end.log.setLevel("WARNING")
        dut.bus_rst.value = 1
        await self.clocks(10)
        await FallingEdge(dut.bus_clk)
        dut.bus_rst.value = 0
        await self.clocks(60)

    async def bits(self, n: int) -> None:
        await Timer(n * 10**12 // BAUD, "ps")

    async def exchange(self, frame: bytes, patience_bits: int = 200) -> bytes | None:
        """The answer to a frame, once nothing more comes; None: none has begun in time."""
        await self.source.write(frame)
        await self.source.wait()
        await self.bits(GAP_BITS + 20)
        for _ in range(patience_bits):
            if self.dut.pin_tx_enable.value == 1:
                break
            await self.bits(1)
        while self.dut.pin_tx_enable.value == 1:
            await self.bits(1)
        await self.bits(2)
        return bytes(self.sink.read_nowait()) or None

    def serve(self) -> str:
        """Put a pseudo terminal before the pins; returns the name of its other end."""
        self._ours, self._theirs = os.openpty()
        tty.setraw(self._theirs)
        os.set_blocking(self._ours, False)
        cocotb.start_soon(self._carry())
        return os.ttyname(self._theirs)

    async def _carry(self) -> None:
        while True:
            with contextlib.suppress(BlockingIOError):
                self.source.write_nowait(os.read(self._ours, 4096))
            if not self.sink.empty():
                os.write(self._ours, bytes(self.sink.read_nowait()))
            await self.bits(20)
