"""gc_system and the robot in the physics engine, in one simulation.

The carriages move the encoders; currents and brakes of gc_system act on the carriages; the host reads the positions for
its PID over AXI4-Lite.
"""

import os
from collections.abc import Sequence
from pathlib import Path

import cocotb
import numpy as np
from cocotb.triggers import FallingEdge, Timer
from cocotb.utils import get_sim_time
from tqdm import tqdm

from gravcomp.core.formats import COUNT_BITS, CURRENT_BITS
from gravcomp.prototype.engine import TIME_STEP_S
from gravcomp.simulation.measured import hand_over
from gravcomp_lab.benches.bench import run_bench
from gravcomp_lab.benches.codes import pack, unpack
from gravcomp_lab.benches.system import ALL_FAULTS, BENCH_SOURCES, System
from gravcomp_lab.hil.plant import BrakedPrototype, Pid
from gravcomp_lab.hil.runs import SETS, Fault, Log, Run
from gravcomp_lab.shipped import shipped_machine

RUNS = SETS[os.environ.get("RUNS", "short")]
CLOCKS_PER_STEP = 150  # of a control period, which is a time step of the physics: the core at 150 kHz
CORE_MHZ = CLOCKS_PER_STEP / TIME_STEP_S / 1e6
AXI_MHZ = 0.97 * CORE_MHZ
STEP_FS = round(1e15 * TIME_STEP_S)
N_AXES = 3  # of the prototype
FEWEST_CLOCKS_PER_EDGE = 3  # one more than the limit speed of gc_quad_decoder, at which speed is a fault
READ_FS = STEP_FS // 2  # before the end of a period the host reads the positions
EDGES_CLOCKS = 20  # of a period, in which its edges come
INJECT_CLOCKS = 30  # after the start of a period
MOST_STEPS_TO_RELEASE, MOST_REACTION_CLOCKS = 100, 25
SETTINGS = {
    "tick_clocks": CLOCKS_PER_STEP,
    "period_min_clocks": 4 * FEWEST_CLOCKS_PER_EDGE,
    "current_limit_ua": 4_000_000,
    "current_slew_ua": 400_000,
    "saturation_clocks": 10 * CLOCKS_PER_STEP,
    "watchdog_clocks": 10 * CLOCKS_PER_STEP,
    "result_clocks": 3 * CLOCKS_PER_STEP,
    "brake_clocks": 3 * CLOCKS_PER_STEP,
    "command_bound_ua": 10_000,
    "command_clocks": 2 * CLOCKS_PER_STEP,
    "hold_clocks": 20 * CLOCKS_PER_STEP,
}


