"""gc_brakes equals its twin at every clock with any of its options; one broken path opens no brake."""

import os

import cocotb
import numpy as np
import pytest
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

from gravcomp.twin.brakes import BrakeOptions, Brakes, State
from gravcomp_lab.synthesis.verilog import source_of
from playback import flush, play
from runner import RTL, simulate

N_AXES = 3
ALL = (1 << N_AXES) - 1
BRAKE, TEST = 6, 8
OUTPUTS = ("state", "run", "brake_release", "brake_engage", "sts_feedback", "wrong")
NARROW = {"state": 7, "run": 1, "wrong": 1}


def options() -> BrakeOptions:
    """Those of the entity under test."""
    named = {name: os.environ[f"{name.upper()}_G"] == "true" for name in ("two_paths", "feedback", "test")}
    return BrakeOptions(**named)


def driven(inputs: dict[str, np.ndarray], brake) -> tuple[dict, dict]:
    """Inputs and the twin's outputs; brake(told, clock): what the pins say one clock after brakes are told to open."""
    n_clocks, brakes, fed = len(inputs["enable"]), Brakes(N_AXES, options()), 0
    inputs = inputs | {"brake_fed": np.zeros(n_clocks, np.int64)}
    out = {name: np.zeros(n_clocks, np.int64) for name in OUTPUTS}
    names = ("rst", "enable", "clear", "in_fault", "in_healthy", "in_carried")
    names += ("brake_fed", "cfg_brake_clocks", "cfg_test_clocks")
    for k in range(n_clocks):
        inputs["brake_fed"][k] = fed
        out["state"][k], out["run"][k] = brakes.sequencer.state, brakes.sequencer.run
        out["brake_release"][k], out["brake_engage"][k] = brakes.brake_release, brakes.brake_engage
        out["sts_feedback"][k], out["wrong"][k] = brakes.feedback, brakes.wrong
        fed = brake(brakes.brake_release & ~brakes.brake_engage, k)
        inputs["in_fault"][k] |= out["wrong"][k]
        brakes.clock(*(int(inputs[name][k]) for name in names))
    return inputs, out


async def compare(dut, inputs: dict, expected: dict) -> None:
    await flush(dut, 4, **dict.fromkeys(inputs, 0) | {"rst": 1, "enable": 1})  # enable counts as high before
    got = await play(dut, inputs, OUTPUTS)
    for name in OUTPUTS:
        np.testing.assert_array_equal(got[name] & NARROW.get(name, ALL), expected[name], err_msg=name)


def move_at(n_clocks: int, start: int) -> dict[str, np.ndarray]:
    """The motors take the load at once, enable rises at start."""
    zero = np.zeros(n_clocks, np.int64)
    inputs = {name: zero.copy() for name in ("rst", "clear", "in_fault")}
    inputs |= {
        "enable": (np.arange(n_clocks) >= start).astype(np.int64),
        "in_healthy": zero + 1,
        "in_carried": zero + 1,
    }
    return inputs | {"cfg_brake_clocks": zero + BRAKE, "cfg_test_clocks": zero + TEST}


