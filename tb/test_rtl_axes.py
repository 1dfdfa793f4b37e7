"""The whole system of 1, 2, 6 and 7 axes, sized by `make rom` alone: by the tests of three axes, and by the drivers."""

import os
import re
from dataclasses import replace
from pathlib import Path

import cocotb
import numpy as np
import pytest
from cocotb.task import bridge

from axes import N_AXES, N_HIDDEN, divisors, machine_of
from c_host import CHost, compile_host
from codes import fixed_compensation, fixed_network, unpack, weights_under_test
from gravcomp.core.compensator_tables import FixedCompensation
from gravcomp.core.formats import COUNT_BITS, CURRENT_BITS, FORCE_BITS, FixedNetwork
from gravcomp.core.image import load_image
from gravcomp.core.machine_header import MACHINE_HEADER_FILE
from gravcomp.driver.host import Brakes, Host, Result, Settings, State, machine_settings
from gravcomp.network.weights import load_network
from gravcomp.robot.machine import load_machine
from gravcomp.twin import network as bittrue
from gravcomp.twin.compensator import compensator
from gravcomp_lab.benches.axi import SimulatedBus
from gravcomp_lab.benches.budget import APART
from gravcomp_lab.benches.force_path import BENCH_SOURCES as PATH_SOURCES
from gravcomp_lab.benches.force_path import Bench
from gravcomp_lab.benches.system import BENCH_SOURCES, System, near_the_middle
from gravcomp_lab.paper.operations import count_network_operations
from loading import LOAD_PORTS
from machines import machine_folder
from runner import BUILD, simulate
from support.ghdl import walks_the_hierarchy
from test_rtl_core import check_core
from test_rtl_host import Robot, settled, unnumbered

POLLS = 400
STILL = 2**31 - 1  # speed_period at rest
SPEED_TIMEOUT = 100  # clocks to standstill
SIZES = pytest.mark.parametrize("name", N_AXES)


def settings(axes: int, index: np.ndarray) -> Settings:
    """Limits that nothing here exceeds, of each axis another."""
    return Settings(
        **machine_settings(weights_under_test()),
        index_position=tuple(index.tolist()),
        index_period=(0,) * axes,
        margin_counts=tuple(range(100, 100 + axes)),
        speed_max_counts_per_s=tuple(15_000_000 - 1000 * axis for axis in range(axes)),
        current_limit_ua=tuple(2**31 - 1 - axis for axis in range(axes)),
        current_slew_ua=tuple(2**31 - 1 - axis for axis in range(axes)),
        command_bound_ua=tuple(1000 + axis for axis in range(axes)),
        tick_us=5,
        saturation_us=200,
        watchdog_us=200,
        result_us=200,
        brake_us=1,
        command_us=10,
        hold_us=100,
    )


def session(host: Host | CHost, robot: Robot, index: np.ndarray) -> list:
    """What a host does with a core; returns what it was told."""
    opened, identity = host.open()
    axes, all_axes = identity.axes, (1 << identity.axes) - 1
    own = settings(axes, index)
    other = replace(own, axes=axes + 1)
    answers = [opened, identity, host.configure(identity, other), host.complaint(identity, other)]
    answers += [host.configure(identity, own), host.home(all_axes)]
    robot.load()
    robot.walk_to(index)
    robot.wait(2 * SPEED_TIMEOUT)
    host.start()
    answers += [host.wait(0, POLLS), host.read()]
    answers += [host.tick(True), host.release(POLLS), settled(host)]
    robot.stop(True)
    answers += [unnumbered(host.read()), host.stop(), host.tick(False)]
    return answers


class RobotNear(Robot):
    """Its indices are near the middle of the trained range."""

    async def _load(self) -> None:
        await self.system.put_before(self.system.near)
        await self.system.clocks(60)


@cocotb.test()
async def drivers(dut):
    """In C and in Python: the same answers, and the right ones on every axis."""
    answers = {}
    for name in ("C", "Python"):
        system = System(dut)
        await system.start(axi_mhz=100)
        bus = SimulatedBus(system.registers)
        host = CHost(Path(os.environ["LIBRARY"]), bus) if name == "C" else Host(bus)
        answers[name] = await bridge(session)(host, RobotNear(system), system.near)
    assert answers["C"] == answers["Python"]
    check(answers["C"], system)


