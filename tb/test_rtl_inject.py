"""Single-bit flips in gc_system under Verilator, with a fault planted that they must bring to light."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from gravcomp_lab.inject import bench, hold, specimen
from gravcomp_lab.inject.bench import Design, Session
from gravcomp_lab.inject.hold import Scene
from gravcomp_lab.inject.outcome import BRAKED, HARMLESS, LATENT, SILENT, Outcome, classify, parse
from runner import BUILD, ROOT, rtl_sources

N_FLIPS, SEED = 200, 5
# A brake that follows its state by an edge only: it stays as a flip left it, and nothing watches it.
GOOD = """\
      brake_release <= '0';
      if next_v = state_run_c then
"""
BAD = """\
      if next_v /= state_run_c and state = state_run_c then
        brake_release <= '0';
      end if;
      if next_v = state_run_c and state /= state_run_c then
"""
WEIGHTS = ROOT / "weights" / "spheiro"


@pytest.fixture(scope="module")
def design() -> Design:
    folder = BUILD / "inject_test"
    generated, _ = specimen.make_specimen(WEIGHTS, folder / "specimen")
    planted = planted_sequencer(folder)
    replaced = {path.name: path for path in [*generated, planted]}
    sources = [replaced.get(path.name, path) for path in rtl_sources()]
    return bench.build(sources, {"lanes_g": 4}, ROOT / "tb" / "inject" / "bench.cpp", folder, effort=0)


def planted_sequencer(folder: Path) -> Path:
    (path,) = (path for path in rtl_sources() if path.name == "gc_brake_sequencer.vhd")
    text = path.read_text()
    assert text.count(GOOD) == 1
    planted = folder / path.name
    planted.write_text(text.replace(GOOD, BAD))
    return planted


@pytest.fixture(scope="module")
def session(design) -> Iterator[Session]:
    with Session(design) as session:
        hold.bring_up(session, Scene("rom"))
        (latch,) = stores(design, "gc_fault_latch", "sts_fault")
        session.tell("x", latch)
        hold.hold(session, range(1000, 3000, 100), 12_000, 256)
        yield session


def stores(design: Design, entity: str, name: str) -> list[int]:
    return [k for k, store in enumerate(design.stores) if (store.entity, store.name) == (entity, name)]


def flip(session: Session, store: int, bit: int, moment: int = 0) -> Outcome:
    return parse(session.ask("f", moment, store, 0, bit))


def verdict(outcome: Outcome) -> str:
    return classify(outcome, specimen.ua_per_mn(WEIGHTS))


@pytest.mark.slow
def test_brake_that_is_not_watched_is_silently_wrong(design, session):
    (brake,) = stores(design, "gc_brake_sequencer", "brake_release")
    outcome = flip(session, brake, 0)
    assert verdict(outcome) == SILENT
    assert (outcome.brakes, outcome.enable, outcome.causes) == (0, 1, 0)
    assert outcome.brake_clocks >= 12_000


@pytest.mark.slow
def test_flips_end_as_their_place_demands(design, session):
    """By hand: a product between two inferences is overwritten; a lost kick brakes; a count of results stays wrong."""
    (number,) = stores(design, "gc_core_side", "number")
    assert verdict(flip(session, number, 20)) == LATENT
    fault = stores(design, "gc_quad_decoder", "sts_illegal")[0]
    outcome = flip(session, fault, 0)
    assert (verdict(outcome), outcome.causes) == (BRAKED, 1 << 1)
    product = stores(design, "gc_multiply", "product_2")[0]
    outcomes = [flip(session, product, 2, moment) for moment in range(20)]
    assert HARMLESS in {verdict(outcome) for outcome in outcomes}
    weights = next(k for k, store in enumerate(design.stores) if store.entity == "gc_weight_rom" and store.depth)
    assert flip(session, weights, 17).left, "a ROM mends nothing"


@pytest.mark.slow
def test_a_run_without_effect_leaves_no_trace(design, session):
    """The same flips in another order end alike: a run begins where all others do."""
    rng = np.random.default_rng(SEED)
    print(f"seed {SEED}")
    drawn = [(int(k), int(rng.integers(design.stores[k].bits)), int(rng.integers(20)))
             for k in rng.integers(len(design.stores), size=N_FLIPS)]  # fmt: skip
    outcomes = [flip(session, *one) for one in drawn]
    assert [flip(session, *one) for one in drawn[:40][::-1]] == outcomes[:40][::-1]
    found = [verdict(outcome) for outcome in outcomes]
    assert found.count(HARMLESS) > N_FLIPS // 2
    assert len(set(found)) > 1
