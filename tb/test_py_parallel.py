"""Work on a Dask cluster: a scheduler and workers of dask.distributed in processes of their own."""

import os
import pickle
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from gravcomp.cli import main
from gravcomp.errors import InputError
from gravcomp.parallel import ADDRESS, executor, run_parallel
from gravcomp.training.training import Effort, train, workspace_set
from gravcomp_lab.blind import from_model, tally
from gravcomp_lab.mutation.mutants import Mutant
from gravcomp_lab.mutation.verdicts import Verdicts
from machines import MACHINE, SHIPPED

SHORT = Effort(draws=2, tied_hops=2, hops=2, search_poses=100)


@pytest.fixture(scope="module")
def address():
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        yield cluster.scheduler_address


@pytest.fixture
def cluster(address, monkeypatch):
    monkeypatch.setenv(ADDRESS, address)


def identity(number: int) -> tuple[int, int]:
    return number, os.getpid()


def fail(number: int):
    raise InputError(f"{number} is wrong; give another")


def test_workers_do_the_work_in_order(cluster):
    found = run_parallel(identity, [(k,) for k in range(6)], "dask", "test")
    assert [number for number, _ in found] == list(range(6))
    assert os.getpid() not in {pid for _, pid in found}


def test_networks_of_the_cluster_are_those_of_the_processes_here(cluster):
    data = workspace_set(120, MACHINE.robot, 1)
    here, there = (
        train(data, MACHINE, n_hidden=5, n_starts=2, seed=3, backend=backend, effort=SHORT)[0]
        for backend in ("threading", "dask")
    )
    np.testing.assert_array_equal(here.hidden_weights, there.hidden_weights)
    np.testing.assert_array_equal(here.output_weights, there.output_weights)


def test_blind_sets_are_diagnosed_by_the_cluster(cluster, tmp_path, monkeypatch):
    monkeypatch.setattr(from_model, "CASES", ("clean",))
    (outcome,) = tally.run_all(tally.tasks(1, 0, 0, 7000), tmp_path, -1, "dask")
    assert (outcome.kind, outcome.seed) == ("clean", 7000)


def test_runs_of_programs_go_to_the_workers_and_failures_come_back(cluster):
    with executor("dask", 1) as pool:
        assert pool.submit(identity, 3).result()[1] != os.getpid()
        with pytest.raises(InputError, match="7 is wrong"):
            pool.submit(fail, 7).result()


def test_what_a_fault_is_tried_with_can_be_sent(tmp_path):
    (tmp_path / "rtl").mkdir()
    verdicts = Verdicts(tmp_path / "none.csv", tmp_path)
    fields = {name: "x" for name in Mutant.__dataclass_fields__}
    for sent in (verdicts, Mutant(**fields)):
        pickle.loads(pickle.dumps(sent))


def test_threads_here_need_no_cluster(monkeypatch):
    monkeypatch.delenv(ADDRESS, raising=False)
    with executor("threading", 2) as pool:
        assert pool.submit(identity, 3).result() == (3, os.getpid())


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("", f"{ADDRESS} is not set; give it the scheduler"),
        ("tcp://127.0.0.1:9", "no scheduler answers at tcp://127.0.0.1:9"),
        ("nonsense", "no scheduler answers at nonsense"),
    ],
)
def test_cluster_that_is_not_there_is_one_line_and_status_2(monkeypatch, capfd, tmp_path, value, said):
    pytest.importorskip("distributed")
    monkeypatch.setenv(ADDRESS, value)
    monkeypatch.setattr("gravcomp.parallel._TIMEOUT_S", 1)
    arguments = ["train", "--robot", str(SHIPPED), "--backend", "dask", "--poses", "100", "--hidden", "4"]
    assert main([*arguments, "--out", str(tmp_path / "out")]) == 2
    last = capfd.readouterr().err.strip().splitlines()[-1]
    assert last.startswith("gravcomp train: ")
    assert said in last
    assert not (tmp_path / "out").exists()


# A task that tells that it runs, then waits; what the terminal's Ctrl-C leaves of it.
WAITS = """
import sys, time
from pathlib import Path
from gravcomp.parallel import run_parallel

def wait(folder, k):
    Path(folder, str(k)).touch()
    time.sleep(600)

try:
    run_parallel(wait, [(sys.argv[1], k) for k in range(4)], "loky", "test", jobs=2)
except KeyboardInterrupt:
    sys.exit("stopped")
"""


def hears() -> bool:
    return signal.getsignal(signal.SIGINT) is not signal.SIG_IGN


def test_workers_do_not_hear_the_interrupt_that_this_process_hears():
    assert not any(run_parallel(hears, [()] * 4, "loky", "test", jobs=2))
    assert hears()


@pytest.mark.parametrize("at", ["the first worker", "a task"])
def test_interrupt_of_a_terminal_ends_workers_without_a_traceback(at, tmp_path):
    """A terminal tells the whole group, here as the first worker begins and as tasks run."""
    process = subprocess.Popen([sys.executable, "-c", WAITS, tmp_path], stderr=subprocess.PIPE, text=True,
                               start_new_session=True)  # fmt: skip
    children = f"/proc/{process.pid}/task/{process.pid}/children"
    until = time.monotonic() + 120.0
    while not (any(tmp_path.iterdir()) if at == "a task" else Path(children).read_text()):
        assert process.poll() is None
        assert time.monotonic() < until
        time.sleep(0.01)
    os.killpg(process.pid, signal.SIGINT)
    _, told = process.communicate(timeout=120)
    assert process.returncode == 1
    assert told.splitlines()[-1] == "stopped"
    assert "Traceback" not in told
