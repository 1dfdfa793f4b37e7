"""gc_system and the robot in the physics engine, in one simulation: PID alone, with the core, and faults in mid-motion.

`make hil` runs longer.
"""

import pytest

from gravcomp_lab.hil.loop import hil_run
from gravcomp_lab.hil.runs import SHORT, STILL_RADPS, Fault, Log, Run, rms, stop_after
from runner import BUILD, RTL

LEAST_IMPROVEMENT = 100  # of the RMS error while holding; measured: 800 in the first 0.1 s
LARGEST_PID_SHARE = 0.05  # of the RMS force of the PID, with the core and alone; measured: 0.002
STOP_S = 0.010  # from the closing of the brakes until the platform is still; measured: 0.009 at most
REACTION_CLOCKS = {Fault.ESTOP: 3, Fault.ENCODER: 7 + 2}  # docs/guide/safety.md


def check_the_core_takes_the_load(pid: Log, core: Log) -> None:
    holding = pid.t_s < SHORT[0].hold_s
    improvement = rms(pid.error_m()[holding]) / rms(core.error_m()[holding])
    share = rms(core.pid_n) / rms(pid.pid_n)
    print(f"MEASURED holding, RMS error: {improvement:.0f} times with the PID alone; share of its force {share:.4f}")
    assert improvement > LEAST_IMPROVEMENT
    assert share < LARGEST_PID_SHARE


def check_stop(run: Run, log: Log) -> None:
    stop = stop_after(run, log)
    print(f"MEASURED {run.name}: {log.reaction_clocks} clocks, {stop}")
    assert log.reaction_clocks == REACTION_CLOCKS[run.fault]
    assert not log.is_released[-1]
    assert stop.speed_radps > 10 * STILL_RADPS, "not in motion when the fault came"
    assert stop.still_s <= run.closing_s + STOP_S
    assert not log.pid_n[-1].any()
    assert not log.core_n[-1].any()


@pytest.mark.slow
def test_hil_the_core_takes_the_load_and_faults_stop_the_robot():
    (_, pid), (_, core), *stopped = hil_run("short", RTL, BUILD)
    check_the_core_takes_the_load(pid, core)
    for run, log in stopped:
        check_stop(run, log)
