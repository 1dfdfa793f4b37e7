"""Every cause is seen present in every state, on every axis where it has one, or is proven to be absent there."""

import json
import re
from itertools import product

import cocotb
import numpy as np

from codes import ROOT, fixed_network
from gravcomp.files import write_atomically
from gravcomp.twin.safety import Cause, State
from runner import BUILD, simulate
from support.safety import ENABLED, GUARDED, LIMITS, ONSET, present_it, quiet_inputs, run_and_compare

N_CLOCKS = 240
CELLS = BUILD / "cells" / "safety.json"
# A cause that is absent in a state: an assertion of this name.
ABSENT = re.compile(r"^ *(\w+)_is_absent_in_(\w+) : assert", re.MULTILINE)


def absent_cells() -> set[tuple[Cause, State]]:
    """Cells that cannot be reached, as tb/formal/safety.sv proves."""
    found = ABSENT.findall((ROOT / "tb" / "formal" / "safety.sv").read_text())
    return {(Cause[cause.upper()], State[state.upper()]) for cause, state in found}


def axes_of(cause: Cause) -> range:
    """The axes on which a cause can happen; one place for a cause that has none."""
    quiet, hit = quiet_inputs(N_CLOCKS), quiet_inputs(N_CLOCKS)
    present_it(hit, cause, slice(ONSET, ONSET + 1), 0)
    changed = [hit[name] for name in hit if not np.array_equal(hit[name], quiet[name])]
    # A pulse that is not due in this clock is not missed either.
    return range(fixed_network().n_axes if changed and changed[0].ndim == 2 else 1)


def scenarios(cause: Cause, state: State, axis: int):
    """Inputs in which the cause comes in the state; where that takes a coincidence, one clock after the other."""
    limit = LIMITS.get(cause, 0)
    for shift in range(-4, 5):
        inputs = quiet_inputs(N_CLOCKS)
        clocks = slice(ONSET, ONSET + limit + 5)
        if state == State.HOLDING:
            clocks = slice(ENABLED + 3, N_CLOCKS)
            inputs["in_reached"][:] = 0
        if state != State.BRAKED:
            inputs["enable"][ENABLED:] = 1
        if state == State.FAULT:
            inputs["in_rom_bad" if cause == Cause.CRC else "in_crc_bad"][ONSET - 30 : ONSET - 20] = 1
        present_it(inputs, cause, clocks, axis)
        yield inputs
        # What ends with the state that it comes from: that state is left in the clock in which the limit is passed.
        coincident = quiet_inputs(N_CLOCKS)
        coincident["enable"][ENABLED:] = 1
        coming = ENABLED if cause == Cause.HOLD else ONSET
        if state == State.HOLDING:
            coincident["enable"][ONSET + limit + shift :] = 0
        if state == State.FAULT:
            coincident["in_crc_bad"][coming + limit + shift :] = 1
        present_it(coincident, cause, slice(coming, N_CLOCKS), axis)
        yield coincident


@cocotb.test()
@cocotb.parametrize(cause=list(Cause))
async def is_seen_in_every_state(dut, cause):
    seen = {}
    for state, axis in product(State, axes_of(cause)):
        if (cause, state) in absent_cells():
            continue
        for inputs in scenarios(cause, state, axis):
            got = await run_and_compare(dut, inputs)
            if clocks := int(((got["sts_present"] & cause.mask != 0) & (got["sts_state"] == state)).sum()):
                seen.setdefault(state.name, []).append(axis)
                cocotb.log.info("%s in %s on axis %d: %d clocks", cause.name, state.name, axis, clocks)
                break
        else:
            raise AssertionError(f"{cause.name} was never seen in {state.name} on axis {axis}")
    write_atomically(CELLS.with_name(f"{cause.name.lower()}.json"), json.dumps(seen))


def test_every_cell_is_reached_or_proven_absent():
    simulate("gc_safety", "test_rtl_safety_cells", generics={"sync_stages_g": 2, **GUARDED})
    n_axes = fixed_network().n_axes
    for cause in Cause:
        seen = json.loads(CELLS.with_name(f"{cause.name.lower()}.json").read_text())
        reachable = {state.name for state in State if (cause, state) not in absent_cells()}
        assert set(seen) == reachable, cause.name
        assert {len(axes) for axes in seen.values()} <= {1, n_axes}, cause.name
