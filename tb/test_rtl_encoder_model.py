"""gc_encoder_model walks as an encoder does; its pins, decoded by the bit-true decoder, give its own count."""

from pathlib import Path

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

from gravcomp.twin.encoder import DecoderConfig, quad_decoder, quadrature, wrap_32
from runner import simulate

HDL = Path(__file__).parent / "hdl"


async def start(dut) -> None:
    for name in ("target", "load", "load_count"):
        getattr(dut, name).value = 0
    dut.index_count.value = -(2**31)
    dut.clocks_per_edge.value = 3
    Clock(dut.clk, 10, "ns").start()
    await FallingEdge(dut.clk)


async def record(dut, clocks: int | None = None) -> np.ndarray:
    """Rows (count, a, b, z) at falling clock edges: while busy, or for a number of clocks."""
    rows = []
    while len(rows) < (clocks or 1) or (clocks is None and dut.busy.value == 1):
        await FallingEdge(dut.clk)
        rows.append((dut.count.value.to_signed(), int(dut.a.value), int(dut.b.value), int(dut.z.value)))
    return np.array(rows)


def decode(a, b, z, config: DecoderConfig, home_enable: int = 0, index_position: int = 0) -> dict[str, np.ndarray]:
    constants = {"rst": 0, "cfg_clear": 0, "cfg_home_enable": home_enable, "cfg_index_position": index_position}
    return quad_decoder({"a": a, "b": b, "z": z} | {name: np.full_like(a, v) for name, v in constants.items()}, config)


async def load(dut, count: int) -> np.ndarray:
    dut.load.value = 1
    dut.load_count.value = count
    dut.target.value = count
    row = await record(dut, 1)
    dut.load.value = 0
    return row


@cocotb.test()
async def walks_one_edge_at_a_time(dut):
    await start(dut)
    rng = np.random.default_rng(8)
    cocotb.log.info("seed 8")
    for _ in range(30):
        spacing, target = int(rng.integers(1, 6)), int(rng.integers(-40, 40))
        begin = dut.count.value.to_signed()
        dut.clocks_per_edge.value = spacing
        dut.target.value = target
        count, a, b, z = (await record(dut, abs(target - begin) * spacing + 8)).T
        edges = np.flatnonzero(np.diff(count, prepend=begin))
        assert edges.tolist() == (edges[:1] + spacing * np.arange(abs(target - begin))).tolist()
        assert (np.abs(np.diff(count)) <= 1).all()
        assert count[-1] == target
        assert dut.busy.value == 0
        assert np.array_equal((a, b), quadrature(count))
        assert not z.any()


@cocotb.test()
async def index_marks_one_position(dut):
    await start(dut)
    dut.index_count.value = 6
    for target in (12, 0, 12):
        dut.target.value = target
        count, _, _, z = (await record(dut, 60)).T
        assert count[-1] == target
        assert z.any()
        assert np.array_equal(z, count == 6)


@cocotb.test()
async def keeps_its_spacing_at_reversal(dut):
    await start(dut)
    dut.clocks_per_edge.value = 7
    await load(dut, 0)
    dut.target.value = 100
    count = (await record(dut, 30))[:, 0]
    dut.target.value = -100
    count = np.concatenate((count, (await record(dut, 60))[:, 0]))
    assert (np.diff(np.flatnonzero(np.diff(count))) == 7).all()
    assert count.max() > count[-1]


@cocotb.test()
async def load_makes_no_edge(dut):
    await start(dut)
    for target in (0, 1, 2, 3):
        await load(dut, 0)
        dut.target.value = target
        (await record(dut, 20))
        before = int(dut.a.value), int(dut.b.value)
        ((count, a, b, _),) = await load(dut, -123450)
        assert (a, b) == before
        assert count == -123452 + target


@cocotb.test()
async def takes_the_shorter_way_round(dut):
    await start(dut)
    await load(dut, 2**31 - 4)
    dut.target.value = -(2**31) + 2
    count = (await record(dut, 60))[:, 0]
    assert count[-1] == -(2**31) + 2
    assert {wrap_32(int(step)) for step in np.diff(count)} == {0, 1}


@cocotb.test()
async def decoder_counts_its_edges(dut):
    await start(dut)
    await load(dut, 0)
    rng = np.random.default_rng(9)
    cocotb.log.info("seed 9")
    config = DecoderConfig(filter_samples=4)
    dut.clocks_per_edge.value = config.shortest_level // 2 + 1
    await record(dut, 20)
    rows = [await record(dut, 20)]
    for target in rng.integers(-30, 30, 12):
        dut.target.value = int(target)
        rows.append(await record(dut))
    rows.append(await record(dut, 20))
    count, a, b, z = np.concatenate(rows).T
    decoded = decode(a, b, z, config)
    assert decoded["count"][-1] == count[-1] - count[0]
    assert not decoded["sts_illegal"].any()


@cocotb.test()
async def preset_takes_a_decoder_anywhere(dut):
    await start(dut)
    await load(dut, 0)
    config = DecoderConfig()
    dut.clocks_per_edge.value = config.shortest_level
    rows = [await record(dut, 20)]
    index = 123456 // 4 * 4 + config.index_phase
    dut.index_count.value = index
    rows.append(await load(dut, index - 8))
    rows.append(await record(dut, 30))
    dut.target.value = index + 7
    rows.append(await record(dut, 90))
    count, a, b, z = np.concatenate(rows).T
    decoded = decode(a, b, z, config, home_enable=1, index_position=index)
    assert decoded["count"][-1] == count[-1] == index + 7
    assert decoded["sts_referenced"][-1]
    assert not decoded["sts_illegal"].any()


def test_encoder_model_walks_as_an_encoder():
    simulate("gc_encoder_model", "test_rtl_encoder_model", extra_sources=(HDL / "gc_encoder_model.vhd",))
