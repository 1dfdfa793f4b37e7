"""Small faults that can be planted in VHDL: one edit of one line each."""

import hashlib
import re
from dataclasses import dataclass

import numpy as np

# What a fault turns into what; all in code, none in comments, strings or declarations of ports.
_NUMBER = r"(?<![\w.\"'#])\d+(?![\w.\"'#])"
_RULES = (
    ("operator", r" \+ ", lambda m: " - "),
    ("operator", r" - ", lambda m: " + "),
    ("logic", r"\band\b", lambda m: "or"),
    ("logic", r"\bor\b", lambda m: "and"),
    ("logic", r"\bxor\b", lambda m: "or"),
    ("logic", r"\bnot ", lambda m: ""),
    ("bit", r"'0'", lambda m: "'1'"),
    ("bit", r"'1'", lambda m: "'0'"),
    ("constant", _NUMBER, lambda m: str(int(m[0]) + 1)),
    ("constant", _NUMBER, lambda m: str(int(m[0]) - 1)),
    ("condition", r"(?<=if )[^;]+(?= then$)", lambda m: "true"),
    ("condition", r"(?<=if )[^;]+(?= then$)", lambda m: f"not ({m[0]})"),
    ("comparison", r"(?<=[\w)]) = (?=[\w'(])", lambda m: " /= "),
    ("comparison", r" /= ", lambda m: " = "),
    ("comparison", r" > ", lambda m: " >= "),
    ("comparison", r" >= ", lambda m: " > "),
    ("comparison", r"(?<=[\w)]) < ", lambda m: " <= "),
    ("width", r"\bdownto\b", lambda m: "+ 1 downto"),
    ("width", r"_bits_[cg]\b", lambda m: f"{m[0]} - 1"),
    ("signedness", r"\bresize\((\w+), ([\w +*-]+)\)", lambda m: f"signed(resize(unsigned({m[1]}), {m[2]}))"),
    ("signedness", r"\bshift_right\((\w+), (\w+)\)", lambda m: f"signed(shift_right(unsigned({m[1]}), {m[2]}))"),
    ("assignment", r"\S+ <= [^;]*;$", lambda m: "null;"),
    ("assignment", r"\S+ := [^;]*;$", lambda m: "null;"),
)  # fmt: skip


@dataclass(frozen=True)
class Mutant:
    """A fault: line number (from 1) of an entity's file, that line before and after, without indentation, its kind."""

    entity: str
    line: int
    good: str
    bad: str
    kind: str

    @property
    def name(self) -> str:
        digest = hashlib.sha256(f"{self.line} {self.good} {self.bad}".encode()).hexdigest()[:8]
        return f"{self.entity}-{self.line}-{digest}"

    def plant(self, text: str) -> str:
        """The file's text with the fault in it; ValueError when the line is another."""
        lines = text.split("\n")
        old = lines[self.line - 1]
        if old.strip() != self.good:
            raise ValueError(f"{self.entity}, line {self.line}: expected {self.good!r}, got {old.strip()!r}")
        lines[self.line - 1] = old.replace(self.good, self.bad)
        return "\n".join(lines)


def candidates(entity: str, text: str) -> list[Mutant]:
    """Every fault that can be planted in the architecture or package body of a VHDL file."""
    found = {}
    for number, line in _body(text):
        for kind, pattern, change in _RULES:
            for match in re.finditer(pattern, line):
                bad = line[: match.start()] + change(match) + line[match.end() :]
                found.setdefault(bad.strip() + str(number), Mutant(entity, number, line.strip(), bad.strip(), kind))
    return [mutant for mutant in found.values() if mutant.good != mutant.bad]


def draw(texts: dict[str, str], n_mutants: int, seed: int) -> dict[str, tuple[int, list[Mutant]]]:
    """How many mutants to plant in each entity, about n_mutants in all, and its candidates in the order of trial.

    texts: VHDL by entity. The share of an entity goes with the square root of its candidates: small ones count, too.
    """
    every = {entity: found for entity, text in sorted(texts.items()) if (found := candidates(entity, text))}
    root_sum = sum(len(found) ** 0.5 for found in every.values())
    share = {entity: round(n_mutants * len(found) ** 0.5 / root_sum) for entity, found in every.items()}
    return {entity: (share[entity], _shuffled(found, entity, seed)) for entity, found in every.items()}


def _shuffled(found: list[Mutant], entity: str, seed: int) -> list[Mutant]:
    """In an order that no other entity's text changes."""
    rng = np.random.default_rng([seed, *entity.encode()])
    return [found[k] for k in rng.permutation(len(found))]


def _body(text: str) -> list[tuple[int, str]]:
    """Numbered lines of code after the declaration of the entity or package; without comments, asserts, labels."""
    lines, inside, in_assert = [], False, False
    for number, line in enumerate(text.split("\n"), start=1):
        inside = inside or bool(re.match(r"(architecture|package body)\b", line))
        code = line.split("--")[0].rstrip()
        in_assert = in_assert or bool(re.match(r"\s*assert\b", code))
        is_code = inside and code.strip() and not in_assert
        if is_code and '"' not in code and not re.match(r"\s*(end|attribute|library|use|signal|type)\b", code):
            lines.append((number, code))
        if code.endswith(";"):
            in_assert = False
    return lines
