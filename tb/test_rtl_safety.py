"""gc_safety equals its twin on every clock; every cause is answered as docs/guide/safety.md says."""

import os
import re

import cocotb
import numpy as np

from codes import ROOT, fixed_network
from gravcomp.twin.brakes import State
from gravcomp.twin.safety import ALWAYS, Cause
from runner import RTL, simulate
from support.safety import (
    ALL,
    BRAKE,
    COMMAND,
    ENABLED,
    GUARDED,
    HOLD,
    LIMITS,
    ONSET,
    PERIOD_MIN,
    RESULT,
    RUNNING,
    SATURATION,
    SHORTEST,
    STILL,
    WATCHDOG,
    WHILE,
    position_window,
    present_it,
    quiet_inputs,
    run_and_compare,
)


def documented_clocks(cause: Cause) -> int:
    """The reaction of docs/guide/safety.md, with the limits of these tests and the synchroniser's stages."""
    row = re.search(
        rf"^\| {cause.name.lower()} \| {cause:d} \|.*$", (ROOT / "docs" / "guide" / "safety.md").read_text(), re.M
    )
    clocks, watched = (cell.strip() for cell in row.group().split("|")[4:6])
    assert (watched == "always") == bool(ALWAYS & cause.mask)
    extra_stages = int(os.environ["SYNC_STAGES_G"]) - 2 if cause in (Cause.ESTOP, Cause.BRAKE) else 0
    return LIMITS.get(cause, 0) + int(clocks.removeprefix("limit + ")) + extra_stages


@cocotb.test()
@cocotb.parametrize(cause=[cause for cause in Cause if cause not in WHILE])
async def reacts_to_a_cause(dut, cause):
    end, n_axes = 300, fixed_network().n_axes
    for axis in range(n_axes):
        inputs = quiet_inputs(420)
        inputs["enable"][ENABLED:370] = 1
        inputs["enable"][380:] = 1
        inputs["clear"][[200, 340]] = ALL
        inputs["clear"][[250, 330]] = cause.mask, ALL & ~cause.mask
        inputs["kick"][ONSET - 1] = inputs["in_result"][ONSET - 1] = 1
        present_it(inputs, cause, slice(ONSET, end), axis)
        got = await run_and_compare(dut, inputs)
        assert (got["sts_state"][RUNNING:ONSET] == State.RUN).all()
        reaction = int(np.flatnonzero(got["brake_release"][ONSET:] == 0)[0])
        assert reaction == documented_clocks(cause)
        stop = ONSET + reaction
        assert (got["run"][:stop][RUNNING:] == 1).all()
        assert not got["run"][stop:381].any()
        assert not got["brake_release"][stop:381].any()
        assert (got["sts_state"][stop:341] == State.FAULT).all(), "clear while the cause lasts does not help"
        assert (got["sts_first_cause"][stop:341] == cause.mask).all()
        assert (got["sts_fault"][stop:341] == cause.mask).all()
        assert (got["sts_first_count"][stop:] == inputs["in_count"][stop - 2]).all()
        assert (got["sts_state"][341:381] == State.BRAKED).all(), "only a new edge of enable starts"
        assert not got["sts_fault"][341:].any()
        assert got["sts_state"][-1] == State.RUN
    cocotb.log.info("%s: brakes engaged after %d clocks", cause.name.lower(), reaction)


@cocotb.test()
@cocotb.parametrize(cause=[cause for cause in Cause if cause not in WHILE])
async def causes_while_braked(dut, cause):
    """Some are faults, the others keep the brakes engaged; enable that rose meanwhile starts nothing later."""
    inputs = quiet_inputs(320)
    present_it(inputs, cause, slice(0, 200), 0)
    inputs["enable"][150:250] = 1
    inputs["enable"][260:] = 1
    inputs["clear"][230] = cause.mask
    got = await run_and_compare(dut, inputs)
    is_fault = bool(ALWAYS & cause.mask)
    assert (got["sts_state"][140:200] == (State.FAULT if is_fault else State.BRAKED)).all()
    assert (got["sts_present"][140:200] == cause.mask).all()
    assert not got["brake_release"][:261].any()
    assert not got["run"][:261].any()
    assert (got["sts_fault"][140:200] == cause.mask * is_fault).all()
    assert got["sts_state"][-1] == State.RUN


