"""Independent work over processes, threads, or the workers of a Dask cluster.

A cluster's workers have this package and the same files as the host that starts the work, as on one machine or with one
shared folder; the scheduler is the one that DASK_SCHEDULER_ADDRESS names.
"""

import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import contextmanager, nullcontext

from joblib import Parallel, delayed, parallel_config
from joblib.parallel import BACKENDS
from threadpoolctl import threadpool_limits
from tqdm import tqdm

from gravcomp.errors import InputError, optional

DASK = "dask"
WHERE = ("threading", DASK)  # of executor
ADDRESS = "DASK_SCHEDULER_ADDRESS"
_TIMEOUT_S = 20


@contextmanager
def cluster() -> Iterator:
    """A dask.distributed.Client of the cluster that DASK_SCHEDULER_ADDRESS names. Raises InputError."""
    distributed = optional("distributed", "distributed", "--backend dask")
    address = os.environ.get(ADDRESS)
    if not address:
        raise InputError(f"--backend dask: {ADDRESS} is not set; give it the scheduler, such as tcp://host:8786")
    try:
        client = distributed.Client(address, timeout=_TIMEOUT_S)
    except (OSError, TimeoutError, ValueError) as error:
        raise InputError(
            f"--backend dask: no scheduler answers at {address} ({type(error).__name__}); correct {ADDRESS}, or start "
            "`dask scheduler` there"
        ) from error
    with client:
        if not client.scheduler_info()["workers"]:
            raise InputError(f"--backend dask: the cluster at {address} has no workers; start `dask worker {address}`")
        yield client


def _client_of(backend: str):
    return cluster() if backend == DASK else nullcontext()


@contextmanager
def executor(backend: str, jobs: int) -> Iterator[Executor]:
    """Of concurrent.futures: jobs threads, for work that waits for other programs; or all workers of the cluster."""
    if backend != DASK:
        with ThreadPoolExecutor(jobs) as pool:
            yield pool
        return
    with cluster() as client:
        yield client.get_executor(pure=False)


def run_parallel(
    function: Callable, arguments: list[tuple], backend: str, title: str, jobs: int = -1, delay_s: float = 0.0
) -> list:
    """[function(*a) for a in arguments] over jobs cores (-1: all), with a progress bar. Raises InputError."""
    with (
        tqdm(total=len(arguments), desc=title, delay=delay_s) as bar,
        _client_of(backend),
        parallel_config(backend=_Workers() if backend == "loky" else backend, n_jobs=jobs),
        one_blas_thread(),
    ):
        return _ProgressParallel(bar)(delayed(_on_one_thread)(function, a) for a in arguments)


def one_blas_thread():
    """Context in which BLAS keeps to one thread: on matrices this small more threads cost time, and change rounding."""
    return threadpool_limits(limits=1, user_api="blas")


def _on_one_thread(function: Callable, arguments: tuple):
    with one_blas_thread():
        return function(*arguments)


class _Workers(BACKENDS["loky"]):
    """Processes that Ctrl-C of a terminal does not reach: this one alone hears it, and ends them. One that is told
    while it begins would end in a traceback, and this one wait for it."""

    def configure(self, *args, **options):
        n_jobs = super().configure(*args, **options)
        with _deaf():
            self._workers.submit(os.getpid)  # starts them all
        return n_jobs


@contextmanager
def _deaf() -> Iterator[None]:
    """What starts meanwhile never hears an interrupt; this process hears it at the end."""
    if threading.current_thread() is not threading.main_thread() or not hasattr(signal, "pthread_sigmask"):
        yield
        return
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})  # blocked, it waits though it is ignored
    handler = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


class _ProgressParallel(Parallel):
    def __init__(self, bar: tqdm):
        super().__init__()
        self.bar = bar

    def print_progress(self):
        self.bar.update(self.n_completed_tasks - self.bar.n)
