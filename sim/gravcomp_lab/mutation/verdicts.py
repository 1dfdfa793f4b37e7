"""What became of each fault, kept in a table: a fault is tried again only when what its verdict rests on has changed.

A verdict rests on the entity's file, on the test that caught the fault, or on all tests that did not, and on the tool,
of which the proof that nothing changes has no part in a fault that was caught.
"""

from collections.abc import Iterable
from pathlib import Path

from gravcomp_lab.formal.claims import CLAIMS
from gravcomp_lab.mutation.kept import Keys, read_lines, write_lines
from gravcomp_lab.mutation.mutants import Mutant
from gravcomp_lab.mutation.trial import CAUGHT, TIMEOUT, Outcome, relevant_tests
from gravcomp_lab.synthesis.verilog import source_of

_COLUMNS = ("entity", "line", "kind", "good", "bad", "result", "test", "seconds", "key")
_TOOL = ("mutants.py", "trial.py")
_PROOF = "equivalence.py"


class Verdicts:
    """The table in a CSV file, for the tree in root, which is read once."""

    def __init__(self, path: Path, root: Path):
        self._path, self._root, self._keys, self._relevant = path, root, Keys(), {}
        self._kept = {self._name(line): line for line in read_lines(path)}
        self._table = self._kept  # as it was last written

    def known(self, mutant: Mutant) -> Outcome | None:
        """The verdict on a fault, when nothing that it rests on has changed."""
        line = self._kept.get((mutant.entity, str(mutant.line), mutant.good, mutant.bad))
        outcome = line and Outcome(mutant, line["result"], line["test"], float(line["seconds"]))
        return outcome if outcome and line["key"] == self._key(outcome) else None

    def killers(self, entity: str) -> list[str]:
        """Test files that caught faults of the entity, just now too, the quickest first."""
        took: dict[str, list[float]] = {}
        for line in self._table.values():
            if line["entity"] == entity and line["result"] == CAUGHT:
                took.setdefault(file_of(line["test"]), []).append(float(line["seconds"]))
        return sorted(took, key=lambda file: (-len(took[file]), sum(took[file])))

    def keep(self, outcomes: Iterable[Outcome]) -> None:
        """Write the table with these verdicts, and no others of their entities; a trial whose time was up has none."""
        outcomes = [outcome for outcome in outcomes if outcome.result != TIMEOUT]
        entities = {outcome.mutant.entity for outcome in outcomes}
        table = {name: line for name, line in self._kept.items() if line["entity"] not in entities}
        for outcome in outcomes:
            m = outcome.mutant
            values = m.entity, m.line, m.kind, m.good, m.bad, outcome.result, outcome.test, outcome.seconds
            line = dict(zip(_COLUMNS, (*map(str, values), self._key(outcome)), strict=True))
            table[self._name(line)] = line
        in_order = sorted(table.values(), key=lambda line: (line["entity"], int(line["line"]), line["bad"]))
        write_lines(self._path, _COLUMNS, in_order)
        self._table = table

    def _key(self, outcome: Outcome) -> str:
        root, entity = self._root, outcome.mutant.entity
        tests = [outcome.test] if outcome.result == CAUGHT else self._tests(entity)
        files = [source_of(root / "rtl", entity), *dict.fromkeys(root / "tb" / file_of(test) for test in tests)]
        files += [root / "tb" / "formal" / f"{c.checker}.sv" for c in CLAIMS for test in tests if f"[{c.name}]" in test]
        tool = _TOOL if outcome.result == CAUGHT else (*_TOOL, _PROOF)
        files += [Path(__file__).with_name(name) for name in tool]
        return self._keys.of(files)

    def _tests(self, entity: str) -> list[str]:
        if entity not in self._relevant:
            self._relevant[entity] = relevant_tests(entity, self._root / "rtl", self._root / "tb")
        return self._relevant[entity]

    @staticmethod
    def _name(line: dict[str, str]) -> tuple[str, str, str, str]:
        return line["entity"], line["line"], line["good"], line["bad"]


def file_of(test: str) -> str:
    """The file of a test."""
    return test.partition("::")[0]
