"""gc_system with its servo and the robot in the physics engine, in one simulation.

What the RTL commands moves the robot, and how the robot moves is what the encoder pins tell the RTL. Python is the host
that homes, releases, sends the moves and kicks the watchdog.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
from tqdm import tqdm

from gravcomp.core.compensator_tables import quantise_compensation
from gravcomp.core.folder import load_folder
from gravcomp.core.formats import FixedNetwork
from gravcomp.core.image import image_words
from gravcomp.core.quantised import quantised
from gravcomp.driver.board import POLLS, Board, load_limits
from gravcomp.driver.host import Result
from gravcomp.driver.motion import Motion
from gravcomp.driver.moving import load_motion
from gravcomp.files import write_atomically
from gravcomp.prototype.engine import TIME_STEP_S
from gravcomp.robot.machine import Machine
from gravcomp_lab.cosim.blind import home
from gravcomp_lab.cosim.limits import limits_toml
from gravcomp_lab.hil.plant import BrakedWorld
from gravcomp_lab.hil.runs import SETS, Fault, Log, Run

KICK_STEPS = 50  # of a watchdog of two seconds
POLLS_TO_RELEASE, MOST_REACTION_CLOCKS = 3000, 25
MOST_FALL_M = 9.81 * (2 * TIME_STEP_S) ** 2 / 2  # until the host sees that the brakes are open, if nothing holds


def silent_image(folder: Path) -> bytes:
    """An image for the core of a machine folder whose network says nothing: its efforts are zero at every pose."""
    given, fixed = load_folder(folder), silent_network(folder)
    compensation = quantise_compensation(given.compensation, given.machine.drive, folder)
    return image_words(fixed, compensation).astype("<u4").tobytes()


def silent_network(folder: Path) -> FixedNetwork:
    """The network of a machine folder without weights in its output layer, in the formats of the core's own."""
    given = load_folder(folder)
    network, zeros = given.network, np.zeros(given.machine.n_axes)
    weights = np.zeros_like(network.output_weights)
    silent = replace(network, output_weights=weights, output_bias=zeros, f_offset=zeros)
    return quantised(given.machine, silent, folder, quantised(given.machine, network, folder))


class HardwareLoop:
    """A run: physics and RTL, a millisecond at a time, and what they did."""

    def __init__(self, run: Run, library: Path, folder: Path, machine: Machine):
        self.run, self.folder, self.machine, self.drive = run, folder, machine, machine.drive
        self.world = BrakedWorld(library, machine, run.closing_s)
        self.board = Board(self.world)
        self.motion = Motion(self.world, machine.n_axes)
        self.reaction_clocks = 0
        self.rows: list[tuple] = []

    def start(self, limits_path: Path) -> None:
        """Home, carry the robot to where the run begins, release, and wait until the brakes open."""
        write_atomically(limits_path, limits_toml(self.world))
        limits = load_limits(limits_path, self.folder)
        home(self.world, self.board.home(limits))
        if not self.run.uses_network:
            self.board.load(silent_image(self.folder))
        self.world.carry(self.drive.counts(self.run.target_m(0.0, self.machine)))
        self.world.wait(20)
        self.motion.configure(load_motion(limits_path, self.folder))
        self.board.configure(limits)
        still_m = self.world.q_m
        if self.board.host.release(POLLS_TO_RELEASE) != Result.OK:
            raise AssertionError(f"the brakes do not open: {self.board.host.read()}")
        if (np.abs(self.world.q_m - still_m) > MOST_FALL_M).any():
            raise AssertionError("moved against its brakes")

    def simulate(self, bar: tqdm) -> None:
        """All of the run, a row for each millisecond."""
        moves = sorted((*self.run.steps, self.run.move), key=lambda move: move.start_s)
        fault_step = round(self.run.fault_s / TIME_STEP_S) if np.isfinite(self.run.fault_s) else -1
        first = self.world.steps
        for k in range(round(self.run.duration_s / TIME_STEP_S)):
            if self.world.steps <= first + k:
                self.world.wait(1)
            self.record(k * TIME_STEP_S)
            if k % KICK_STEPS == 0:
                self.board.host.kick()
            if moves and k >= round(moves[0].start_s / TIME_STEP_S) and fault_step != k:
                self.begin(moves.pop(0).end_s)
            if k == fault_step:
                self.inject()
            bar.update()

    def begin(self, end_s: float) -> None:
        """Send the servo to where it shall be at end_s."""
        target = self.drive.counts(self.run.target_m(end_s, self.machine))
        now_s = self.rows[-1][0]
        if self.motion.move(tuple(target.tolist()), round((end_s - now_s) / TIME_STEP_S), POLLS) != Result.OK:
            raise AssertionError(f"a move to {target} is not taken")

    def inject(self) -> None:
        """Cause a fault and count the clocks until the pins of the brakes fall."""
        if self.run.fault == Fault.ESTOP:
            self.world.port.estop = 1
        else:
            self.world.port.jump[0] = 2  # a and b change at once
        while self.world.port.released:
            if self.reaction_clocks >= MOST_REACTION_CLOCKS:
                raise AssertionError("the brakes stay open")
            self.world.clock()
            self.reaction_clocks += 1

    def record(self, t_s: float) -> None:
        """What the servo wants and does, and what the robot does."""
        state = self.motion.read()
        per_ua = self.drive.effort_per_ampere / 1e6
        motor_n = self.world.plant.state.motor
        servo_n = np.array(state.correction_ua) * per_ua * bool(self.world.port.enabled)
        target_m = self.drive.positions(np.array(state.setpoint))
        is_released = bool(self.world.is_released.all())
        row = t_s, target_m, self.world.q_m, servo_n, motor_n - servo_n, is_released, self.world.speed
        self.rows.append(row)

    def log(self) -> Log:
        return Log(*(np.array(column) for column in zip(*self.rows, strict=True)), self.reaction_clocks)


def hil_run(runs: str, library: Path, folder: Path) -> list[tuple[Run, Log]]:
    """The runs of a set (gravcomp_lab.hil.runs.SETS) on the core in a library (gravcomp_lab.cosim.library.build) and
    the machine folder that it was built from. Limits are written beside the library.
    """
    machine, done = load_folder(folder).machine, []
    with tqdm(total=sum(round(run.duration_s / TIME_STEP_S) for run in SETS[runs]), unit="ms") as bar:
        for run in SETS[runs]:
            bar.set_description(run.name)
            loop = HardwareLoop(run, library, folder, machine)
            with loop.board:
                loop.start(library.with_suffix(".toml"))
                loop.simulate(bar)
            done.append((run, loop.log()))
    return done