@cocotb.test()
async def values_at_the_limit_are_no_fault(dut):
    for axis in range(fixed_network().n_axes):
        inputs, sign = quiet_inputs(300), 1 - 2 * (axis % 2)
        inputs["enable"][ENABLED:] = 1
        inputs["in_period"][ONSET:, axis] = sign * PERIOD_MIN
        inputs["in_count"][ONSET:, axis] = position_window()[axis % 2][axis]
        inputs["kick"][ONSET + 1 : ONSET + 1 + WATCHDOG] = 0
        inputs["kick"][[ONSET, ONSET + 1 + WATCHDOG]] = 1
        inputs["in_result"][ONSET + 1 : ONSET + 1 + RESULT] = 0
        inputs["in_result"][[ONSET, ONSET + 1 + RESULT]] = 1
        inputs["in_saturated"][ONSET : ONSET + SATURATION, axis] = 1
        inputs["in_deviates"][ONSET : ONSET + COMMAND, axis] = 1
        got = await run_and_compare(dut, inputs)
        assert (got["sts_state"][RUNNING:] == State.RUN).all()


@cocotb.test()
@cocotb.parametrize(limit=[0, 1, 8, 9, 10])
async def no_speed_limit_switches_the_supervision_off(dut, limit):
    """0 allows no motion that can be measured; a limit that the decoder cannot measure is the lowest that it can."""
    for period in (8, 9, 10, -8, -9, STILL - 1, 1 - STILL, STILL):
        inputs = quiet_inputs(140)
        inputs["enable"][ENABLED:] = 1
        inputs["cfg_period_min"][:] = limit
        inputs["in_period"][ONSET:, -1] = period
        got = await run_and_compare(dut, inputs)
        assert (got["sts_state"][RUNNING:ONSET] == State.RUN).all()
        lowest = max(limit, SHORTEST + 1) if limit else STILL
        assert bool(got["brake_release"][-1]) == (abs(period) >= lowest), (limit, period)


@cocotb.test()
async def each_axis_has_its_own_speed_limit(dut):
    """What is too fast for one axis is slow enough for another."""
    n_axes = fixed_network().n_axes
    for axis in range(n_axes):
        inputs = quiet_inputs(140)
        inputs["enable"][ENABLED:] = 1
        inputs["cfg_period_min"][:, axis] = PERIOD_MIN // 2
        inputs["in_period"][ONSET:, axis] = PERIOD_MIN // 2
        got = await run_and_compare(dut, inputs)
        assert got["sts_state"][-1] == State.RUN
        inputs["cfg_period_min"][:, axis] = PERIOD_MIN // 2 + 1
        got = await run_and_compare(dut, inputs)
        assert got["sts_first_cause"][-1] == Cause.SPEED.mask


@cocotb.test()
async def a_command_that_deviates_for_too_long_ends_the_run(dut):
    for axis in range(fixed_network().n_axes):
        inputs = quiet_inputs(300)
        inputs["enable"][ENABLED:250] = 1
        inputs["clear"][200] = Cause.COMMAND.mask
        present_it(inputs, Cause.COMMAND, slice(ONSET, 300), axis)
        got = await run_and_compare(dut, inputs)
        stop = ONSET + documented_clocks(Cause.COMMAND)
        assert (got["sts_state"][RUNNING:stop] == State.RUN).all()
        assert not got["brake_release"][stop:].any()
        assert not got["run"][stop:].any()
        assert (got["sts_state"][stop:201] == State.FAULT).all()
        assert (got["sts_first_cause"][stop:201] == Cause.COMMAND.mask).all()
        assert (got["sts_first_count"][stop:201] == inputs["in_count"][stop - 2]).all()
        assert (got["sts_state"][201:] == State.BRAKED).all()


@cocotb.test()
async def a_command_may_deviate_while_the_brakes_are_engaged(dut):
    """It does while it ramps up, and after the run the brakes have the load already."""
    inputs = quiet_inputs(300)
    inputs["in_deviates"][:ENABLED] = inputs["in_deviates"][ENABLED : ENABLED + BRAKE] = 1
    inputs["enable"][ENABLED:ONSET] = 1
    inputs["in_deviates"][ONSET:] = 1
    got = await run_and_compare(dut, inputs)
    assert (got["sts_state"][RUNNING : ONSET + 1] == State.RUN).all()
    assert got["sts_state"][-1] == State.BRAKED
    assert not got["sts_fault"].any()


