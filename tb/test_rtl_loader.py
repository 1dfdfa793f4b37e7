"""Loading constants at run time: gc_top computes with whole sets only, each its model's; what is wrong is refused."""

import os
from itertools import groupby
from pathlib import Path

import cocotb
import pytest

from codes import fixed_compensation, fixed_network
from compensated import compensated_weights
from loading import FIRST, ROM, SECOND, SPHEIRO, image_of, moving, other_weights
from runner import BENCHES, BUILD, simulate

WEIGHTS = BUILD / "loading"


def sets_under_test():
    """ROM, the other weights as an image, and those of the Sphe.I.Ro. without a compensator."""
    other, plain = image_of(Path(os.environ["OTHER"])), image_of(SPHEIRO)
    sets = {
        ROM: (fixed_network(), fixed_compensation()),
        FIRST: (other.network, other.compensation),
        SECOND: (plain.network, plain.compensation),
    }
    return sets, other, plain


def in_turn(banks: list[int]) -> list[int]:
    return [bank for bank, _ in groupby(banks)]


@cocotb.test()
async def swaps(dut):
    """Inferences back to back through a commit and the return to the ROM: none is lost, none is a mixture."""
    sets, other, _ = sets_under_test()
    bench = await moving(dut, other.network)
    bench.load(other)
    await bench.finish_script(but=60)
    bench.commit(other.crc32)
    bench.pace = 1.0
    await bench.clocks(300)
    assert dut.sts_bank.value == FIRST
    assert int(dut.sts_bank_crc.value) == other.crc32
    bench.rom()
    await bench.clocks(200)
    assert in_turn(await bench.banks_of_results(sets)) == [ROM, FIRST, ROM]
    assert int(dut.sts_bank_crc.value) == 0


@pytest.mark.parametrize("lanes", [1, 4, 20])
def test_every_result_is_that_of_one_set_of_constants(lanes):
    simulate_loadable("swaps", lanes)


def simulate_loadable(test: str, lanes: int) -> None:
    rom, other = compensated_weights(WEIGHTS / "rom"), other_weights(WEIGHTS / "other")
    simulate(
        "gc_top_bench",
        "test_rtl_loader",
        generics={"lanes_g": lanes, "loadable_g": "true"},
        environment={"WEIGHTS": str(rom), "OTHER": str(other)},
        generated=rom / "generated",
        extra_sources=tuple(BENCHES / f"{name}.vhd" for name in ("gc_encoder_model", "gc_top_bench")),
        tests=f"{test}$",
        label=test,
    )
