"""Settings that the core cannot keep are refused by both drivers, before anything is written."""

import re
from dataclasses import replace

import pytest

from c_host import CHost, compile_host
from gravcomp.core.machine_header import MACHINE_HEADER_FILE
from gravcomp.core.vhdl.network_package import write_rom
from gravcomp.driver.host import STATE_WORDS, Host, Result, machine_settings
from gravcomp.driver.registers import read_registers
from machines import MACHINE, SHIPPED, changed, machine_folder
from support.host import SETTINGS

CLOCK_HZ, FILTER_SAMPLES = int(MACHINE.clock_hz), 4
FASTEST = 4 * CLOCK_HZ // (2 * FILTER_SAMPLES + 1)  # counts/s: a limit of one clock more than the shortest period


class Memory:
    """A bus whose registers hold what is written to them."""

    def __init__(self):
        registers = read_registers()
        self.words = {registers[name].address: registers[name].reset for name in ("id", "version")}
        self.words[registers["geometry"].address] = MACHINE.n_axes << registers["geometry"].fields["outputs"][0]
        self.words[registers["clock_hz"].address] = CLOCK_HZ
        self.words[registers["encoder_geometry"].address] = FILTER_SAMPLES
        self.period_min = registers["period_min_clocks"].address
        self.written = {}

    def read(self, offset: int) -> int:
        return self.words.get(offset, 0)

    def write(self, offset: int, word: int) -> None:
        self.written[offset] = word


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    return compile_host(tmp_path_factory.mktemp("host"))


@pytest.mark.parametrize("driver", ["C", "Python"])
def test_a_speed_that_cannot_be_measured_is_refused(driver, library):
    bus = Memory()
    host = CHost(library, bus) if driver == "C" else Host(bus)
    result, identity = host.open()
    assert (result, identity.filter_samples) == (Result.OK, FILTER_SAMPLES)
    for speed in (FASTEST + 1_000_000, 2**32 - 1):
        settings = replace(SETTINGS, speed_max_counts_per_s=(0, speed, 0))
        assert host.configure(identity, settings) == Result.TOO_FAST
    assert host.configure(identity, replace(SETTINGS, index_period=(0, 4000, 402))) == Result.BAD_PERIOD
    assert not bus.written
    for speed, clocks in ((FASTEST, 2 * FILTER_SAMPLES + 1), (1, 160_000_000), (0, 0)):
        assert host.configure(identity, replace(SETTINGS, speed_max_counts_per_s=(0, speed, 0))) == Result.OK
        assert [bus.written[bus.period_min + 4 * axis] for axis in range(3)] == [0, clocks, 0]


@pytest.mark.parametrize("driver", ["C", "Python"])
def test_a_core_of_another_clock_is_refused(driver, library, tmp_path):
    """Its friction would be 2.5 times that of the machine."""
    folder = machine_folder(tmp_path / "fast", text=changed(("clock_hz = 40e6", "clock_hz = 100e6")))
    bus = Memory()
    host = CHost(library, bus) if driver == "C" else Host(bus)
    _, identity = host.open()
    other, own = (replace(SETTINGS, **machine_settings(name)) for name in (folder, SHIPPED))
    assert (other.clock_hz, own.clock_hz) == (100_000_000, identity.clock_hz)
    assert host.configure(identity, other) == Result.WRONG_CLOCK
    assert host.complaint(identity, other).startswith("clock_hz: not that of the core; ")
    assert not bus.written
    assert host.configure(identity, own) == Result.OK


def test_header_of_a_machine_tells_a_c_driver_what_its_folder_tells_a_python_one(tmp_path):
    folder = machine_folder(tmp_path / "fast", text=changed(("clock_hz = 40e6", "clock_hz = 100e6")))
    write_rom(folder, tmp_path)
    header = (tmp_path / MACHINE_HEADER_FILE).read_text()
    defined = dict(re.findall(r"#define GRAVCOMP_MACHINE_(\w+) (\w+?)u?\b", header))
    told = machine_settings(folder)
    assert int(defined["AXES"]) == told["axes"] == 3
    assert int(defined["CLOCK_HZ"]) == told["clock_hz"] == 100_000_000
    assert int(defined["WEIGHTS"], 16) == told["expected_weights"]


def test_words_of_a_state_lie_side_by_side():
    """They are read as one run, the first of which freezes the others."""
    addresses = [read_registers()[name].address for name in STATE_WORDS]
    assert addresses == list(range(addresses[0], addresses[0] + 4 * len(addresses), 4))
