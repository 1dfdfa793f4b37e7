"""gc_current_scaler: currents through 1/K_t, bit-true, and within half a microampere and its constant's rounding; one
that does not fit saturates.
"""

import os

import cocotb
import numpy as np
import pytest

from arm import arm_toml
from axes import random_network
from codes import corners_and_random, fixed_network, pack, unpack, weights_under_test
from gravcomp.core.cost import current_scaler_clocks
from gravcomp.core.formats import CURRENT_BITS, FORCE_BITS
from gravcomp.core.vhdl.network_package import write_rom
from gravcomp.network.inputs import POSITION
from gravcomp.robot.machine import load_machine
from gravcomp.twin.network import current_saturates, current_scaler
from gravcomp_lab.benches.stream import after_resets, latencies, start, stream
from machines import machine_folder
from runner import simulate


def in_turn() -> int:
    """Axes that share a multiplier."""
    return int(os.environ["TURNS_G"])


def held() -> dict:
    """What gc_scale asks of its inputs then."""
    return {"spacing": in_turn(), "holds": True} if in_turn() > 1 else {}


@cocotb.test()
async def random_forces(dut):
    fixed, rng = fixed_network(), np.random.default_rng(7)
    force_mn = corners_and_random(FORCE_BITS, (400, fixed.n_axes), rng)
    await start(dut)
    inputs = [{"in_force": pack(row, FORCE_BITS)} for row in force_mn]
    got = await stream(dut, inputs, ["out_current", "out_saturated"], gap_probability=0.2, rng=rng, **held())
    current_ua = unpack(got.outputs["out_current"], CURRENT_BITS, fixed.n_axes)
    saturated = unpack(got.outputs["out_saturated"], 1, fixed.n_axes) != 0
    np.testing.assert_array_equal(current_ua, current_scaler(force_mn, fixed))
    np.testing.assert_array_equal(saturated, current_saturates(force_mn, fixed))
    assert latencies(got) == {current_scaler_clocks(in_turn())}
    drive = load_machine(weights_under_test()).drive
    exact_ua = force_mn * 1000.0 / drive.effort_per_ampere
    constant_error = 0.5 / fixed.current_scale  # the factor is rounded to its last bit
    assert (np.abs(current_ua - exact_ua) <= 0.5 + np.abs(exact_ua) * constant_error)[~saturated].all()
    assert saturated.any(axis=0).tolist() == (drive.effort_per_ampere < 3.9).tolist()


@cocotb.test()
async def reset_in_mid_stream(dut):
    fixed = fixed_network()
    force_mn = 1000 * np.arange(1, 3 * fixed.n_axes + 1).reshape(3, fixed.n_axes)
    inputs = [{"in_force": pack(row, FORCE_BITS)} for row in force_mn]
    await start(dut)
    for got in await after_resets(dut, inputs, ["out_current"], range(1, 6), flush_clocks=16, **held()):
        current_ua = unpack(got.outputs["out_current"], CURRENT_BITS, fixed.n_axes)
        np.testing.assert_array_equal(current_ua, current_scaler(force_mn, fixed))


@pytest.mark.parametrize("turns", [1, 3])
def test_current_scaler_equals_model(turns):
    simulate("gc_current_scaler", "test_rtl_current_scaler", generics={"turns_g": turns})


@pytest.mark.parametrize("turns", [1, 2, 4])
def test_current_scaler_of_unlike_drives_saturates_where_a_current_does_not_fit(turns, tmp_path):
    """0.05 Nm/A beside 45 Nm/A: each has a fraction of its own; with two of four axes in turn, two multipliers."""
    folder, text = tmp_path / "weights", arm_toml(4)
    for usual, other in (("40.0", "0.05"), ("20.0", "45.0")):
        text = text.replace(f"effort_per_ampere = {usual}", f"effort_per_ampere = {other}")
    machine_folder(folder, random_network((POSITION,) * 4, 4), text)
    write_rom(folder, tmp_path / "generated")
    simulate(
        "gc_current_scaler",
        "test_rtl_current_scaler",
        environment={"WEIGHTS": str(folder)},
        generated=tmp_path / "generated",
        generics={"turns_g": turns},
        label="unlike",
    )
