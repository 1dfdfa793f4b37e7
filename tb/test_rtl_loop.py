"""What a loop found is in the VHDL: on its held-out samples, before and after, and at the pins of gc_system."""

from dataclasses import replace
from types import SimpleNamespace

import cocotb
import numpy as np
import pytest
from cocotb.triggers import Timer

from codes import ROOT, fixed_network
from gravcomp.cli import main
from gravcomp.core.compensation import load_compensation
from gravcomp.diagnosis.fit import Fit
from gravcomp.diagnosis.model import Model
from gravcomp.diagnosis.shares import Shares
from gravcomp.errors import InputError
from gravcomp.logs.csv_reader import read_measurement
from gravcomp.logs.measurement import Measurement
from gravcomp.loop.loop import (
    RUNS,
    check_robot,
    close_loop,
    errors_by_run,
    fixed_point_mn,
    generated_folder,
    load_samples,
    loop_errors,
    weights_folder,
)
from gravcomp.training.training import workspace_set
from gravcomp.twin import network as bittrue
from gravcomp_lab.benches.held_out import held_out_run
from machines import MACHINE, SHIPPED
from measured_samples import write_log
from runner import BUILD, RTL, simulate
from support.board import Board

LANES = 4
# Coulomb and viscous friction of every axis; speeds at which the pins show it, axis by axis.
COULOMB_N, VISCOUS_NS_PER_M = 1.5, 20.0
SPEEDS_MPS = np.array([0.2, -0.4, 0.8])


def found_in(data: Measurement, effects: Model, noise_n: np.ndarray) -> SimpleNamespace:
    """What a diagnosis returns that found exactly these effects."""
    before = effects.predict(data) + noise_n
    return SimpleNamespace(
        data=replace(data, force=data.nominal + before),
        is_test=np.arange(len(before)) % 2 == 0,
        before=before,
        after=noise_n,
        left_out=np.zeros(before.shape, bool),
        noise=SimpleNamespace(rms=float(noise_n.std()), sigma=noise_n.std(axis=0), source="known", is_sure=True),
        over_noise=1.0,
        fit=Fit((), ()),
        verdict="explained",
        shares=Shares({}, 0.0, 1.0),
        untestable={},
        **{name: () for name in ("alternatives", "drivers", "notes")},
        noise_floor=float(noise_n.std()),
    )


def test_loop_refuses_data_of_another_robot(tmp_path):
    (tmp_path / "log.csv").write_text(
        "t_s,q1_m,v1_mps,f1_n,fm1_n\n" + "".join(f"{k},{k / 99},1,2,2\n" for k in range(40))
    )
    with pytest.raises(InputError, match=r"log[.]csv: not of the robot of"):
        check_robot(read_measurement(tmp_path / "log.csv", MACHINE), ROOT / "weights" / "spheiro")


@pytest.mark.slow
def test_loop_brings_found_effects_into_the_rtl(tmp_path):
    """Payload into the network, friction into the compensator: the RTL's error falls to noise and quantisation."""
    robot, rng = MACHINE.robot, np.random.default_rng(8)
    pose = workspace_set(160, robot, 3)
    v = rng.uniform(5e-4, 1e-2, pose.q.shape) * rng.choice([-1, 1], pose.q.shape)
    t_s = np.arange(len(v), dtype=float)
    data = Measurement("test", t_s, pose.q, v, pose.f, pose.f, "N", ("m",) * 3, force_at=robot.forces, robot=robot)
    effects = [
        ("payload", {"moment_x": 0.1, "moment_y": -0.05, "moment_z": 0.08}),
        ("coulomb_friction", {"fc_1": 1.5, "fc_2": 2.0, "fc_3": 1.0}),
    ]
    model = Model(MACHINE, effects)
    found = found_in(data, model, 0.1 * rng.standard_normal(v.shape))
    closed = close_loop(found, model, ROOT / "weights" / "spheiro", tmp_path, 0, "a test", {})
    assert (closed.placement.in_network, closed.placement.in_compensator) == (["payload"], ["coulomb_friction"])
    samples, rtl_n = load_samples(tmp_path), {}
    for run in RUNS:
        force_mn = held_out_run(tmp_path, run, RTL, BUILD)
        np.testing.assert_array_equal(force_mn, fixed_point_mn(tmp_path, run, samples))
        rtl_n[run] = force_mn / 1e3
    table = {**loop_errors(tmp_path), "RTL": errors_by_run(rtl_n, samples["measured_n"])}
    rms_n = {name: [runs[run]["rms_n"] for run in RUNS] for name, runs in table.items()}
    print(f"MEASURED {rms_n}")
    assert all(before > 1.5 for before, _ in rms_n.values())
    assert rms_n["analytic model"][1] < 0.11
    assert rms_n["network"][1] < 0.18
    assert rms_n["RTL"][1] == pytest.approx(rms_n["network"][1], abs=0.01)
    assert rms_n["RTL"] == rms_n["fixed point"]


