"""Trial of one mutant: a copy of rtl/ with the fault in it, compiled, then tested until the first failure."""

import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from gravcomp_lab.formal.claims import CLAIMS
from gravcomp_lab.mutation import equivalence
from gravcomp_lab.mutation.mutants import Mutant
from gravcomp_lab.synthesis.verilog import handwritten_sources, rtl_sources, source_of

CAUGHT, TIMEOUT, SURVIVED, INVALID = "caught", "time-out", "survived", "does not compile"
EQUIVALENT = "equivalent"
# For each of analysis and elaboration, which take a second or two: a loop in a function may have lost its end.
COMPILE_TIMEOUT_S = 60.0
# The faults that these files plant themselves have nothing to do with a mutant; netlists, figures and long runs of what
# other files test.
LEFT_OUT = (
    "test_rtl_formal.py",
    "test_rtl_formal_planted.py",
    "test_rtl_formal_equivalence.py",
    "test_rtl_gates.py",
    "test_rtl_hil.py",
    "test_rtl_budget.py",
    "test_rtl_loop.py",
    "test_rtl_poses.py",
)


@dataclass(frozen=True)
class Outcome:
    """What became of a mutant, the test that caught it or how it is proven to change nothing, and seconds it took."""

    mutant: Mutant
    result: str
    test: str = ""
    seconds: float = 0.0


def relevant_tests(entity: str, rtl: Path, tb: Path) -> list[str]:
    """Tests in which the entity runs: its own file, the claims about it, files of what instantiates it, and so on, last
    the claims about all that holds it.
    """
    texts = {user: path.read_text() for user, path in handwritten_sources(rtl).items()}
    test_texts = {p.name: _with_its_modules(p, tb) for p in sorted(tb.glob("test_rtl_*.py")) if p.name not in LEFT_OUT}
    own = f"test_rtl_{entity.removeprefix('gc_')}.py"
    order, seen, level = [own] if own in test_texts else [], [entity], [entity]
    order += _claims_about(entity)
    while level:
        for name in level:
            order += [file for file, text in test_texts.items() if re.search(rf'"{name}(_bench)?"', text)]
        users = {user for user, text in texts.items() for name in level if re.search(rf"\bwork\.{name}\b", text)}
        level = sorted(users.difference(seen))
        seen += level
    return list(dict.fromkeys([*order, *(test for user in seen for test in _claims_about(user))]))


def _with_its_modules(file: Path, tb: Path) -> str:
    """The text of a test, and of the modules of tb/support and of the benches that it imports, which may name the
    entity for it.
    """
    folders = {"support": tb / "support", "gravcomp_lab.benches": tb.parent / "sim" / "gravcomp_lab" / "benches"}
    texts, todo = {}, [file]
    while todo:
        path = todo.pop()
        if path in texts or not path.is_file():
            continue
        texts[path] = path.read_text()
        for package, name in re.findall(
            r"^from (support|gravcomp_lab\.benches)\.(\w+) import", texts[path], re.MULTILINE
        ):
            todo.append(folders[package] / f"{name}.py")
    return "".join(texts.values())


def _claims_about(entity: str) -> list[str]:
    """The tests that prove the claims about an entity."""
    return [f"test_rtl_formal.py::test_claim_is_proven[{c.name}]" for c in CLAIMS if c.entity == entity]


def try_mutant(
    mutant: Mutant, root: Path, tests: list[str], timeout_s: float, originals: Path | None = None
) -> Outcome:
    """Plant a mutant in a copy of root's rtl/ and run test files of tb/ on it until one fails.

    originals: as of equivalence.proof, which is asked once the first file has passed; a proof ends the trial.
    """
    start = time.monotonic()
    result, test = _try(mutant, root, tests, timeout_s, originals)
    return Outcome(mutant, result, test, round(time.monotonic() - start, 1))


def _try(mutant: Mutant, root: Path, tests: list[str], timeout_s: float, originals: Path | None) -> tuple[str, str]:
    with tempfile.TemporaryDirectory(prefix="mutant-") as folder:
        rtl = Path(folder) / "rtl"
        shutil.copytree(root / "rtl", rtl)
        source = source_of(rtl, mutant.entity)
        source.write_text(mutant.plant(source.read_text()))
        if not compiles(rtl, folder):
            return INVALID, ""
        build = Path(folder) / "build"
        if originals:
            result, test = _run_marked(root, rtl, build, tests[:1], "not slow", timeout_s)
            if result != SURVIVED:
                return result, test
            if how := equivalence.proof(originals, rtl, mutant.entity, Path(folder)):
                return EQUIVALENT, how
        return run_tests(root, rtl, build, tests, timeout_s)


def run_tests(root: Path, rtl: Path, build: Path, files: Sequence[str], timeout_s: float) -> tuple[str, str]:
    """Run test files of tb/ on a folder rtl until one fails, the slow ones last: what came of it, and the test.

    The tests that plant faults themselves are left out: on a mutant they find other lines than they expect.
    timeout_s: of the quick tests, and of the slow ones.
    """
    for marker in ("not slow", "slow"):
        result, test = _run_marked(root, rtl, build, files, marker, timeout_s)
        if result != SURVIVED:
            return result, test
    return SURVIVED, ""


def _run_marked(root: Path, rtl: Path, build: Path, files: Sequence[str], marker: str, timeout_s: float):
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-m", marker]
    command += ["-k", "not planted", *(str(root / "tb" / file) for file in files)]
    # Neither the tests after a failure nor, within a test, the simulations.
    variables = {"COCOTB_MAX_FAILURES": 1}
    variables |= {"GRAVCOMP_RTL": rtl.resolve(), "GRAVCOMP_BUILD": build.resolve(), "PYTHONPATH": root / "sim"}
    environment = {**os.environ, **{name: str(value) for name, value in variables.items()}}
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    run = subprocess.Popen(command, cwd=root, env=environment, start_new_session=True, **pipes)
    try:
        log, _ = run.communicate(timeout=timeout_s)
    except subprocess.TimeoutExpired:
        os.killpg(run.pid, signal.SIGKILL)
        run.communicate()
        return TIMEOUT, ""
    if run.returncode in (0, 5):  # 5: nothing selected
        return SURVIVED, ""
    failed = re.search(r"^(?:FAILED|ERROR) \S*?(test_\w+\.py\S*)", log, re.MULTILINE)
    return CAUGHT, failed[1] if failed else log[-300:]


def compiles(rtl: Path, work: str) -> bool:
    """Whether GHDL analyses the files and elaborates the top that holds every entity, in COMPILE_TIMEOUT_S each."""
    files = [str(path) for path in rtl_sources(rtl)]
    options = ["--std=08", f"--workdir={work}"]
    for command in (["-a", *options, *files], ["--elab-run", *options, equivalence.TOP, "--stop-time=0ns"]):
        try:
            subprocess.run(["ghdl", *command], cwd=work, capture_output=True, check=True, timeout=COMPILE_TIMEOUT_S)
        except (subprocess.CalledProcessError, subprocess.TimeoutExpired):
            return False
    return True
