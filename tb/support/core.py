"""gc_core against the bit-true model: forces, flags, interval and latency."""

import os
from pathlib import Path
from unittest.mock import patch

import numpy as np

from arm import arm_toml
from axes import random_network
from codes import fixed_network, unpack
from gravcomp.core.cost import CoreCost
from gravcomp.core.formats import FORCE_BITS, FixedNetwork
from gravcomp.core.vhdl.network_package import write_rom
from gravcomp.robot.machine import ROBOT_TOML, load_machine
from gravcomp.twin import network as bittrue
from gravcomp_lab.benches.core import CoreRun, run_of
from machines import machine_folder
from runner import simulate


def assert_equal_to_model(recording, counts: np.ndarray) -> None:
    fixed = fixed_network()
    expected = bittrue.core(counts, fixed)
    n = fixed.n_axes
    np.testing.assert_array_equal(unpack(recording.outputs["out_force"], FORCE_BITS, n), expected.force_mn)
    np.testing.assert_array_equal(unpack(recording.outputs["out_clamped"], 1, n) != 0, expected.clamped)
    np.testing.assert_array_equal(unpack(recording.outputs["out_saturated"], 1, n) != 0, expected.saturated)


def assert_run_is_right(run: CoreRun, lanes: int) -> None:
    """Interval and latency are exactly those of the header; nothing is lost or invented; all equals the model."""
    fixed = fixed_network()
    expected = bittrue.core(run.count, fixed)
    for name in ("force_mn", "clamped", "saturated"):
        np.testing.assert_array_equal(getattr(run, name), getattr(expected, name))
    assert run.interval == interval(fixed, lanes)
    assert run.latency == core_latency(fixed, lanes)
    cost = CoreCost(fixed.n_hidden, fixed.n_inputs, fixed.n_axes, lanes, fixed.is_lean, fixed.is_serial)
    assert (cost.interval, cost.latency) == (run.interval, run.latency)


def interval(fixed: FixedNetwork, lanes: int) -> int:
    """Clocks from counts to the next counts, as the headers of gc_core and gc_core_serial have them."""
    return core_latency(fixed, lanes) if fixed.is_serial else lane_steps(fixed, lanes)


def lane_steps(fixed: FixedNetwork, lanes: int) -> int:
    """Clocks of the lanes for all neurons."""
    return -(-fixed.n_hidden // lanes)


def core_latency(fixed: FixedNetwork, lanes: int) -> int:
    """Clocks from counts to forces, as the headers of gc_core and gc_core_serial have them."""
    if fixed.is_serial:
        n, p = max(fixed.n_hidden, 6), max(fixed.n_inputs, 3)
        return (n + 1) * (p + 1) + n * fixed.n_axes + 5
    steps, n = lane_steps(fixed, lanes), fixed.n_axes
    is_once, is_serial = steps == 1, lanes == 1 and steps >= n
    trees = int(np.ceil(np.log2(fixed.n_inputs + 1))) + int(np.ceil(np.log2(lanes + is_once)))
    if fixed.is_lean:
        return 8 + steps + trees + (3 if is_once else 0)
    scaler = n if is_serial and n > 1 else 0  # a shared multiplier takes its clocks
    turns = int(fixed.is_turning.sum())
    wait = 11 + (turns if steps >= turns > 1 else 0) if turns else scaler
    extra = 3 if is_once else 2 if lanes == 1 else 0
    return 14 + steps + trees + extra + wait + scaler


def check_core(lanes: int, **options) -> None:
    """Simulate the core with all tests of test_rtl_core, or those of another module."""
    module = options.pop("module", "test_rtl_core")
    generics = {"lanes_g": lanes, **options.pop("generics", {})}
    with patch.dict(os.environ, options.get("environment", {})):  # the machine under test, for the model too
        assert_run_is_right(run_of(simulate("gc_core", module, generics=generics, **options)), lanes)


def drawn_machine(inputs: tuple[str, ...], n_hidden: int, folder: Path, form: str) -> tuple[Path, Path]:
    """A random network in folder, in a form, and a folder with its packages."""
    weights, generated = folder / "weights", folder / "generated"
    machine_folder(weights, random_network(inputs, n_hidden), arm_toml(len(inputs), inputs=inputs))
    (weights / ROBOT_TOML).write_text(load_machine(weights).with_form(form).text)
    write_rom(weights, generated)
    return weights, generated


def check_serial_core(weights: Path, generated: Path, label: str) -> None:
    """Simulate gc_core_serial with the tests of test_rtl_core: what holds for one lane holds for it."""
    environment = {"WEIGHTS": str(weights), "LANES_G": "1"}
    with patch.dict(os.environ, environment):
        options = {"environment": environment, "generated": generated, "label": label}
        assert_run_is_right(run_of(simulate("gc_core_serial", "test_rtl_core", **options)), 1)