@cocotb.test()
@cocotb.parametrize(hold=[0, 1, BRAKE + 1, BRAKE + 2, HOLD])
async def holding_has_a_time_out(dut, hold):
    """Motors that never carry the load, or too late, end in FAULT, and the brakes stay engaged."""
    for axis in range(fixed_network().n_axes):
        for reached_at in (0, ENABLED + 20, 500):
            inputs = quiet_inputs(200)
            inputs["enable"][ENABLED:] = 1
            inputs["cfg_hold_clocks"][:] = hold
            present_it(inputs, Cause.HOLD, slice(0, reached_at), axis)
            got = await run_and_compare(dut, inputs)
            begins = ENABLED + 1
            in_time = max(reached_at, begins) + BRAKE + 2 <= begins + hold + 1
            if in_time:
                assert got["sts_state"][-1] == State.RUN
                assert not got["sts_fault"].any()
                continue
            stop = begins + documented_clocks(Cause.HOLD) - HOLD + hold
            assert not got["brake_release"].any()
            assert (got["sts_state"][begins:stop] == State.HOLDING).all()
            assert (got["sts_state"][stop:] == State.FAULT).all()
            assert (got["sts_first_cause"][stop:] == Cause.HOLD.mask).all()


@cocotb.test()
async def simultaneous_causes_are_first_together(dut):
    inputs = quiet_inputs(200)
    inputs["enable"][ENABLED:] = 1
    for cause in (Cause.CRC, Cause.SPEED, Cause.POSITION):
        present_it(inputs, cause, slice(ONSET, ONSET + 1), 1)
    present_it(inputs, Cause.ROM, slice(ONSET + 1, ONSET + 2), 0)
    got = await run_and_compare(dut, inputs)
    first = Cause.CRC.mask | Cause.SPEED.mask | Cause.POSITION.mask
    assert got["sts_first_cause"][-1] == first
    assert got["sts_fault"][-1] == first | Cause.ROM.mask
    assert (got["sts_first_count"][-1] == inputs["in_count"][ONSET]).all()


@cocotb.test()
async def faults_are_cleared_one_by_one(dut):
    """One whose cause lasts stays; the state is left with the last of them, and the first is kept until then."""
    inputs = quiet_inputs(400)
    inputs["enable"][ENABLED:] = 1
    present_it(inputs, Cause.SPEED, slice(ONSET, ONSET + 1), 0)
    present_it(inputs, Cause.CRC, slice(ONSET + 10, 220), 0)
    present_it(inputs, Cause.POSITION, slice(ONSET + 20, ONSET + 21), 0)
    speed, crc, position = Cause.SPEED.mask, Cause.CRC.mask, Cause.POSITION.mask
    written = {150: speed, 200: crc, 250: ALL & ~position, 300: 0, 350: position}
    left = {150: crc | position, 200: crc | position, 250: position, 300: position, 350: 0}
    for clock, mask in written.items():
        inputs["clear"][clock] = mask
    got = await run_and_compare(dut, inputs)
    for clock, faults in left.items():
        assert (got["sts_fault"][clock + 1 : clock + 50] == faults).all(), clock
    assert (got["sts_state"][ONSET + 2 : 351] == State.FAULT).all()
    assert (got["sts_first_cause"][ONSET + 2 : 351] == speed).all()
    assert (got["sts_state"][351:] == State.BRAKED).all()
    assert not got["sts_first_cause"][351:].any()
    assert (got["sts_first_count"][ONSET + 2 :] == inputs["in_count"][ONSET]).all()


@cocotb.test()
async def starts_with_enable_high_only_after_an_edge(dut):
    """Power-up and reset, in every state, end with brakes engaged, and a level of enable starts nothing."""
    for reset_at in (5, ENABLED + 3, 60):
        inputs = quiet_inputs(140)
        inputs["enable"][:] = reset_at == 5
        inputs["enable"][ENABLED:] = 1
        inputs["rst"][reset_at] = 1
        inputs["enable"][[100, 101]] = 0
        got = await run_and_compare(dut, inputs)
        assert not got["run"][reset_at + 1 : 102].any()
        assert not got["brake_release"][reset_at + 1 : 102].any()
        assert got["sts_state"][-1] == State.RUN


@cocotb.test()
async def nothing_starts_before_the_emergency_stop_is_known(dut):
    """An enable that rises while the synchroniser fills after reset starts nothing, pressed or not."""
    for estop_n in (0, 1):
        inputs = quiet_inputs(60)
        inputs["estop_n"][:] = estop_n
        inputs["enable"][1:] = 1
        got = await run_and_compare(dut, inputs)
        assert not got["run"].any()
        assert not got["brake_release"].any()


