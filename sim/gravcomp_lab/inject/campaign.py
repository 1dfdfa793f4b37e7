"""Draws flips, runs them in the bench, keeps what was found."""

import hashlib
import json
import zlib
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, astuple, dataclass
from pathlib import Path

import numpy as np

from gravcomp.errors import InputError
from gravcomp.files import write_atomically
from gravcomp_lab.inject import bench, hold, specimen
from gravcomp_lab.inject.bench import Design, Session
from gravcomp_lab.inject.hold import End, Scene
from gravcomp_lab.inject.outcome import Outcome, parse
from gravcomp_lab.inject.state import Store
from gravcomp_lab.synthesis.verilog import rtl_sources

# 1 ms at 40 MHz.
HORIZON = 40_000
STRIDE = 256
N_MOMENTS = 48
WINDOW = 6000
# For whether a flip is seen outside of its instance at all: two ticks.
PROBE_MOMENTS, PROBE_HORIZON, PROBE_STRIDE = (1504, 1576), 320, 8
FAULT_LATCH = ("gc_fault_latch", "sts_fault")
# Every bit of these is flipped: all of the safety chain, brakes, enable and command, and the limits on their way to it;
# of the host's registers those that are live, which leaves out copies for reading.
EXHAUSTIVE_BELOW = ("i_safety", "i_drive", "i_settings")
EXHAUSTIVE_ENTITIES = ("gc_registers",)
CHUNK = 500
SAMPLED_SCENES = ("rom", "image")
# And the instances below which every bit is flipped in them, () for all: constants that were loaded can be dropped by
# what comes from the host; what watches the brakes is at work while they are tested.
EXHAUSTIVE_SCENES = {"rom": (), "braked": (), "image": ("i_registers", "i_settings"), "test": ("i_brakes",)}
# gc_system without and with what watches it.
VARIANTS = {
    "plain": {"clock_watch_g": 0, "two_paths_g": "false", "guard_g": "false", "twin_g": "false"},
    "guarded": {
        "clock_watch_g": 256,
        "two_paths_g": "true",
        "brake_feedback_g": "true",
        "brake_test_g": "true",
        "guard_g": "true",
        "twin_g": "true",
    },
}
# Every entity is there with one lane, and the rest only more often with four.
LANES = 1


@dataclass(frozen=True)
class Flip:
    """Bit of a word (0 for a register) of a store, at a moment of a scene."""

    scene: str
    moment: int
    store: int
    word: int
    bit: int


@dataclass(frozen=True)
class Live:
    """Per store (words or 1, bits): which bits are live, as Outcome.reaches or by having changed."""

    bits: list[np.ndarray]

    def of(self, store: int) -> np.ndarray:
        """The live bits of a store, (n, 2): word, bit."""
        return np.argwhere(self.bits[store])


def is_exhaustive(store: Store) -> bool:
    """Whether every bit of it is flipped."""
    return store.entity in EXHAUSTIVE_ENTITIES or any(name in store.path for name in EXHAUSTIVE_BELOW)


def live_bits(live: dict[str, Live]) -> list[int]:
    """Per store, bits that are live in one scene or another."""
    return [int(np.logical_or.reduce(bits).sum()) for bits in zip(*(of.bits for of in live.values()), strict=True)]


def prepare(rtl: Path, weights: Path, bench_cpp: Path, variant: str, out: Path, seed: int) -> "Campaign":
    """Build a variant and the scenes in out; what an earlier run found of the same design and bench is used again."""
    generated, image = specimen.make_specimen(weights, out / "specimen")
    design = bench.build(
        rtl_sources(rtl, generated), {"lanes_g": LANES, **VARIANTS[variant]}, bench_cpp, out / "design"
    )
    identity = hashlib.sha256((out / "design" / "gc_system.v").read_bytes() + bench_cpp.read_bytes()).hexdigest()[:16]
    scenes = [Scene("rom"), Scene("image", image=image.data), Scene("braked", End.BRAKED), Scene("test", End.TEST)]
    return Campaign(design, scenes, seed, out / identity)