@cocotb.test()
async def random_inputs_equal_twin(dut):
    n_clocks, rng = 8000, np.random.default_rng(67)
    cocotb.log.info("seed 67")

    def level(share: float, length: int) -> np.ndarray:
        return (rng.random(n_clocks // length + 1) < share).astype(np.int64).repeat(length)[:n_clocks]

    inputs = {"rst": level(0.001, 1), "clear": level(0.2, 1), "in_fault": level(0.002, 1)}
    inputs |= {"enable": level(0.8, 211), "in_healthy": level(0.95, 3), "in_carried": level(0.97, 101)}
    inputs |= {"cfg_brake_clocks": level(0.5, 400) * 3 + 2, "cfg_test_clocks": level(0.5, 300) + 4}
    inputs, expected = driven(inputs, lambda told, _: told)
    await compare(dut, inputs, expected)
    assert set(expected["state"].tolist()) == set(State)
    assert not expected["wrong"].any(), "brakes that obey"


@cocotb.test()
async def brakes_that_obey_are_released(dut):
    """With a test, only behind all its phases; each brake alone is told to open before."""
    inputs, expected = driven(move_at(300, 10), lambda told, _: told)
    await compare(dut, inputs, expected)
    running = int(np.flatnonzero(expected["state"] == State.RUN)[0])
    assert running - 10 == 3 + BRAKE + (1 + 4 * N_AXES * (TEST + 2) if options().test else 0)
    told = expected["brake_release"] & ~expected["brake_engage"]
    assert set(told[:running].tolist()) == ({0, 1, 2, 4} if options().test else {0})
    assert (told[running:] == ALL).all()


@cocotb.test()
@cocotb.parametrize(fault=["stays shut", "stays open", "opens by itself", "fails its test"])
async def brakes_that_do_not_obey_are_a_fault(dut, fault):
    at = 250
    brakes = {
        "stays shut": lambda told, k: told & 0b011,
        "stays open": lambda told, k: told | (k > at) << 1,
        "opens by itself": lambda told, k: told | (k > 5),
        "fails its test": lambda told, k: told if k > at else 0,
    }
    inputs = move_at(400, 10)
    inputs["enable"][at:] = 0
    inputs, expected = driven(inputs, brakes[fault])
    await compare(dut, inputs, expected)
    late_to_open = fault == "fails its test" and not options().test
    assert late_to_open or expected["wrong"].any()
    assert (expected["state"][-1] == State.FAULT) or late_to_open


@cocotb.test()
async def one_broken_path_opens_no_brake(dut):
    """BRAKED to RUN and back, a fault, and again, with a stuck register: it is found, and opens no brake."""
    zero = np.zeros(400, np.int64)
    inputs = move_at(400, 10) | {"brake_fed": zero}
    inputs["enable"][100:140] = inputs["enable"][270:300] = 0
    inputs["in_fault"][200] = inputs["clear"][240] = 1
    await flush(dut, 4, **dict.fromkeys(inputs, 0) | {"rst": 1, "enable": 1})
    Clock(dut.clk, 10, "ns").start(start_high=False)
    found = False
    for k in range(400):
        for name, values in inputs.items():
            getattr(dut, name).value = int(values[k])
        dut.in_fault.value = int(inputs["in_fault"][k] or dut.wrong.value == 1)
        may_open = dut.state.value == State.RUN
        await FallingEdge(dut.clk)
        told = int(dut.brake_release.value) & ~int(dut.brake_engage.value)
        assert not told or may_open or dut.state.value == State.RUN, k
        found |= dut.wrong.value == 1
    assert found


@pytest.mark.parametrize("n_options", [0, 1, 2, 3])
def test_brakes_equal_twin(n_options):
    names = ("two_paths_g", "feedback_g", "test_g")
    generics = {name: "true" if k < n_options else "false" for k, name in enumerate(names)}
    tests = "random|obey_are_released" + ("|not_obey" if n_options > 1 else "")
    simulate("gc_brakes", "test_rtl_brakes", generics=generics, tests=tests)


ENGAGE = "idle_v or (shut_v and not in_test(i));"
BROKEN = [
    ("gc_brake_permit", "faulty <= faulty_v;", "faulty <= '0';"),
    ("gc_brake_permit", "idle <= idle_v;", "idle <= '0';"),
    ("gc_brake_permit", "shut <= shut_v;", "shut <= '0';"),
    ("gc_brake_permit", "was_low <= not enable;", "was_low <= '1';"),
    ("gc_brake_permit", ENGAGE, "'0';"),
    *(("gc_brake_permit", ENGAGE, f"{ENGAGE}\nif i = {axis} then\nbrake_engage(i) <= '1';\nend if;")
      for axis in range(N_AXES)),
    ("gc_brake_sequencer", "state <= next_v;", "state <= state_run_c;"),
    ("gc_brake_sequencer", "enable_1 <= enable;", "enable_1 <= '0';"),
    ("gc_brake_sequencer", "run <= '0';", "run <= '1';"),
    ("gc_brake_sequencer", "brake_release <= (others => '0');", "brake_release <= (others => '1');"),
]  # fmt: skip


@pytest.mark.parametrize("k", range(len(BROKEN)))
def test_one_broken_path_opens_no_brake(k, tmp_path):
    entity, good, stuck = BROKEN[k]
    text = source_of(RTL, entity).read_text()
    assert text.count(good) == 1
    copy = tmp_path / f"{entity}.vhd"
    copy.write_text(text.replace(good, stuck))
    simulate(
        "gc_brakes",
        "test_rtl_brakes",
        generics={"two_paths_g": "true"},
        extra_sources=(copy,),
        tests="one_broken",
        label=f"broken{k}",
    )
