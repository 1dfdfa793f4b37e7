"""gc_system as a peripheral of LiteX: AXI4-Lite slave, interrupt, pins. Extra `litex`; a SoC: docs/guide/litex.md."""

from collections.abc import Mapping
from pathlib import Path

from litex.gen import LiteXModule
from litex.soc.integration.soc import SoCRegion
from litex.soc.interconnect import axi
from litex.soc.interconnect.csr_eventmanager import EventManager, EventSourceLevel
from migen import ClockSignal, If, Instance, ResetSignal, Signal

from gravcomp.core.vhdl.network_package import write_rom
from gravcomp.core.vhdl.verilog import rtl_sources, to_verilog
from gravcomp.errors import InputError
from gravcomp.robot.machine import load_machine
from gravcomp.shipped import shipped

TOP = "gc_system"
REGISTERS_BYTES = 0x1000
CURRENT_BITS = 32
# Ports by the bits that an axis has of them, 0 for one bit of all axes; docs/guide/system.md says what each is.
INPUTS = {"pin_a": 1, "pin_b": 1, "pin_z": 1, "pin_error": 1, "estop_n": 0, "brake_fed": 1, "sense_valid": 1,
          "sense_current": CURRENT_BITS}  # fmt: skip
OUTPUTS = {"drive_valid": 0, "drive_current": CURRENT_BITS, "drive_enable": 0, "brake_release": 1, "brake_engage": 1}
_RESET_CLOCKS = 8  # of the slower clock, that gc_system's reset takes


class GravcompSystem(LiteXModule):
    """The core of a machine folder.

    platform: gets its Verilog. folder: machine folder, its ROM goes into out. sys_clk_freq: Hz of the SoC's clock.
    clock_domain: of the core, with the clock_hz of the machine folder, in any relation to "sys". generics: those of
    gc_system, by name. Raises InputError for a wrong machine folder, a generic that GHDL does not know, without GHDL.

    bus: registers, of REGISTERS_BYTES. ev: interrupt, level. All ports of INPUTS and OUTPUTS are signals of that name,
    axis 1 lowest; estop_n is 0, which is pressed, until something drives it.
    """

    def __init__(
        self,
        platform,
        folder: Path | str,
        sys_clk_freq: float,
        out: Path | str,
        clock_domain: str = "gravcomp",
        generics: Mapping[str, int | str] | None = None,
    ):
        machine, out = load_machine(folder), Path(out)
        given = {"clock_hz_g": int(machine.clock_hz), **(generics or {})}
        write_rom(folder, out / "generated")
        sources = rtl_sources(shipped("rtl"), out / "generated")
        platform.add_source(str(to_verilog(sources, TOP, given, out / f"{TOP}.v").resolve()))

        self.bus = axi.AXILiteInterface(data_width=32, address_width=32)
        self.ev = EventManager()
        self.ev.core = EventSourceLevel()
        self.ev.finalize()
        self.axes = machine.n_axes
        ports = {f"i_{name}": self._port(name, bits) for name, bits in INPUTS.items()}
        ports |= {f"o_{name}": self._port(name, bits) for name, bits in OUTPUTS.items()}
        self.specials += Instance(
            TOP,
            **ports,
            **_axi_ports(self.bus),
            i_s_axi_aclk=ClockSignal("sys"),
            i_s_axi_aresetn=self._reset_n(sys_clk_freq / machine.clock_hz),
            i_clk=ClockSignal(clock_domain),
            o_irq=self.ev.core.trigger,
        )

    def connect(self, pads) -> None:
        """Wire the pins of the platform to the ports of the same names. Raises InputError for a name that is none."""
        for name, _ in pads.layout:
            pad = getattr(pads, name)
            if name in INPUTS:
                self.comb += getattr(self, name).eq(pad)
            elif name in OUTPUTS:
                self.comb += pad.eq(getattr(self, name))
            else:
                raise InputError(f"{name}: is no port of {TOP}; give {', '.join([*INPUTS, *OUTPUTS])}")

    def _port(self, name: str, bits: int) -> Signal:
        port = Signal(bits * self.axes or 1, name=name)
        setattr(self, name, port)
        return port

    def _reset_n(self, clocks_per_core_clock: float) -> Signal:
        """Low while the SoC is in reset, and after it until both clocks have seen it for long enough."""
        clocks = round(_RESET_CLOCKS * max(1.0, clocks_per_core_clock)) + 1
        left, running = Signal(max=clocks + 1, reset=clocks), Signal()
        self.sync += If(left != 0, left.eq(left - 1))
        self.comb += running.eq((left == 0) & ~ResetSignal("sys"))
        return running


def add_gravcomp(soc, core: GravcompSystem, origin: int, name: str = "gravcomp") -> None:
    """The core as a slave of a SoC's bus, whatever its standard, from origin on; its interrupt where there is a CPU."""
    soc.add_module(name, core)
    soc.bus.add_slave(name, core.bus, SoCRegion(origin=origin, size=REGISTERS_BYTES, cached=False))
    if soc.irq.enabled:
        soc.irq.add(name, use_loc_if_exists=True)


def _axi_ports(bus) -> dict[str, Signal]:
    """The ports of gc_system's slave, by name."""
    ports = {f"i_s_axi_{ch}addr": getattr(bus, ch).addr[:12] for ch in ("aw", "ar")}
    ports |= {f"i_s_axi_{ch}prot": getattr(bus, ch).prot for ch in ("aw", "ar")}
    for channel in ("aw", "w", "ar"):
        ports[f"i_s_axi_{channel}valid"] = getattr(bus, channel).valid
        ports[f"o_s_axi_{channel}ready"] = getattr(bus, channel).ready
    for channel in ("b", "r"):
        ports[f"o_s_axi_{channel}valid"] = getattr(bus, channel).valid
        ports[f"i_s_axi_{channel}ready"] = getattr(bus, channel).ready
        ports[f"o_s_axi_{channel}resp"] = getattr(bus, channel).resp
    return ports | {
        "i_s_axi_wdata": bus.w.data,
        "i_s_axi_wstrb": bus.w.strb,
        "o_s_axi_rdata": bus.r.data,
    }
