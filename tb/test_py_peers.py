"""Peers: what they generate is what is compared, the claims can fail, and the float network in C is the network."""

import os
from dataclasses import replace
from pathlib import Path

import cocotb
import numpy as np
import pytest
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

from codes import ROOT, pack, unpack
from gravcomp.errors import InputError
from gravcomp.network.activation import gamma
from gravcomp.network.weights import load_network
from gravcomp_lab import pages
from gravcomp_lab.peers import claims, design, jitter, measure, ours
from gravcomp_lab.synthesis.place_route import PlacedClock, PlacedDesign
from machines import MACHINE
from runner import BUILD, simulate

NETWORK = load_network(ROOT / "weights" / "spheiro")
CORE = measure.PeerRow("core", 1000, 1000, 28, 0, {6: 180.0, 8: 240.0}, 3, 23, 23, 5, 1e-4)
DA4ML = measure.PeerRow("da4ml quadratic", 12000, 3000, 20, 0, {6: 54.0, 8: 72.0}, 3, 8, 7, 1, 6e-4)
NNGEN = measure.PeerRow("NNgen", 10000, 6000, 6, 11, {6: 62.0, 8: 81.0}, 3, 600, 600, 600, 8e-3)


def missed(ours: dict[int, measure.PeerRow]) -> list[str]:
    return [claim.text for claim in claims.claims(ours, [DA4ML, NNGEN]) if claim.is_reached is False]


def test_claim_about_lanes_that_were_not_measured_is_open():
    found = claims.claims({1: CORE, 4: CORE}, [DA4ML, NNGEN])
    assert [claim.is_reached for claim in found] == [True, True, None, None, True, True, True]


def test_claims_hold_for_a_core_that_reaches_them():
    assert missed(dict.fromkeys([1, 4, 20], CORE)) == []


@pytest.mark.parametrize(
    ("lanes", "change", "part"),
    [
        (4, {"latency": 24}, "lower latency"),
        (4, {"comb": 2400}, "a fifth"),
        (20, {"clock_mhz": {6: 180.0, 8: 72.0}}, "higher clock"),
        (20, {"comb": 9000}, "three quarters"),
        (1, {"clock_mhz": {6: 123.0, 8: 240.0}}, "twice the clock"),
        (1, {"comb": 1250}, "an eighth"),
        (1, {"error": 2.6e-4}, "error"),
    ],
)
def test_claims_fail_where_the_core_just_misses_one(lanes, change, part):
    (text,) = missed(dict.fromkeys([1, 4, 20], CORE) | {lanes: replace(CORE, **change)})
    assert part in text


def test_latency_counts_as_the_tool_claims_it():
    """7 clocks at 54 MHz are 129.6 ns; the 8 clocks at the ports would be 148."""
    ours = dict.fromkeys([1, 4, 20], replace(CORE, latency=24, clock_mhz={6: 180.0, 8: 250.0}))
    assert "4 lanes: lower latency than da4ml's quickest quadratic build" in missed(ours)


def test_row_takes_the_best_clock_of_each_speed():
    peer = design.PeerDesign("x", "peer", Path(), 1, 8, 7, 0.0, "")
    used = {"TRELLIS_COMB": 5, "TRELLIS_FF": 6}
    clocks = ((6, 50.0), (6, 54.0), (8, 73.0), (8, 72.0))
    row = measure.row(
        peer, [(speed, PlacedDesign({"clk": PlacedClock(clock, "", "", 0.0)}, used)) for speed, clock in clocks]
    )
    assert row.clock_mhz == {6: 54.0, 8: 73.0}
    assert (row.n_seeds, row.comb, row.mult) == (2, 5, 0)


@pytest.mark.parametrize("name", jitter.C_FLAGS)
def test_network_in_c_gives_the_forces_of_numpy(name, tmp_path):
    q_m = design.workspace_positions(MACHINE, 100, 1)
    call_ns, nothing_ns, forces_n = jitter.run_c(jitter.compile_c(NETWORK, q_m, jitter.C_FLAGS[name], tmp_path), 100, 3)
    np.testing.assert_allclose(forces_n, NETWORK.forces(q_m), atol=1e-3)
    assert np.median(call_ns) >= np.median(nothing_ns) >= 0


