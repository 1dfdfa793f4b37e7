"""A campaign over the entities of rtl/: drawn by seed, tried in parallel, told as a table."""

import tomllib
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from gravcomp.errors import InputError
from gravcomp_lab.mutation.mutants import Mutant, draw
from gravcomp_lab.mutation.trial import (
    CAUGHT,
    INVALID,
    SURVIVED,
    TIMEOUT,
    Outcome,
    relevant_tests,
    run_tests,
    try_mutant,
)
from gravcomp_lab.synthesis.verilog import handwritten_sources

TIMEOUT_S = 900.0

INTRODUCTION = """\
# Mutation tests

Written by `make mutate`. Each mutant is the VHDL with one small fault: an operator, a constant, a bit, a condition, a
comparison, a width, a sign, or an assignment that is gone. Mutants are drawn by seed; the share of an entity goes with
the square root of the faults that fit into it; what GHDL does not analyse or elaborate is not counted. The tests in
which the entity runs follow each other, its own first, those of gc_core and the tops last, then the proofs, until one
fails. A mutant that hangs is caught by the time limit.
"""


def plan(root: Path, n_mutants: int, seed: int, entities: Iterable[str] = ()) -> dict[str, tuple[int, list[Mutant]]]:
    """The draw over the VHDL written by hand, as of mutants.draw; entities limits it, without changing what each gets.

    Raises InputError for an entity that has no mutants.
    """
    texts = {entity: path.read_text() for entity, path in handwritten_sources(root / "rtl").items()}
    drawn = draw(texts, n_mutants, seed)
    for entity in entities:
        if entity not in drawn:
            raise InputError(
                f"{entity}: no file of rtl/ in which a fault can be planted; name one of {', '.join(drawn)}"
            )
    return {entity: drawn[entity] for entity in entities} or drawn


def check_baseline(root: Path, entities: Iterable[str], build: Path) -> None:
    """Raise InputError unless the tests that shall catch the mutants pass on the VHDL as it is."""
    files = sorted({file for entity in entities for file in relevant_tests(entity, root / "rtl", root / "tb")})
    result, test = run_tests(root, root / "rtl", build, files, 4 * TIMEOUT_S)
    if result != SURVIVED:
        raise InputError(f"without any fault {test or 'the tests'} {result}; make the tests pass first")


def run(
    root: Path, planned: dict[str, tuple[int, list[Mutant]]], jobs: int, on_outcome: Callable[[Outcome], None]
) -> list[Outcome]:
    """Try the mutants of each entity until its share compiled; on_outcome sees each one that did."""
    tests = {entity: relevant_tests(entity, root / "rtl", root / "tb") for entity in planned}
    outcomes = []
    with ThreadPoolExecutor(jobs) as pool:

        def start(entity: str):
            mutant = planned[entity][1].pop(0)
            return pool.submit(try_mutant, mutant, root, tests[entity], TIMEOUT_S), entity

        left = {entity: len(order) for entity, (_, order) in planned.items()}
        running = dict(start(entity) for entity, (share, _) in planned.items() for _ in range(min(share, left[entity])))
        while running:
            done = next(as_completed(running))
            entity, outcome = running.pop(done), done.result()
            if outcome.result == INVALID:
                running |= dict([start(entity)] if planned[entity][1] else [])
                continue
            outcomes.append(outcome)
            on_outcome(outcome)
    return outcomes


def reasons(path: Path) -> dict[tuple[str, str, str], str]:
    """Why a mutant changes nothing: (entity, line before, line after) -> reason, from a TOML file."""
    entries = tomllib.loads(path.read_text())["equivalent"]
    return {(entry["entity"], entry["good"], entry["bad"]): entry["reason"] for entry in entries}


def markdown(outcomes: list[Outcome], equivalent: dict[tuple[str, str, str], str], seed: int) -> str:
    """Two tables: outcomes by entity, and every survivor with its reason."""
    lines = [
        INTRODUCTION,
        "| entity | planted | caught | of these by time-out | survived | of these equivalent |",
        "|---|---|---|---|---|---|",
    ]
    for entity in [*sorted({outcome.mutant.entity for outcome in outcomes}), "all"]:
        of_entity = [o for o in outcomes if entity in (o.mutant.entity, "all")]
        n = {result: sum(o.result == result for o in of_entity) for result in (CAUGHT, TIMEOUT, SURVIVED)}
        n_known = sum(o.result == SURVIVED and _key(o.mutant) in equivalent for o in of_entity)
        caught = n[CAUGHT] + n[TIMEOUT]
        lines += [f"| {entity} | {len(of_entity)} | {caught} | {n[TIMEOUT]} | {n[SURVIVED]} | {n_known} |"]
    survivors = [o.mutant for o in outcomes if o.result == SURVIVED]
    lines += ["", f"Seed {seed}; caught: {100 * (1 - len(survivors) / max(len(outcomes), 1)):.1f} %."]
    if survivors:
        lines += ["", "| survivor | line | became | why nothing changes |", "|---|---|---|---|"]
    for m in sorted(survivors, key=lambda m: m.name):
        lines += [f"| {m.entity}:{m.line} | `{m.good}` | `{m.bad}` | {equivalent.get(_key(m), '**not explained**')} |"]
    return "\n".join(lines) + "\n"


def _key(mutant: Mutant) -> tuple[str, str, str]:
    return mutant.entity, mutant.good, mutant.bad