@cocotb.test()
async def friction_at_the_pins(dut):
    """Edges come at speeds in m/s of the simulated time: what the core makes of them depends on its own clock."""
    board = Board(dut)
    await board.start()
    edge_ps = np.rint(1e12 * MACHINE.drive.unit_per_count / np.abs(SPEEDS_MPS)).astype(int)

    async def move(axis: int) -> None:
        while True:
            await Timer(int(edge_ps[axis]), "ps")
            board.position[axis] += int(np.sign(SPEEDS_MPS[axis]))
            board.drive()

    for axis in range(len(SPEEDS_MPS)):
        cocotb.start_soon(move(axis))
    await Timer(10 * int(edge_ps.max()), "ps")
    await board.registers.write("command", 1 << board.registers.map["command"].fields["start"][0])
    while await board.registers.read("result_number") == 0:
        pass
    position, force_mn = [np.array(await board.registers.read_axes(name)) for name in ("position", "force_mn")]
    friction_n = (force_mn - bittrue.core(position, fixed_network()).force_mn) / 1e3
    print(f"MEASURED friction {friction_n} N at {SPEEDS_MPS} m/s")
    np.testing.assert_allclose(friction_n, np.sign(SPEEDS_MPS) * COULOMB_N + VISCOUS_NS_PER_M * SPEEDS_MPS, rtol=0.03)


@pytest.mark.slow
def test_friction_that_the_loop_found_is_that_of_the_speed_at_the_pins_of_gc_system(tmp_path):
    """The whole chain at the clock of the machine folder: a ROM for another clock has the wrong viscous part."""
    rng = np.random.default_rng(6)
    q_m = MACHINE.robot.workspace(200, 6)
    v_mps = rng.uniform(0.02, 1.0, q_m.shape) * rng.choice([-1, 1], q_m.shape)
    friction_n = COULOMB_N * np.sign(v_mps) + VISCOUS_NS_PER_M * v_mps
    force_n = MACHINE.robot.forces(q_m) + friction_n + 0.1 * rng.standard_normal(q_m.shape)
    write_log(tmp_path / "log.csv", 2.0 * np.arange(len(q_m)), q_m, v_mps, force_n)
    out = tmp_path / "loop"
    assert main(["loop", str(tmp_path / "log.csv"), "--weights", str(SHIPPED), "--out", str(out)]) == 0
    found = load_compensation(weights_folder(out, "after"), 3)
    np.testing.assert_allclose(found.b_pos, VISCOUS_NS_PER_M, rtol=0.02)
    simulate(
        "gc_system",
        "test_rtl_loop",
        generics={"lanes_g": LANES},
        label="friction",
        generated=generated_folder(out, "after"),
        environment={"WEIGHTS": str(weights_folder(out, "after"))},
        tests=r"\.friction_at_the_pins$",
    )
