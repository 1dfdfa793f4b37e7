"""gc_core as Verilog and as netlists passes the tests of tb/test_rtl_core.py, bit for bit, under Icarus."""

from pathlib import Path

import pytest

from support.core import check_core
from support.netlists import ghdl_verilog, netlist
from test_rtl_core import (  # noqa: F401, cocotb finds them here
    back_to_back,
    random_gaps,
    ready_at_its_interval,
    reset_in_mid_stream,
)


def run(lanes: int, kind: str, verilog: list[Path], **environment: str) -> None:
    check_core(lanes, module="test_rtl_gates", label=kind, verilog=verilog, environment=environment)


@pytest.mark.parametrize("lanes", [1, 4, pytest.param(20, marks=[pytest.mark.slow, pytest.mark.gatesim])])
def test_core_as_verilog_of_ghdl_equals_model(lanes):
    run(lanes, "ghdl", [ghdl_verilog(lanes)])


@pytest.mark.slow
@pytest.mark.gatesim
@pytest.mark.parametrize("lanes", [1, 4])
@pytest.mark.parametrize("target", ["generic", "ecp5"])
def test_core_as_netlist_equals_model(target, lanes):
    run(lanes, target, netlist(lanes, target), POSES="20")