def test_missing_compiler_is_one_line(monkeypatch, tmp_path):
    monkeypatch.setattr(jitter.shutil, "which", lambda _: None)
    with pytest.raises(InputError, match=r"^cc: not found; install"):
        jitter.compile_c(NETWORK, np.zeros((1, 3)), [], tmp_path)


@cocotb.test()
async def peer_stream(dut):
    """One input per clock; each output comes after the stated latency and equals the tool's own model."""
    case = np.load(os.environ["CASE"])
    codes, expected, latency = case["codes"], case["expected"], int(case["latency"])
    Clock(dut.clk, 10, "ns").start(start_high=False)
    await FallingEdge(dut.clk)
    await FallingEdge(dut.clk)
    got = []
    for clock in range(len(codes) + latency):
        if clock >= latency:
            got.append(int(dut.model_out.value))
        dut.model_inp.value = pack(codes[min(clock, len(codes) - 1)], len(dut.model_inp) // 3)
        await FallingEdge(dut.clk)
    np.testing.assert_array_equal(unpack(got, len(dut.model_out) // 3, 3), expected)


@pytest.mark.slow
@pytest.mark.parametrize(("activation", "cutoff"), [("quadratic", 5), ("quadratic", 1), ("hard tanh", 2)])
def test_da4ml_verilog_equals_its_model_at_the_stated_latency(activation, cutoff):
    pytest.importorskip("da4ml", reason="da4ml is not installed; make peers installs it")
    from gravcomp_lab.peers import da4ml_peer

    name = f"da4ml-{activation.replace(' ', '-')}-{cutoff}"
    folder, x = BUILD / "tb" / "peers" / name, design.normalised_inputs(NETWORK, MACHINE, 200, 3)
    peer = da4ml_peer.generate(NETWORK, x, folder, activation=activation, cutoff=cutoff)
    expected = da4ml_peer.adder_graph(NETWORK, activation).predict(da4ml_peer.rounded(x)) * 2**da4ml_peer.FRACTION
    codes = np.rint(x * 2**da4ml_peer.FRACTION).astype(int)
    np.savez(folder / "case.npz", codes=codes, expected=expected.astype(int), latency=peer.latency)
    environment = {"CASE": str(folder / "case.npz")}
    simulate("peer", "test_py_peers", verilog=[peer.verilog], label=name, environment=environment)


def test_da4ml_error_is_that_of_its_fraction_bits():
    pytest.importorskip("da4ml", reason="da4ml is not installed; make peers installs it")
    from gravcomp_lab.peers import da4ml_peer

    x = design.normalised_inputs(NETWORK, MACHINE, 200, 3)
    outputs = da4ml_peer.adder_graph(NETWORK, "quadratic").predict(da4ml_peer.rounded(x))
    assert 2.0**-15 < np.abs(outputs - design.float_outputs(NETWORK, x, gamma)).max() < 16 * 2.0**-14


@pytest.mark.slow
def test_nngen_verilog_equals_its_model(tmp_path):
    pytest.importorskip("nngen", reason="NNgen is not installed; make peers installs it")
    from gravcomp_lab.peers import nngen_peer

    peer = nngen_peer.generate(NETWORK, design.normalised_inputs(NETWORK, MACHINE, 50, 3), tmp_path)
    assert 300 < peer.latency < 1000
    assert peer.error < 1e-2


def test_page_is_renewed_between_its_marks_only(tmp_path):
    path = tmp_path / "page.md"
    path.write_text("a\n<!-- t -->\nold\n<!-- /t -->\nb\n")
    pages.renew(path, "t", "new\n")
    pages.renew(path, "t", "newer")
    assert path.read_text() == "a\n<!-- t -->\n\nnewer\n\n<!-- /t -->\nb\n"
    with pytest.raises(InputError, match=r"page\.md: its lines <!-- x -->"):
        pages.renew(path, "x", "new")


def test_core_without_results_of_synthesis_is_one_line(tmp_path):
    with pytest.raises(InputError, match=r"synth\.json: no result for 1, 4 or 20 lanes"):
        ours.core_rows(tmp_path)