@cocotb.test()
async def brakes_open_when_the_motors_hold_and_close_before_they_let_go(dut):
    inputs = quiet_inputs(200)
    inputs["enable"][ENABLED:120] = 1
    inputs["in_reached"][:50, 1] = 0
    got = await run_and_compare(dut, inputs)
    run, released = np.flatnonzero(got["run"]), np.flatnonzero(got["brake_release"])
    assert run[0] == ENABLED + 1
    assert released[0] == 50 + BRAKE + 2
    assert released[-1] == 120
    assert run[-1] - released[-1] == BRAKE + 2
    assert len(run) == run[-1] - run[0] + 1
    assert len(released) == released[-1] - released[0] + 1


@cocotb.test()
@cocotb.parametrize(seed=[72, 73])
async def random_causes_and_commands(dut, seed):
    cocotb.log.info("seed %d", seed)
    got = await run_and_compare(dut, random_inputs(np.random.default_rng(seed), 8000))
    visits = {state.name: _rises(got["sts_state"] == state) for state in State}
    latched = {cause.name: _rises(got["sts_fault"] & cause.mask != 0) for cause in Cause}
    cocotb.log.info("entered %s, latched %s", visits, latched)
    assert min(visits.values()) >= 20
    assert min(latched.values()) >= 2


def _rises(level: np.ndarray) -> int:
    return int((np.diff(level.astype(int)) > 0).sum())


def random_inputs(rng: np.random.Generator, n_clocks: int) -> dict[str, np.ndarray]:
    """Quiet inputs with bursts of causes on random axes, random enable, clear, settled, resets and limits."""
    inputs = quiet_inputs(n_clocks)
    n_axes = inputs["in_count"].shape[1]
    low, high = position_window()
    inputs["in_count"] = np.where(rng.random((n_clocks, n_axes)) < 0.99, inputs["in_count"], rng.choice([low, high]))
    for cause in list(Cause) * (n_clocks // 500):
        start, length = int(rng.integers(n_clocks)), LIMITS.get(cause, 0) + int(rng.choice([1, 2, 5, 20]))
        present_it(inputs, cause, slice(start, start + length), int(rng.integers(n_axes)))
    inputs["enable"] = (np.cumsum(rng.random(n_clocks) < 0.03) % 2).astype(np.int64)
    inputs["clear"] = rng.integers(0, ALL + 1, n_clocks) | rng.choice([0, ALL], n_clocks)
    inputs["clear"][rng.random(n_clocks) < 0.9] = 0
    inputs["rst"] = (rng.random(n_clocks) < 0.0005).astype(np.int64)
    inputs["in_reached"] = (rng.random((n_clocks // 10, n_axes)) < 0.97).repeat(10, axis=0).astype(np.int64)
    inputs["in_deviates"] |= (rng.random((n_clocks // 40, n_axes)) < 0.1).repeat(40, axis=0)
    most = {"brake_clocks": 12, "saturation_clocks": 30, "command_clocks": 30, "hold_clocks": 60}
    for name, high in most.items():
        inputs[f"cfg_{name}"] = rng.integers(0, high, n_clocks // 200).repeat(200)
    inputs["cfg_period_min"] = rng.integers(0, 2 * PERIOD_MIN, (n_clocks // 200, n_axes)).repeat(200, axis=0)
    return inputs


def test_safety_equals_twin():
    simulate("gc_safety", "test_rtl_safety", generics={"sync_stages_g": 2, **GUARDED})


def test_safety_waits_for_its_synchroniser():
    simulate("gc_safety", "test_rtl_safety", generics={"sync_stages_g": 3, **GUARDED}, tests="ESTOP|after_an_edge")


def test_safety_codes_equal_package():
    text = (RTL / "registers" / "gc_facts_pkg.vhd").read_text()
    causes = {name.upper(): int(bit) for name, bit in re.findall(r"cause_(\w+)_c +: natural +:= (\d+)", text)}
    states = {name.upper(): int(code, 2) for name, code in re.findall(r'state_(\w+)_c +: \w+ := "(\d+)"', text)}
    assert causes == {cause.name: cause.value for cause in Cause}
    assert states == {state.name: state.value for state in State}
    assert re.search(r"causes_c +: positive := (\d+)", text).group(1) == str(len(Cause))
