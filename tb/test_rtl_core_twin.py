"""gc_system with two cores behaves as with one. What a difference of the two does: tb/test_rtl_inject.py."""

import pytest

from runner import BENCHES, simulate
from test_rtl_guards import host_clock_that_stops_engages_the_brakes  # noqa: F401, cocotb finds them here
from test_rtl_system import brakes_and_faults, emergency_stop_needs_no_host  # noqa: F401


@pytest.mark.slow
@pytest.mark.parametrize("test", ["brakes_and_faults", "host_clock_that_stops_engages_the_brakes/mhz=0"])
def test_two_cores_behave_as_one(test):
    simulate(
        "gc_system_bench",
        "test_rtl_core_twin",
        tests=test,
        label=test,
        generics={"lanes_g": 1, "loadable_g": "false", "twin_g": "true"},
        extra_sources=tuple(BENCHES / f"{name}.vhd" for name in ("gc_encoder_model", "gc_system_bench")),
    )
