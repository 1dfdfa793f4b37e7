"""Other constants than those of the ROM, and gc_force_path with the ports through which their image is loaded."""

from collections import deque
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from cocotb.triggers import FallingEdge

from codes import ROOT, pack, unpack
from compensated import compensated_weights
from gravcomp.core.compensator_tables import FixedCompensation
from gravcomp.core.formats import COUNT_BITS, CURRENT_BITS, FORCE_BITS, FixedNetwork
from gravcomp.core.image import Image, load_image
from gravcomp.network.weights import load_network
from gravcomp.twin import network as bittrue
from gravcomp.twin.compensator import compensator
from gravcomp_lab.benches.force_path import Bench
from machines import MACHINE, machine_folder

SPHEIRO = ROOT / "weights" / "spheiro"
ROM, FIRST, SECOND = 0, 1, 2  # what sts_bank says
LOAD_PORTS = ("load_begin", "load_valid", "load_word", "load_commit", "load_crc")
# Friction and cogging that are nowhere those of compensated.CSV, at speeds of a simulator's axes.
OTHER_CSV = """\
axis,name,value
all,v_dead,0.2
all,v_full,1
all,fc_pos,3.3
all,fc_neg,2.1
all,mu,0.02
1,pitch,0.012
2,pitch,0.021
3,pitch,0.0077
all,a1,5
all,a5,1
"""


def other_weights(folder: Path, compensation: str = OTHER_CSV, seed: int = 61) -> Path:
    """Write a weights folder that fits the formats of weights/spheiro but has no constant in common with it."""
    rng, network = np.random.default_rng(seed), load_network(SPHEIRO)

    def shrunk(values: np.ndarray, least: float = 0.6) -> np.ndarray:
        return values * rng.uniform(least, 0.95, values.shape)

    other = replace(
        network,
        hidden_weights=shrunk(network.hidden_weights),
        hidden_bias=shrunk(network.hidden_bias),
        output_weights=shrunk(network.output_weights),
        output_bias=shrunk(network.output_bias),
        q_scale=1.2 * shrunk(network.q_scale, 0.85),
        f_offset=shrunk(network.f_offset),
        f_scale=shrunk(network.f_scale, 0.92),
    )
    compensated_weights(folder, compensation, MACHINE.text)
    return machine_folder(folder, other)


def image_of(folder: Path) -> Image:
    """The image of a weights folder for a core that was built with weights/spheiro."""
    return load_image(folder, SPHEIRO)


class LoadBench(Bench):
    """gc_force_path_bench, loadable: takes inferences all along, beside what a script does to the ports of loading.

    pace: probability of an offered inference per clock.
    """

    def __init__(self, dut):
        super().__init__(dut)
        self.rng = np.random.default_rng(62)
        self.pace = 0.0
        self.is_recording = False
        self.script: deque[Mapping[str, int]] = deque()
        self.driven: Mapping[str, int] = {}
        self.history: list[tuple[int, int]] = []  # count and period in each clock
        self.accepted: list[tuple[int, int]] = []  # count and bank of each inference
        self.results: list[tuple[int, ...]] = []  # clock and outputs

    def begin(self) -> None:
        self.script.append({"load_begin": 1})

    def load(self, image: Image, n_words: int | None = None) -> None:
        """Append the words of an image to the script, or the first n_words."""
        self.begin()
        self.script += [{"load_valid": 1, "load_word": int(word)} for word in image.words[:n_words]]

    def commit(self, crc32: int) -> None:
        self.script += [{"load_commit": 1, "load_crc": crc32}, {}]

    def rom(self) -> None:
        self.script += [{"load_rom": 1}, {}]

    async def clocks(self, n: int) -> None:
        for _ in range(n):
            self._drive(self.script.popleft() if self.script else {})
            offers = bool(self.rng.random() < self.pace)
            self.dut.in_valid.value = int(offers)
            if self.is_recording:
                self._record(offers)
            await FallingEdge(self.dut.clk)
            self.n_clocks += 1

    async def finish_script(self, but: int = 0) -> None:
        """Go on until the script is at its end, or so many clocks before it."""
        await self.clocks(max(0, len(self.script) - but))

    async def reset(self) -> None:
        """One clock of reset: what is under way is gone. Then the axes count anew."""
        self.dut.rst.value = 1
        self.pace, n_results = 0.0, len(self.results)
        await self.clocks(1)
        self.dut.rst.value = 0
        self.accepted = self.accepted[:n_results]
        await self.clocks(20)

    def _drive(self, ports: Mapping[str, int]) -> None:
        for name in {*self.driven, *ports}:
            if self.driven.get(name, 0) != ports.get(name, 0):
                getattr(self.dut, name).value = ports.get(name, 0)
        self.driven = ports

    def _record(self, offers: bool) -> None:
        count = int(self.dut.sts_count.value)
        self.history.append((count, int(self.dut.sts_speed_period.value)))
        if self.dut.out_valid.value == 1:
            self.results.append((len(self.history) - 1, *self.outputs()))
        if offers and self.dut.in_ready.value == 1:
            self.accepted.append((count, int(self.dut.sts_bank.value)))

    async def banks_of_results(self, sets: Mapping[int, tuple[FixedNetwork, FixedCompensation]]) -> list[int]:
        """Wait for the last result; assert that each equals the model of the bank in use as its inference began.

        sets: the constants in ROM and banks. Returns the bank of each result and forgets them.
        """
        self.pace = 0.0
        await self.clocks(80)
        assert len(self.results) == len(self.accepted), "an inference was lost, or one was invented"
        clocks, force, current, clamped, saturated = (list(column) for column in zip(*self.results, strict=True))
        banks = np.array([bank for _, bank in self.accepted])
        count = unpack([count for count, _ in self.accepted], COUNT_BITS, 3)
        then = [self.history[clock - self.clocks_behind_core] for clock in clocks]
        late_count = unpack([count for count, _ in then], COUNT_BITS, 3)
        period = unpack([period for _, period in then], 32, 3)
        for bank in set(banks):
            network, compensation = sets[bank]
            of = banks == bank
            core = bittrue.core(count[of], network)
            force_mn, is_unfit = compensator(core.force_mn, late_count[of], period[of], compensation)
            np.testing.assert_array_equal(unpack(force, FORCE_BITS, 3)[of], force_mn)
            np.testing.assert_array_equal(
                unpack(current, CURRENT_BITS, 3)[of], bittrue.current_scaler(force_mn, network)
            )
            np.testing.assert_array_equal(unpack(clamped, 1, 3)[of] != 0, core.clamped)
            np.testing.assert_array_equal(unpack(saturated, 1, 3)[of] != 0, core.saturated | is_unfit)
        self.results, self.accepted = [], []
        return banks.tolist()


async def moving(dut, network: FixedNetwork) -> LoadBench:
    """A bench whose axes move across the end of that network's trained range."""
    bench = LoadBench(dut)
    for name in (*LOAD_PORTS, "load_rom"):
        getattr(dut, name).value = 0
    await bench.start()
    bench.is_recording = True
    await bench.home_near(network.count_high - 4 * np.arange(1, 4))
    dut.target.value = pack(network.count_high + 100_000, COUNT_BITS)
    return bench
