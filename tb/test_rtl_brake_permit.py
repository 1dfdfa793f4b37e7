"""gc_brake_permit equals its twin at every clock, and survives every contradiction of its flags."""

import re

import cocotb
import numpy as np
import pytest
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge

from gravcomp.twin.brakes import BrakePermit
from gravcomp_lab.synthesis.verilog import source_of
from playback import assert_equal, play
from runner import RTL, simulate

N_AXES = 3
ALL = (1 << N_AXES) - 1
INPUTS = ("rst", "enable", "clear", "in_fault", "in_healthy", "in_carried", "in_tested", "in_test", "cfg_brake_clocks")
OUTPUTS = ("faulty", "idle", "shut", "brake_engage")


def random_inputs(n_clocks: int, seed: int) -> dict[str, np.ndarray]:
    """Long levels, so that every state is reached, with rare faults and resets."""
    rng = np.random.default_rng(seed)
    cocotb.log.info("seed %d", seed)

    def level(share: float, length: int) -> np.ndarray:
        return (rng.random(n_clocks // length + 1) < share).astype(np.int64).repeat(length)[:n_clocks]

    inputs = {name: level(share, 1) for name, share in {"rst": 0.003, "clear": 0.2, "in_fault": 0.01}.items()}
    inputs |= {"enable": level(0.7, 17), "in_healthy": level(0.9, 3), "in_carried": level(0.95, 5)}
    inputs |= {"in_tested": level(0.7, 6), "in_test": rng.integers(0, ALL + 1, n_clocks)}
    inputs["rst"][0] = 1
    return inputs | {"cfg_brake_clocks": rng.integers(0, 9, n_clocks // 50 + 1).repeat(50)[:n_clocks]}


def twin(inputs: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    permit, out = BrakePermit(N_AXES), {name: [] for name in OUTPUTS}
    for row in zip(*(inputs[name].tolist() for name in INPUTS), strict=True):
        for name in OUTPUTS:
            out[name].append(int(getattr(permit, name)))
        permit.clock(*row)
    return {name: np.array(values) for name, values in out.items()}


@cocotb.test()
async def random_inputs_equal_twin(dut):
    inputs = random_inputs(6000, 61)
    got = await play(dut, inputs, OUTPUTS)
    got["brake_engage"] &= ALL
    expected = twin(inputs)
    assert_equal(got, expected)
    moving = (expected["idle"] == 0) & (expected["shut"] == 1)
    for share in (moving, expected["shut"] == 0, expected["faulty"] == 1):
        assert share.mean() > 0.05


def power_up(dut) -> None:
    for name in INPUTS:
        getattr(dut, name).value = 0
    dut.in_healthy.value = dut.in_carried.value = dut.in_tested.value = 1
    dut.enable.value = 1
    Clock(dut.clk, 10, "ns").start(start_high=False)


@cocotb.test()
async def enable_that_is_high_at_power_up_starts_nothing(dut):
    power_up(dut)
    for enable, idle in [(1, 1)] * 4 + [(0, 1), (1, 0)]:
        dut.enable.value = enable
        await RisingEdge(dut.clk)
        await FallingEdge(dut.clk)
        assert dut.idle.value == idle
        assert dut.brake_engage.value == ALL


@cocotb.test()
async def contradiction_leads_to_faulty(dut):
    power_up(dut)
    await RisingEdge(dut.clk)
    await FallingEdge(dut.clk)
    assert (dut.faulty.value, dut.idle.value, dut.shut.value) == (1, 1, 1)
    assert dut.brake_engage.value == ALL


def test_brake_permit_equals_twin():
    simulate("gc_brake_permit", "test_rtl_brake_permit", tests="equal_twin")


def test_brake_permit_needs_an_edge():
    simulate("gc_brake_permit", "test_rtl_brake_permit", tests="high_at_power_up")


@pytest.mark.parametrize("flags", ["010", "110", "100", "101"])
def test_brake_permit_survives_contradictions(flags, tmp_path):
    """faulty, idle, shut, as an upset leaves them: in a copy of the entity that powers up with them."""
    upset = source_of(RTL, "gc_brake_permit").read_text()
    for name, level in zip(("faulty", "idle", "shut"), flags, strict=True):
        upset, n = re.subn(rf"( {name} +: out +std_ulogic := )'[01]'", rf"\g<1>'{level}'", upset)
        assert n == 1
    copy = tmp_path / "gc_brake_permit.vhd"
    copy.write_text(upset)
    simulate("gc_brake_permit", "test_rtl_brake_permit", extra_sources=(copy,), tests="contradiction", label=flags)