def check(answers: list, system: System) -> None:
    results = [answer for answer in answers if isinstance(answer, Result)]
    ok = Result.OK
    assert results == [ok, Result.WRONG_AXES, ok, ok, ok, ok, ok, ok, ok]
    (complaint,) = (answer for answer in answers if isinstance(answer, str))
    assert complaint.startswith("axes: not those of the core; ")
    identity, rom, running, stopped = answers[1], *(a for a in answers if isinstance(a, State))
    assert (identity.axes, identity.hidden) == (system.n_axes, fixed_network().n_hidden)
    for ends in ("low", "high"):
        assert getattr(identity, f"trained_{ends}") == tuple(getattr(fixed_network(), f"count_{ends}").tolist())
    for state in (rom, running):
        assert state.position == tuple(system.near.tolist())
        force_mn, current_ua = at_rest(system.near, fixed_network(), fixed_compensation())
        np.testing.assert_array_equal(state.force_mn, force_mn)
        np.testing.assert_array_equal(state.current_ua, current_ua)
    assert rom.referenced == system.all_axes
    assert (running.brakes, running.released, running.reached) == (Brakes.RUN, system.all_axes, system.all_axes)
    assert (running.command_ua, running.fault) == (running.current_ua, 0)
    assert (stopped.brakes, stopped.released, stopped.fault & 1) == (Brakes.FAULTED, 0, 1)
    assert stopped.first_position == tuple(system.near.tolist())
    assert stopped.command_ua == (0,) * system.n_axes


def at_rest(count: np.ndarray, network: FixedNetwork, compensation: FixedCompensation) -> tuple[np.ndarray, np.ndarray]:
    """Efforts and currents (n,) with the axes at these counts."""
    core_mn = bittrue.core(count, network).force_mn
    force_mn, _ = compensator(core_mn, count, np.full(len(count), STILL), compensation)
    return force_mn, bittrue.current_scaler(force_mn, network)


@cocotb.test()
async def image(dut):
    """All words of an image, then the ROM again: the efforts and currents of every axis are those of what is in use."""
    other = load_image(Path(os.environ["OTHER"]), weights_under_test())
    bench, count = Bench(dut), near_the_middle()
    for name in (*LOAD_PORTS, "load_rom"):
        getattr(dut, name).value = 0
    await bench.start()
    await bench.home_near(count)
    await bench.clocks(2 * SPEED_TIMEOUT)
    rom = fixed_network(), fixed_compensation()
    await holds(bench, *rom)
    await pulse(bench, load_begin=1)
    for word in other.words:
        dut.load_valid.value, dut.load_word.value = 1, int(word)
        await bench.clocks(1)
    dut.load_valid.value = 0
    await pulse(bench, load_commit=1, load_crc=other.crc32)
    await holds(bench, other.network, other.compensation)
    await pulse(bench, load_rom=1)
    await holds(bench, *rom)


async def pulse(bench: Bench, **ports: int) -> None:
    for name, value in ports.items():
        getattr(bench.dut, name).value = value
    await bench.clocks(1)
    for name in ports:
        getattr(bench.dut, name).value = 0
    await bench.clocks(40)


async def holds(bench: Bench, network: FixedNetwork, compensation: FixedCompensation) -> None:
    count, _, force, current, *_ = await bench.infer()
    count = unpack([count], COUNT_BITS, network.n_axes)[0]
    np.testing.assert_array_equal(count, near_the_middle())
    force_mn, current_ua = at_rest(count, network, compensation)
    np.testing.assert_array_equal(unpack([force], FORCE_BITS, network.n_axes)[0], force_mn)
    np.testing.assert_array_equal(unpack([current], CURRENT_BITS, network.n_axes)[0], current_ua)


def other_folder(folder: Path, out: Path) -> Path:
    """The machine with smaller weights, as fit the formats of its ROM."""
    network = load_network(folder)
    rng = np.random.default_rng(71)
    shrunk = {
        name: getattr(network, name) * rng.uniform(0.7, 0.95, getattr(network, name).shape)
        for name in ("hidden_weights", "hidden_bias", "output_weights", "output_bias")
    }
    machine = load_machine(folder)
    for name, data in machine.contents(out / "robot.toml").items():
        name.parent.mkdir(parents=True, exist_ok=True)
        name.write_bytes(data if isinstance(data, bytes) else data.encode())
    if (folder / "compensation.csv").exists():
        (out / "compensation.csv").write_bytes((folder / "compensation.csv").read_bytes())
    return machine_folder(out, replace(network, **shrunk), (out / "robot.toml").read_text())


