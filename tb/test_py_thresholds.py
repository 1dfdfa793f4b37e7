"""The table of thresholds: every number that the diagnosis decides by stands there, with where it comes from."""

import ast
import io
import re
import tokenize

import pytest

from codes import ROOT
from gravcomp.diagnosis.effects import EFFECTS, effect_named
from gravcomp.diagnosis.thresholds import COMPLEXITY
from gravcomp_lab import __main__ as lab
from gravcomp_lab.blind import sensitivity

DIAGNOSIS = ROOT / "sim" / "gravcomp" / "diagnosis"
TABLE = DIAGNOSIS / "thresholds.py"
LOGS = ROOT / "sim" / "gravcomp" / "logs"
TABLES = [TABLE, LOGS / "thresholds.py"]
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
    "path",
    [p for p in [*sorted(DIAGNOSIS.rglob("*.py")), LOGS / "measurement.py"] if p != TABLE and p.name not in PICTURES],
    ids=lambda p: p.stem,
)
def test_no_module_of_the_diagnosis_has_a_threshold_of_its_own(path):
    assert not set(numbers(path.read_text())) - FORMS, f"{path.name}: move them into thresholds.py, with their source"


def test_no_effect_has_a_price_of_its_own():
    for path in (DIAGNOSIS / "effects").glob("*.py"):
        for kind in (node for node in ast.parse(path.read_text()).body if isinstance(node, ast.ClassDef)):
            assert not numbers("\n".join(map(ast.unparse, kind.body))), (
                f"{kind.name}: a level of COMPLEXITY in {TABLE.name}"
            )
    assert {kind.complexity for kind in EFFECTS} <= {*COMPLEXITY}


def test_measurements_decide_by_no_number_of_their_own():
    """Numbers that are none: 0, 1, 2 and halves of an equation, the order of a difference."""
    found = [node for node in ast.walk(ast.parse((LOGS / "measurement.py").read_text()))
             if isinstance(node, ast.Constant) and type(node.value) in (int, float)]  # fmt: skip
    assert {node.value for node in found} <= {0, 1, 2, 0.5, 4}


@pytest.mark.parametrize("table", TABLES, ids=lambda path: path.parent.name)
def test_every_threshold_says_where_it_comes_from(table):
    text = table.read_text()
    commented = {t.start[0] for t in tokenize.generate_tokens(io.StringIO(text).readline) if t.type == tokenize.COMMENT}
    lines = text.splitlines()
    silent = [lines[node.lineno - 1] for node in ast.parse(text).body
              if isinstance(node, ast.Assign) and not commented & {node.lineno, node.end_lineno}]  # fmt: skip
    assert not silent


def test_every_threshold_is_used():
    code = "\n".join(path.read_text() for path in [*DIAGNOSIS.rglob("*.py"), *LOGS.rglob("*.py")] if path not in TABLES)
    names = [name for table in TABLES for name in numbers(table.read_text())]
    assert [name for name in names if not re.search(rf"\b{name}\b", code)] == []


def test_sensitivity_scales_a_threshold_wherever_it_is_held():
    from gravcomp.diagnosis import thresholds
    from gravcomp.diagnosis.search import rules, search
    from gravcomp.logs import thresholds as of_logs

    usual = thresholds.TIE, search.BEAM_WIDTH
    price, level = effect_named("backlash").price, thresholds.COMPLEXITY["uncommon"]
    with sensitivity.scaled("TIE", 2.0):
        assert rules.TIE == 2.0 * usual[0] == thresholds.TIE
    with sensitivity.scaled("BEAM_WIDTH", 0.1):
        assert search.BEAM_WIDTH == 1  # a count stays one
    with sensitivity.scaled("COMPLEXITY", 2.0):
        assert effect_named("backlash").price == price + level
    with sensitivity.scaled("HELD", 0.5):
        assert of_logs.HELD == 0.35
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
