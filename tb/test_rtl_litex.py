"""The core in a LiteX SoC under Verilator, behind its Wishbone bus: a robot is homed, moved and measured through it."""

import contextlib
import shutil
from types import SimpleNamespace

import numpy as np
import pytest

from gravcomp.campaign.campaign import Campaign, Plan
from gravcomp.cli import main
from gravcomp.core.folder import load_folder
from gravcomp.core.quantised import quantised
from gravcomp.driver.board import Board, load_limits
from gravcomp.driver.moving import load_motion
from gravcomp.errors import InputError
from gravcomp.facts import Event
from gravcomp.robot.machine import ROBOT_TOML, load_machine
from gravcomp.shipped import shipped
from gravcomp.twin import network as bittrue
from gravcomp_lab.cosim.blind import home
from gravcomp_lab.cosim.library import compiled, generics, slow_machine
from gravcomp_lab.cosim.limits import limits_toml
from gravcomp_lab.cosim.world import World
from runner import BUILD

pytest.importorskip("litex", reason="no LiteX; `pip install '.[litex]'` installs it")
from litex.build.generic_platform import GenericPlatform, Pins
from litex.soc.integration.soc_core import SoCMini
from litex.soc.interconnect import axi
from migen import ClockDomain

from gravcomp.soc.litex import INPUTS, OUTPUTS, GravcompSystem, add_gravcomp

ORIGIN, CLOCK_HZ = 0x3000_0000, 80_000  # of the core, and of the SoC
STEP_CLOCKS = 80
RANGE = "low = 0.2\nhigh = 0.3\n"  # m: a short way
PLAN = Plan(poses=8, legs=2, seed=4, speed=0.08)
IDENT = "gravcomp in a SoC"

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not shutil.which("verilator"), reason="no Verilator; `scripts/setup.sh verilator` installs it"),
]


def soc_of(folder, out) -> tuple[SoCMini, GenericPlatform]:
    """A SoC whose only master is an AXI4-Lite port, and whose pins have the names of gc_system's."""
    n, host = load_machine(folder).n_axes, axi.AXILiteInterface(data_width=32, address_width=32)
    ports = {name: Pins(bits * n or 1) for name, bits in {**INPUTS, **OUTPUTS}.items()}
    ports |= {name: Pins(1) for name in ("s_axi_aclk", "s_axi_aresetn", "clk", "irq")}
    platform = GenericPlatform(
        "simulated", [*host.get_ios("s_axi"), *((name, 0, pins) for name, pins in ports.items())]
    )
    soc = SoCMini(platform, clk_freq=CLOCK_HZ, ident=IDENT, ident_version=False)
    soc.cd_sys, soc.cd_gravcomp = ClockDomain("sys"), ClockDomain("gravcomp", reset_less=True)
    soc.comb += [
        soc.cd_sys.clk.eq(platform.request("s_axi_aclk")),
        soc.cd_sys.rst.eq(~platform.request("s_axi_aresetn")),
        soc.cd_gravcomp.clk.eq(platform.request("clk")),
        *host.connect_to_pads(platform.request("s_axi"), mode="slave"),
    ]
    soc.bus.add_master("host", host)
    core = GravcompSystem(platform, folder, CLOCK_HZ, out, generics=generics(folder))
    add_gravcomp(soc, core, ORIGIN)
    names = [*INPUTS, *OUTPUTS]
    core.connect(
        SimpleNamespace(layout=[(name, 1) for name in names], **{name: platform.request(name) for name in names})
    )
    soc.comb += platform.request("irq").eq(core.ev.irq)
    return soc, platform


class SocWorld(World):
    """The robot at the pins of the SoC; registers of the core from ORIGIN on."""

    base = ORIGIN

    def _access(self, is_write: int, offset: int, word: int) -> int:
        return super()._access(is_write, self.base + offset, word)

    def csr(self, address: int) -> int:
        """A register of the SoC itself."""
        return super()._access(0, address, 0)


@pytest.fixture(scope="module")
def built():
    """Library of the SoC, its regions, machine folder."""
    out = BUILD / "tb" / "litex"
    folder = slow_machine(shipped("weights/slide"), out / "slide", STEP_CLOCKS)
    with (folder / ROBOT_TOML).open("a") as file:
        file.write(RANGE)
    assert main(["adopt", str(folder)]) == 0
    soc, platform = soc_of(folder, out)
    soc.finalize()
    with contextlib.chdir(out):  # LiteX writes what memories begin with into the folder it runs in
        platform.get_verilog(soc, name="gravcomp_soc").write("gravcomp_soc.v")
    return compiled([out / "gravcomp_soc.v", out / "gc_system.v"], "gravcomp_soc", out, 1), soc, folder


def test_the_driver_homes_moves_and_measures_through_the_soc(built, tmp_path):
    library, soc, folder = built
    machine = load_machine(folder)
    with contextlib.chdir(BUILD / "tb" / "litex"):  # memories are read from there
        world = SocWorld(library, machine)
    assert (
        bytes(world.csr(soc.csr.regions["identifier_mem"].origin + 4 * k) for k in range(len(IDENT))) == IDENT.encode()
    )
    limits = tmp_path / "limits.toml"
    limits.write_text(limits_toml(world))
    board = Board(world)
    campaign = Campaign(board, folder, load_limits(limits, folder), load_motion(limits, folder), tmp_path / "out", PLAN)
    home(world, campaign.home())
    steps = campaign.before()
    hold = next(steps)
    assert (world.port.released, world.port.enabled) == (1, 1)
    assert abs(world.port.position[0] - hold.pose[0]) < 100
    state, network = board.host.read(), load_folder(folder).network
    fixed = quantised(machine, network, folder)
    np.testing.assert_array_equal(state.force_mn, bittrue.core(np.array(state.position), fixed).force_mn)

    board.host.interrupts()  # those of before are over
    board.host.interrupt_on(Event.FAULT)
    status = soc.csr.regions["gravcomp"].origin
    assert world.csr(status) == 0
    world.wait(2300)  # the watchdog's time, 2 s, without a host
    assert (world.port.released, world.port.enabled) == (0, 0)
    assert world.csr(status) == 1
    steps.close()


def test_a_port_that_is_none_is_refused(built):
    _, soc, _ = built
    with pytest.raises(InputError, match=r"^pin_c: is no port of gc_system; give pin_a, "):
        soc.gravcomp.connect(SimpleNamespace(layout=[("pin_c", 1)], pin_c=None))