def simulate_machine(entity: str, module: str, name: str, tests: str, lanes: int | None = None, **more) -> dict:
    folder, generated = machine_of(name)
    environment = {"WEIGHTS": str(folder), **more.pop("environment", {})}
    generics = {**({"lanes_g": lanes} if lanes else {}), **more.pop("generics", {})}
    return simulate(
        entity,
        module,
        tests=tests,
        label=name,
        generics=generics,
        environment=environment,
        generated=generated,
        extra_sources={"gc_system_bench": BENCH_SOURCES, "gc_force_path_bench": PATH_SOURCES}.get(entity, ()),
    )


@pytest.mark.slow
@SIZES
def test_drivers_in_c_and_python_hold_every_number_of_axes(name):
    _, generated = machine_of(name)
    library = compile_host(BUILD / "axes" / name, machine=generated)
    environment = {"LIBRARY": str(library)}
    simulate_machine(
        "gc_system_bench",
        "test_rtl_axes",
        name,
        r"\.drivers$",
        4,
        environment=environment,
        generics={"speed_timeout_g": SPEED_TIMEOUT},
    )


@pytest.mark.slow
@SIZES
def test_an_image_replaces_the_constants_of_every_axis(name):
    folder, _ = machine_of(name)
    other = other_folder(folder, BUILD / "axes" / name / "other")
    environment, generics = {"OTHER": str(other)}, {"loadable_g": "true"}
    simulate_machine(
        "gc_force_path_bench", "test_rtl_axes", name, r"\.image$", 1, environment=environment, generics=generics
    )


@pytest.mark.slow
@SIZES
def test_registers_follow_the_map_of_every_number_of_axes(name):
    simulate_machine("gc_system_bench", "test_rtl_system", name, r"\.(register_map|addresses_without_a_register)$", 1)


@pytest.mark.slow
@SIZES
def test_every_axis_has_its_causes_in_the_system(name):
    simulate_machine("gc_system_bench", "test_rtl_system", name, r"\.(every_limit_has_its_cause|brakes_and_faults)$", 1)


@pytest.mark.slow
@SIZES
def test_safety_equals_its_twin_with_every_number_of_axes(name):
    guarded = {"two_paths_g": "true", "brake_feedback_g": "true", "guard_g": "true", "sync_stages_g": 2}
    tests = "reacts_to_a_cause|own_speed_limit|limit_switches|random_causes"
    simulate_machine("gc_safety", "test_rtl_safety", name, tests, generics=guarded)


@SIZES
def test_drive_equals_its_twin_with_every_number_of_axes(name):
    simulate_machine("gc_drive", "test_rtl_drive", name, "own_limits|reached_is|random_results")


@pytest.mark.slow
@pytest.mark.parametrize(("name", "lanes"), [(name, lanes) for name in N_AXES for lanes in divisors(name)])
def test_core_equals_its_model_at_each_number_of_lanes(name, lanes):
    """Forces, interval and latency."""
    folder, generated = machine_of(name)
    environment = {"WEIGHTS": str(folder)}
    check_core(lanes, environment=environment, generated=generated, label=name, tests=r"\.back_to_back$")


@walks_the_hierarchy
@SIZES
def test_core_runs_the_operations_of_the_formula(name):
    """p inputs, n neurons, m outputs: p + pn + 2n + nm + m multiplications and 2n + m sums, counted in the VHDL.

    Those of sines and cosines are counted apart.
    """
    network = load_network(machine_of(name)[0])
    p, n, m = network.hidden_weights.shape[1], network.n_hidden, network.n_axes
    rows = simulate_machine("gc_core", "gravcomp_lab.benches.budget", name, "one_inference", 1)["operations"]
    kinds = ("multiplications", "sums")
    counted = {kind: sum(k for own, layer, k in rows if own == kind and layer not in APART) for kind in kinds}
    assert (n, m) == (N_HIDDEN[name], N_AXES[name])
    assert counted == {"multiplications": p + p * n + 2 * n + n * m + m, "sums": 2 * n + m}
    twin, _ = count_network_operations(network)
    assert counted == {"multiplications": twin.multiplications, "sums": twin.sums}


@SIZES
def test_header_of_a_machine_tells_its_axes(name):
    folder, generated = machine_of(name)
    header = (generated / MACHINE_HEADER_FILE).read_text()
    assert int(re.search(r"MACHINE_AXES (\d+)", header)[1]) == N_AXES[name] == machine_settings(folder)["axes"]
