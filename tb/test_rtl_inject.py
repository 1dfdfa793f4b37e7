"""Single-bit flips in gc_system with two cores under Verilator, with a fault planted that they must bring to light."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from gravcomp.twin.safety import Cause
from gravcomp_lab.inject import bench, hold, specimen
from gravcomp_lab.inject.bench import Design, Session
from gravcomp_lab.inject.hold import Scene
from gravcomp_lab.inject.outcome import BRAKED, HARMLESS, LATENT, SILENT, Outcome, classify, parse
from runner import BUILD, ROOT, rtl_sources

N_FLIPS, N_MOMENTS, HORIZON, SEED = 150, 20, 5000, 5
# Small, and nothing but the second core watches.
GENERICS = {"lanes_g": 1, "loadable_g": "false", "two_paths_g": "false", "guard_g": "false", "twin_g": "true"}
# Brakes that the second core does not compare.
GOOD = ("main_release & main_engage &", "released & engaged &")
BAD = ('"000000" &', '"000000" &')
WEIGHTS = ROOT / "weights" / "spheiro"
CLOCKS_TO_BRAKES = 4


@pytest.fixture(scope="module")
def design() -> Design:
    folder = BUILD / "inject_test"
    generated, _ = specimen.make_specimen(WEIGHTS, folder / "specimen")
    twin = planted_twin(folder)
    sources = [twin if path.name == twin.name else path for path in rtl_sources(generated)]
    return bench.build(sources, GENERICS, ROOT / "tb" / "inject" / "bench.cpp", folder)


def planted_twin(folder: Path) -> Path:
    (path,) = (path for path in rtl_sources() if path.name == "gc_core_twin.vhd")
    text = path.read_text()
    for good, bad in zip(GOOD, BAD, strict=True):
        assert text.count(good) == 1
        text = text.replace(good, bad)
    planted = folder / path.name
    planted.write_text(text)
    return planted


@pytest.fixture(scope="module")
def session(design) -> Iterator[Session]:
    with Session(design) as session:
        hold.bring_up(session, Scene("rom"))
        session.tell("x", stores(design, "gc_fault_latch", "sts_fault")[0])
        hold.hold(session, range(1000, 1000 + 100 * N_MOMENTS, 100), HORIZON, 256)
        yield session


def stores(design: Design, entity: str, name: str) -> list[int]:
    """Registers of this name, those of the first core before those of the second."""
    return [k for k, store in enumerate(design.stores) if (store.entity, store.name) == (entity, name)]


def flip(session: Session, store: int, bit: int, moment: int = 0) -> Outcome:
    return parse(session.ask("f", moment, store, 0, bit))


def verdict(outcome: Outcome) -> str:
    return classify(outcome, specimen.ua_per_mn(WEIGHTS))


@pytest.mark.slow
def test_brake_that_is_not_watched_is_silently_wrong(design, session):
    for brake in stores(design, "gc_brake_sequencer", "brake_release"):
        outcome = flip(session, brake, 0)
        assert (verdict(outcome), outcome.causes) == (SILENT, 0)
        assert outcome.brake_clocks > 0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("entity", "name", "bit"),
    [("gc_drive", "g_axis_n1_command", 31), ("gc_drive", "g_axis_n3_command", 0), ("gc_brake_sequencer", "run", 0)],
)
def test_difference_of_the_cores_engages_the_brakes(design, session, entity, name, bit):
    """In either core; the clocks from the wrong bit to the brakes are those of docs/guide/safety.md."""
    registers = stores(design, entity, name)
    assert len(registers) == 2
    for register in registers:
        outcome = flip(session, register, bit)
        assert (verdict(outcome), outcome.causes) == (BRAKED, Cause.CORE.mask)
        assert outcome.wrong_clocks <= CLOCKS_TO_BRAKES


@pytest.mark.slow
def test_what_only_the_second_core_can_know(design, session):
    """A count that is wrong, and an order of the neurons that is, move no cause but the comparison."""
    for count in stores(design, "gc_quad_decoder", "count"):
        outcome = flip(session, count, 13)
        assert (verdict(outcome), outcome.causes) == (BRAKED, Cause.CORE.mask)
    for memory in (k for k, s in enumerate(design.stores) if s.entity == "gc_weight_rom" and s.depth):
        assert {verdict(flip(session, memory, bit)) for bit in range(0, 90, 9)} <= {BRAKED, LATENT, HARMLESS}


@pytest.mark.slow
def test_flips_end_as_their_place_demands(design, session):
    """A count of results stays wrong; an encoder's fault brakes; a product between inferences is written over."""
    (number, _) = stores(design, "gc_core_side", "number")
    assert verdict(flip(session, number, 20)) == LATENT
    outcome = flip(session, stores(design, "gc_quad_decoder", "sts_illegal")[0], 0)
    assert verdict(outcome) == BRAKED
    assert outcome.causes & Cause.ENCODER.mask
    product = stores(design, "gc_multiply", "product_2")[0]
    assert HARMLESS in {verdict(flip(session, product, 2, moment)) for moment in range(N_MOMENTS)}


@pytest.mark.slow
def test_a_run_leaves_no_trace_in_the_next(design, session):
    rng = np.random.default_rng(SEED)
    print(f"seed {SEED}")
    drawn = [(int(k), int(rng.integers(design.stores[k].bits)), int(rng.integers(N_MOMENTS)))
             for k in rng.integers(len(design.stores), size=N_FLIPS)]  # fmt: skip
    outcomes = [flip(session, *one) for one in drawn]
    assert [flip(session, *one) for one in drawn[:40][::-1]] == outcomes[:40][::-1]
    found = [verdict(outcome) for outcome in outcomes]
    assert found.count(HARMLESS) > N_FLIPS // 2
    assert {BRAKED, LATENT} <= set(found)
