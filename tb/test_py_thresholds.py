"""The table of thresholds: every number that the diagnosis decides by stands there, with where it comes from."""

import ast
import io
import re
import tokenize

import pytest

from codes import ROOT
from gravcomp_lab import __main__ as lab
from gravcomp_lab.blind import sensitivity

DIAGNOSIS = ROOT / "sim" / "gravcomp" / "diagnosis"
TABLE = DIAGNOSIS / "thresholds.py"
PICTURES = {"figures.py", "report_html.py"}  # sizes of what is drawn decide nothing
FORMS = {"SIDES", "_POWERS", "_HINGE_POWERS"}  # of a candidate, as its equation says


def numbers(source: str) -> list[str]:
    """Names that a module gives to numbers or to tuples of numbers."""
    found = []
    for node in ast.parse(source).body:
        if not isinstance(node, (ast.Assign, ast.AnnAssign)) or node.value is None:
            continue
        inside = [n for n in ast.walk(node.value) if isinstance(n, ast.Constant)]
        parts = (ast.Constant, ast.Tuple, ast.UnaryOp, ast.BinOp, ast.Name, ast.operator, ast.unaryop, ast.expr_context)
        is_number = all(isinstance(n, parts) for n in ast.walk(node.value))
        if is_number and inside and all(type(n.value) in (int, float) for n in inside):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            found += [n.id for target in targets for n in ast.walk(target) if isinstance(n, ast.Name)]
    return found


@pytest.mark.parametrize(
    ("source", "names"),
    [("A = 3", ["A"]), ("_A, B = 4, -0.5", ["_A", "B"]), ("A: float = 2.0 * TIE", ["A"]), ("A = 1.0, (2, 3)", ["A"]),
     ('A = "3"', []), ("A = f(3)", []), ("A = True", []), ("def f():\n    a = 3", [])],
)  # fmt: skip
def test_thresholds_are_found_in_any_module(source, names):
    assert numbers(source) == names


@pytest.mark.parametrize(
    "path", [p for p in sorted(DIAGNOSIS.rglob("*.py")) if p != TABLE and p.name not in PICTURES], ids=lambda p: p.stem
)
def test_no_module_of_the_diagnosis_has_a_threshold_of_its_own(path):
    assert not set(numbers(path.read_text())) - FORMS, f"{path.name}: move them into thresholds.py, with their source"


def test_every_threshold_says_where_it_comes_from():
    text = TABLE.read_text()
    commented = {t.start[0] for t in tokenize.generate_tokens(io.StringIO(text).readline) if t.type == tokenize.COMMENT}
    lines = text.splitlines()
    silent = [lines[node.lineno - 1] for node in ast.parse(text).body
              if isinstance(node, ast.Assign) and not commented & {node.lineno, node.end_lineno}]  # fmt: skip
    assert not silent


def test_every_threshold_is_used():
    code = "\n".join(path.read_text() for path in DIAGNOSIS.rglob("*.py") if path != TABLE)
    assert [name for name in numbers(TABLE.read_text()) if not re.search(rf"\b{name}\b", code)] == []


def test_sensitivity_scales_a_threshold_wherever_it_is_held():
    from gravcomp.diagnosis import thresholds
    from gravcomp.diagnosis.search import rules, search

    usual = thresholds.TIE, search.BEAM_WIDTH
    with sensitivity.scaled("TIE", 2.0):
        assert rules.TIE == 2.0 * usual[0] == thresholds.TIE
    with sensitivity.scaled("BEAM_WIDTH", 0.1):
        assert search.BEAM_WIDTH == 1  # a count stays one
    assert usual == (rules.TIE, search.BEAM_WIDTH)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["NONE"], "no threshold"),
        (["TIE", "--first-seed", "199"], "for tuning"),
        (["TIE", "--sets", "0"], "for tuning"),
    ],
)
def test_sensitivity_refuses_what_it_cannot_measure(arguments, says, capsys):
    assert lab.main(["sensitivity", *arguments]) == 2
    assert says in capsys.readouterr().err