class Campaign:
    """One design, its scenes, and a folder of outcomes that a later run goes on from."""

    def __init__(self, design: Design, scenes: Sequence[Scene], seed: int, folder: Path):
        self.design, self.seed, self.folder = design, seed, folder
        self.scenes = {scene.name: scene for scene in scenes}
        rng = np.random.default_rng(seed)
        self.moments = sorted(int(clock) for clock in rng.choice(WINDOW, N_MOMENTS, replace=False))
        latches = [k for k, s in enumerate(design.stores) if (s.entity, s.name) == FAULT_LATCH]
        if not latches:
            raise InputError(f"{' '.join(FAULT_LATCH)}: no such register; need the one of the causes")
        # Of two copies the host sees the first.
        self._latch = latches[0]

    def live(self, scene: str, entities: Sequence[str] = ()) -> Live:
        """Which state is live in a scene: it changes without a fault, or its flip is seen outside of its instance.

        entities: those whose state is asked about, none for all; that of others counts as not live.
        """
        path = self.folder / f"live-{'-'.join([scene, *entities])}.npz"
        if path.exists():
            with np.load(path) as kept:
                return Live([kept[name] for name in kept.files])
        with Session(self.design) as session:
            hold.bring_up(session, self.scenes[scene])
            active = self._hold(session, PROBE_MOMENTS, PROBE_HORIZON, PROBE_STRIDE)
            found = [
                self._probe(session, k, store, active[k])
                if not entities or store.entity in entities
                else np.zeros((store.depth or 1, store.bits), dtype=bool)
                for k, store in enumerate(self.design.stores)
            ]
        path.parent.mkdir(parents=True, exist_ok=True)
        np.savez_compressed(path, *found)
        return Live(found)

    def _probe(self, session: Session, number: int, store: Store, active: list[bool]) -> np.ndarray:
        live = np.zeros((store.depth or 1, store.bits), dtype=bool)
        if not store.depth:
            live[0] = active
        words = np.flatnonzero(active) if store.depth else [0]
        for word in words:
            for bit in np.flatnonzero(~live[word]):
                live[word, bit] = any(
                    parse(session.ask("p", moment, number, word, bit)).reaches for moment in range(len(PROBE_MOMENTS))
                )
        return live

    def _hold(self, session: Session, moments: Sequence[int], horizon: int, stride: int) -> list[list[bool]]:
        session.tell("x", self._latch)
        return hold.hold(session, moments, horizon, stride)

    def exhaustive(self, scenes: Mapping[str, Sequence[str]], live: Live) -> list[Flip]:
        """Every bit of what is_exhaustive, once per scene, each at a moment drawn by seed.

        scenes: each with the instances below which bits are flipped, none for all.
        """
        flips = []
        for scene, below in scenes.items():
            for k, store in enumerate(self.design.stores):
                if store.depth or not is_exhaustive(store) or (below and set(below).isdisjoint(store.path)):
                    continue
                rng = self._rng(scene, store.instance, store.variable)
                known = live.bits[k][0] if store.entity in EXHAUSTIVE_ENTITIES else np.ones(store.bits, dtype=bool)
                flips += [Flip(scene, int(rng.integers(N_MOMENTS)), k, 0, int(bit)) for bit in np.flatnonzero(known)]
        return flips

    def _rng(self, *names: str) -> np.random.Generator:
        """Of the seed and of these names alone, so that what is drawn for one entity does not depend on the others."""
        return np.random.default_rng([self.seed, zlib.crc32(" ".join(names).encode())])

    def sample(self, live: dict[str, Live], n_per_entity: int) -> list[Flip]:
        """Flips of live state, drawn by seed: n per entity, evenly from the scenes in which it has any."""
        drawn = []
        for entity in sorted({s.entity for s in self.design.stores}):
            rng = self._rng(entity)
            numbers = [k for k, s in enumerate(self.design.stores) if s.entity == entity and not is_exhaustive(s)]
            pools = {scene: [(k, *bit) for k in numbers for bit in of.of(k)] for scene, of in live.items()}
            pools = {scene: pool for scene, pool in pools.items() if pool}
            for j, (scene, pool) in enumerate(pools.items()):
                n = n_per_entity // len(pools) + (j < n_per_entity % len(pools))
                for at in rng.integers(len(pool), size=n):
                    drawn.append(Flip(scene, int(rng.integers(N_MOMENTS)), *map(int, pool[at])))
        return drawn

    def run(self, flips: Sequence[Flip], jobs: int, progress: Callable[[int], None]) -> list[Outcome]:
        """The outcomes of the flips, in their order; those in the folder are not tried again."""
        order = sorted(range(len(flips)), key=lambda k: flips[k].scene)
        chunks = [order[k : k + CHUNK] for k in range(0, len(order), CHUNK)]
        found: list[Outcome | None] = [None] * len(flips)
        with ThreadPoolExecutor(jobs) as pool:
            for chunk, outcomes in zip(
                chunks, pool.map(lambda c: self._chunk([flips[k] for k in c]), chunks), strict=True
            ):
                for k, outcome in zip(chunk, outcomes, strict=True):
                    found[k] = outcome
                progress(len(chunk))
        return found

    def _chunk(self, flips: list[Flip]) -> list[Outcome]:
        name = hashlib.sha256(json.dumps([astuple(flip) for flip in flips]).encode()).hexdigest()[:16]
        path = self.folder / f"{name}.json"
        if path.exists():
            return [Outcome(**kept | {"largest_ua": tuple(kept["largest_ua"]), "left": tuple(kept["left"])})
                    for kept in json.loads(path.read_text())]  # fmt: skip
        outcomes = []
        for scene in dict.fromkeys(flip.scene for flip in flips):
            with Session(self.design) as session:
                hold.bring_up(session, self.scenes[scene])
                self._hold(session, self.moments, HORIZON, STRIDE)
                for flip in flips:
                    if flip.scene == scene:
                        outcomes.append(parse(session.ask("f", flip.moment, flip.store, flip.word, flip.bit)))
        write_atomically(path, json.dumps([asdict(outcome) for outcome in outcomes]))
        return outcomes
