"""A campaign over the entities of rtl/: drawn by seed, tried in parallel, told as a table."""

import os
import tempfile
import tomllib
from collections.abc import Callable, Container, Iterable
from concurrent.futures import as_completed
from pathlib import Path

from gravcomp.errors import InputError
from gravcomp.parallel import executor
from gravcomp_lab.mutation import equivalence
from gravcomp_lab.mutation.mutants import Mutant, draw
from gravcomp_lab.mutation.trial import (
    CAUGHT,
    EQUIVALENT,
    INVALID,
    SURVIVED,
    TIMEOUT,
    Outcome,
    relevant_tests,
    run_tests,
    try_mutant,
)
from gravcomp_lab.mutation.verdicts import Verdicts, file_of
from gravcomp_lab.synthesis.verilog import handwritten_sources

# Of the quick tests of a fault, and of its slow ones: without a failure by then there is no verdict. Of one
# test, after which it has failed: four times what the longest takes.
TIMEOUT_S, TEST_TIMEOUT_S = 900.0, 400.0
_OPEN = (SURVIVED, TIMEOUT)

INTRODUCTION = """\
# Mutation tests

Written by `make mutate`. Each mutant is the VHDL with one small fault: an operator, a constant, a bit, a condition, a
comparison, a width, a sign, or an assignment that is gone. Mutants are drawn by seed; the share of an entity goes
with the square root of the faults that fit into it; what GHDL does not analyse or elaborate is not counted. The tests
in which the entity runs follow each other, those first that caught its faults before, then its own, those of gc_core
and the tops last, then the proofs, until one fails. A test that hangs fails by its time limit; where all pass for 15
min, there is no verdict. One that passes the first file is compared with the VHDL as it is, as Verilog of
gc_serial_system with 1, 4 and 20 lanes, with and without loading, and with every guard; an entity that is in none of
these, by itself, with its defaults and the generics of its proofs: the same netlist, or modules that Yosys proves
equal, change nothing, and no further test is run. One that is argued to change nothing is tried on the files alone
that caught others of its entity. Verdicts are kept in `mutation.csv`; a fault is tried again when its entity, the
tests that its verdict rests on, or the tool have changed.
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


def to_try(planned: dict[str, tuple[int, list[Mutant]]], verdicts: Verdicts) -> list[str]:
    """The entities of a plan with a fault that must be tried, because its verdict is not known."""
    return [entity for entity, (share, order) in planned.items() if not _is_known(share, order, verdicts)]


def _is_known(share: int, order: list[Mutant], verdicts: Verdicts) -> bool:
    for mutant in order:
        if share == 0:
            break
        if (outcome := verdicts.known(mutant)) is None:
            return False
        share -= outcome.result != INVALID
    return True


def known(planned: dict[str, tuple[int, list[Mutant]]], verdicts: Verdicts) -> list[Outcome]:
    """What is known of the faults of a plan, without a trial; those that did not compile do not count for a share."""
    outcomes = []
    for share, order in planned.values():
        found = [outcome for mutant in order if (outcome := verdicts.known(mutant)) and outcome.result != INVALID]
        outcomes += found[:share]
    return outcomes


def check_baseline(root: Path, entities: Iterable[str], build: Path) -> None:
    """Raise InputError unless the tests that shall catch the mutants pass on the VHDL as it is."""
    files = sorted({file for entity in entities for file in relevant_tests(entity, root / "rtl", root / "tb")})
    result, test = run_tests(root, root / "rtl", build, files, 4 * TIMEOUT_S)
    if result != SURVIVED:
        raise InputError(f"without any fault {test or 'the tests'} {result}; make the tests pass first")


def run(
    root: Path,
    planned: dict[str, tuple[int, list[Mutant]]],
    jobs: int,
    verdicts: Verdicts,
    on_outcome: Callable[[Outcome], None],
    argued: Container[tuple[str, str, str]] = (),
    backend: str = "threading",
) -> list[Outcome]:
    """Try the mutants of each entity until its share compiled, but those whose verdict still holds; on_outcome sees
    each one that compiled. Test files that caught faults of the entity, just now too, come first; faults in argued, as
    reasons has them, are tried on these alone.
    """
    tests = {entity: relevant_tests(entity, root / "rtl", root / "tb") for entity in planned}
    outcomes, every = [], []
    with executor(backend, jobs) as pool, tempfile.TemporaryDirectory(prefix="originals-") as folder:
        if to_try(planned, verdicts):
            equivalence.write_originals(root / "rtl", Path(folder))

        def outcome_of(mutant: Mutant, entity: str) -> Outcome:
            if outcome := verdicts.known(mutant):
                return outcome
            os.environ["PYTEST_TIMEOUT"] = str(TEST_TIMEOUT_S)
            killers = verdicts.killers(entity)
            order = _ordered(tests[entity], killers)
            if _key(mutant) in argued:
                order = [test for test in order if file_of(test) in killers] or order[:1]
            return try_mutant(mutant, root, order, TIMEOUT_S, Path(folder))

        def start(entity: str):
            return pool.submit(outcome_of, planned[entity][1].pop(0), entity), entity

        left = {entity: len(order) for entity, (_, order) in planned.items()}
        running = dict(start(entity) for entity, (share, _) in planned.items() for _ in range(min(share, left[entity])))
        while running:
            done = next(as_completed(running))
            entity, outcome = running.pop(done), done.result()
            every.append(outcome)
            if outcome.result == INVALID:
                running |= dict([start(entity)] if planned[entity][1] else [])
                continue
            outcomes.append(outcome)
            on_outcome(outcome)
            verdicts.keep(every)
    return outcomes


def _ordered(tests: list[str], first: list[str]) -> list[str]:
    """Tests, those of the files that come first before the others."""
    rank = {file: k for k, file in enumerate(first)}
    return sorted(tests, key=lambda test: rank.get(file_of(test), len(rank)))


def reasons(path: Path) -> dict[tuple[str, str, str], str]:
    """Why a mutant changes nothing: (entity, line before, line after) -> reason, from a TOML file."""
    entries = tomllib.loads(path.read_text())["equivalent"]
    return {(entry["entity"], entry["good"], entry["bad"]): entry["reason"] for entry in entries}


def markdown(outcomes: list[Outcome], equivalent: dict[tuple[str, str, str], str], seed: int, n_drawn: int) -> str:
    """Two tables: outcomes by entity, and every survivor with its reason; n_drawn: faults of the draw, tried or not."""
    lines = [
        INTRODUCTION,
        "| entity | planted | caught | proven equivalent | survived | no verdict in time | of these two explained |",
        "|---|---|---|---|---|---|---|",
    ]
    for entity in [*sorted({outcome.mutant.entity for outcome in outcomes}), "all"]:
        of_entity = [o for o in outcomes if entity in (o.mutant.entity, "all")]
        n = {result: sum(o.result == result for o in of_entity) for result in (CAUGHT, TIMEOUT, SURVIVED, EQUIVALENT)}
        n_known = sum(o.result in _OPEN and _key(o.mutant) in equivalent for o in of_entity)
        counts = len(of_entity), n[CAUGHT], n[EQUIVALENT], n[SURVIVED], n[TIMEOUT], n_known
        lines += [f"| {entity} | {' | '.join(map(str, counts))} |"]
    left = sorted((o for o in outcomes if o.result in (*_OPEN, EQUIVALENT)), key=lambda o: o.mutant.name)
    n_open = sum(o.result in _OPEN and _key(o.mutant) not in equivalent for o in left)
    share = 100 * (1 - n_open / max(len(outcomes), 1))
    lines += ["", f"Seed {seed}; tried: {len(outcomes)} of {n_drawn} faults; caught or equivalent: {share:.1f} %."]
    if len(outcomes) < n_drawn:
        lines += ["", "What is not tried yet may be what takes longest to be caught: the share says nothing of it."]
    if left:
        lines += [
            "",
            "| not caught | line | became | why nothing changes | proven or argued |",
            "|---|---|---|---|---|",
        ]
    for outcome in left:
        m, argument = outcome.mutant, equivalent.get(_key(outcome.mutant), "**not explained**")
        why = (outcome.test, "proven") if outcome.result == EQUIVALENT else (argument, "argued")
        lines += [f"| {m.entity}:{m.line} | `{m.good}` | `{m.bad}` | {why[0]} | {why[1]} |"]
    return "\n".join(lines) + "\n"


def _key(mutant: Mutant) -> tuple[str, str, str]:
    return mutant.entity, mutant.good, mutant.bad