class HardwareLoop:
    """Physics and gc_system, a control period at a time."""

    def __init__(self, dut, run: Run):
        self.dut, self.run, self.drive = dut, run, shipped_machine().drive
        self.p = shipped_machine().robot.parameters
        self.system = System(dut)
        self.robot = BrakedPrototype(self.p, run.target_m(0.0, self.p), run.closing_s)
        self.pid = Pid()
        self.pid_n, self.core_n, self.is_released = np.zeros(N_AXES), np.zeros(N_AXES), np.zeros(N_AXES, bool)
        self.last_counts = self.counts()
        self.reaction_clocks = 0
        self.rows: list[tuple] = []

    def counts(self) -> np.ndarray:
        return self.drive.counts(self.robot.q_m)

    async def start(self) -> None:
        """Home, tick, enable, and step until the brakes open."""
        await self.system.start(AXI_MHZ, CORE_MHZ)
        await self.system.configure(**SETTINGS)
        await self.system.home_near(self.last_counts)
        write = self.system.registers.write
        await write("control", self.system.homing | 2)
        await write("command", 2)
        await self.system.clocks(3 * CLOCKS_PER_STEP)
        await write("fault", ALL_FAULTS)
        await self.system.wait_for_state("braked")
        await write("control", self.system.homing | 3)
        target_m, still_m = self.run.target_m(0.0, self.p), self.robot.q_m
        for _ in range(MOST_STEPS_TO_RELEASE):
            if self.is_released.all():
                assert (np.abs(self.robot.q_m - still_m) < self.drive.unit_per_count).all(), "moved against its brakes"
                return
            await self.step(target_m)
        raise AssertionError("the brakes do not open")

    async def step(self, target_m: np.ndarray, fault: Fault = Fault.NONE) -> None:
        """One control period: physics under the last forces, edges on the pins, a reading, new forces.

        target_m (3,): for the end of the physics' step, which is what is read.
        """
        ends_fs = round(get_sim_time("fs")) + STEP_FS
        self.robot.step(self.pid_n + self.core_n, self.is_released)
        self.move_encoders()
        if fault != Fault.NONE:
            await self.inject(fault)
        await Timer(ends_fs - READ_FS - round(get_sim_time("fs")), "fs")
        await self.system.registers.read("result_number")
        reading_m = self.drive.positions(np.array(await self.system.registers.read_axes("position_now")))
        await self.system.registers.write("command", 2)
        await Timer(ends_fs - round(get_sim_time("fs")), "fs")  # ValueError when the host was too slow
        self.take_commands(target_m - reading_m)

    def move_encoders(self) -> None:
        counts = self.counts()
        most = max(1, np.abs(counts - self.last_counts).max())
        self.dut.clocks_per_edge.value = max(FEWEST_CLOCKS_PER_EDGE, EDGES_CLOCKS // int(most))
        self.dut.target.value = pack(counts, COUNT_BITS)
        self.last_counts = counts

    def take_commands(self, error_m: np.ndarray) -> None:
        """New forces from the drives' pins and the PID, which rests while brakes are engaged or drives are off."""
        dut = self.dut
        current_ua = unpack([int(dut.drive_current.value)], CURRENT_BITS, N_AXES)[0]
        self.core_n = self.run.uses_core * current_ua / 1e6 * self.drive.effort_per_ampere
        self.is_released = np.array([int(dut.brake_release.value) >> i & 1 for i in range(N_AXES)], bool)
        if dut.drive_enable.value == 1 and self.is_released.all():
            assert dut.busy.value == 0, "the robot outruns its encoders"
            self.pid_n = self.pid.force_n(error_m)
        else:
            self.pid, self.pid_n = Pid(), np.zeros(N_AXES)

    async def inject(self, fault: Fault) -> None:
        """Cause a fault and count the clocks until the pins of the brakes fall."""
        await self.system.clocks(INJECT_CLOCKS)
        if fault == Fault.ESTOP:
            self.dut.estop_n.value = 0
        else:
            (scope,) = (child for child in self.dut if child._name == "g_encoder(0)")
            (encoder,) = scope
            (count,) = (signal for signal in encoder if signal._name == "count")
            count.value = count.value.to_signed() + 2  # a and b change at once
        while self.dut.brake_release.value != 0:
            assert self.reaction_clocks < MOST_REACTION_CLOCKS, "the brakes stay open"
            await FallingEdge(self.dut.clk)
            self.reaction_clocks += 1

    def record(self, t_s: float) -> None:
        target_m, is_released = self.run.target_m(t_s, self.p), bool(self.is_released.all())
        row = (t_s, target_m, self.robot.q_m, self.pid_n, self.core_n, is_released, self.robot.platform_radps)
        self.rows.append(row)

    def log(self) -> Log:
        return Log(*(np.array(column) for column in zip(*self.rows, strict=True)), self.reaction_clocks)


@cocotb.test()
@cocotb.parametrize(index=range(len(RUNS)))
async def closed_loop(dut, index):
    run = RUNS[index]
    loop, n_steps = HardwareLoop(dut, run), round(run.duration_s / TIME_STEP_S)
    await loop.start()
    with open(os.environ["PROGRESS"], "a") as terminal:
        for k in tqdm(range(n_steps), desc=run.name, file=terminal, unit="ms", disable=None):
            loop.record(k * TIME_STEP_S)
            is_fault = abs(k * TIME_STEP_S - run.fault_s) < TIME_STEP_S / 2
            target_m = run.target_m((k + 1) * TIME_STEP_S, loop.p)
            await loop.step(target_m, run.fault if is_fault else Fault.NONE)
    hand_over(**{run.name: vars(loop.log())})


def hil_run(runs: str, rtl: Path, build: Path) -> Sequence[tuple[Run, Log]]:
    """The runs of a set (gravcomp_lab.hil.runs.SETS) with one lane, simulated under GHDL with the ROM of the shipped
    machine.
    """
    environment = {"RUNS": runs, "PROGRESS": f"/proc/{os.getpid()}/fd/2"}  # its output goes to a log
    measured = run_bench("gc_system_bench", __name__, 1, rtl, build / f"hil-{runs}", environment, BENCH_SOURCES)
    return [(run, Log(**{name: np.array(values) for name, values in measured[run.name].items()})) for run in SETS[runs]]
