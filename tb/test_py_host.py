"""Settings that the core cannot keep are refused by both drivers, before anything is written."""

from dataclasses import replace

import pytest

from c_host import CHost, compile_host
from gravcomp.driver.host import Host, Result
from gravcomp.driver.registers import read_registers
from test_rtl_host import SETTINGS

CLOCK_HZ, FILTER_SAMPLES = 40_000_000, 4
FASTEST = 4 * CLOCK_HZ // (2 * FILTER_SAMPLES + 1)  # counts/s: a limit of one clock more than the shortest period


class Memory:
    """A bus whose registers hold what is written to them."""

    def __init__(self):
        registers = read_registers()
        self.words = {registers[name].address: registers[name].reset for name in ("id", "version")}
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
        settings = replace(SETTINGS, speed_max_counts_per_s=speed)
        assert host.configure(identity, settings) == Result.TOO_FAST
    assert host.configure(identity, replace(SETTINGS, index_period=(0, 4000, 402))) == Result.BAD_PERIOD
    assert not bus.written
    for speed, clocks in ((FASTEST, 2 * FILTER_SAMPLES + 1), (1, 160_000_000), (0, 0)):
        assert host.configure(identity, replace(SETTINGS, speed_max_counts_per_s=speed)) == Result.OK
        assert bus.written[bus.period_min] == clocks
