"""Tasks shared out: to this process, to processes of this machine, to a Dask cluster. Who does them changes no bit."""

import logging
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, TypeVar

from ..core import PamError, UsageError
from ..core.progress import part, tell

if TYPE_CHECKING:
    from distributed import Client

Task = TypeVar("Task")
Result = TypeVar("Result")
TRIES = 2
"""How many workers may die of one task before it is given up."""
ONE_THREAD = {
    **dict.fromkeys(("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"), "1"),
    "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false",
}
AHEAD = 2000
"""Tasks that wait at the scheduler, more than any cluster does at a time; all of many would fill its memory."""
ANSWER_S = 5.0
"""How long a scheduler may take to answer."""


class WorkerLost(PamError):
    """Stands in place of the result of a task whose workers were killed."""

    def __init__(self, times: int) -> None:
        super().__init__(f"its worker was killed {times} times (out of memory?); the same command tries it again")


@dataclass(frozen=True)
class Executor:
    """Who does tasks: so many `workers`, processes of this machine with one thread each, or the workers of the Dask
    scheduler at `scheduler`; this process where neither is said.

    A scheduler that goes away is waited for, up to `patience_s` seconds. Raises UsageError for what cannot be.
    """

    workers: int | None = None
    scheduler: str | None = None
    patience_s: float = 300.0

    def __post_init__(self) -> None:
        if self.workers is not None and self.scheduler is not None:
            raise UsageError("--workers with --scheduler: the cluster has its own workers; give one of the two")
        if self.workers is not None and self.workers < 1:
            raise UsageError(f"workers = {self.workers}: expected 1 or more")
        if self.scheduler is not None and find_spec("distributed") is None:
            raise UsageError("--scheduler needs Dask; pip install 'pam-ident[cluster]'")

    @classmethod
    def of_cores(cls, workers: int | None = None, scheduler: str | None = None) -> "Executor":
        """What is asked for; a process for each core where nothing is."""
        return cls(os.cpu_count() or 1 if workers is None and scheduler is None else workers, scheduler)

    def map(
        self, work: Callable[[Task], Result], tasks: Sequence[Task], what: str, before: int = 0
    ) -> Iterator[tuple[int, Result | WorkerLost]]:
        """Place in `tasks` and result of `work` of each, as they are done; both must be such as can be pickled.

        A task whose worker is killed is asked again, then given up alone. Progress is told as of `what`, of which
        `before` were done before. Raises what a task raises, and UsageError where no scheduler answers.
        """
        of = before + len(tasks)
        tell(what, before, of)
        for done, found in enumerate(self._each(work, tasks, what, before), before + 1):
            yield found
            tell(what, done, of)

    def in_order(
        self, work: Callable[[Task], Result], tasks: Sequence[Task], what: str
    ) -> Iterator[Result | WorkerLost]:
        """Results as `map` finds them, each once all before it are there."""
        found: dict[int, Result | WorkerLost] = {}
        due = 0
        for k, result in self.map(work, tasks, what):
            found[k] = result
            while due in found:
                yield found.pop(due)
                due += 1

    def all(self, work: Callable[[Task], Result], tasks: Sequence[Task], what: str) -> list[Result]:
        """The results in the order of the tasks. Raises what `map` does, and PamError where one is lost."""
        results = []
        for result in self.in_order(work, tasks, what):
            if isinstance(result, WorkerLost):
                raise PamError(f"{what}, {len(results) + 1} of {len(tasks)}: {result}")
            results.append(result)
        return results

    def _each(self, work: Callable, tasks: Sequence, what: str, before: int) -> Iterator[tuple[int, Any]]:
        if self.scheduler is not None:
            yield from _by_dask(work, tasks, self.scheduler, self.patience_s)
        elif self.workers is not None:
            yield from _by_processes(work, tasks, self.workers)
        else:
            for k, task in enumerate(tasks):
                with part(what, before + k, before + len(tasks)):
                    result = work(task)
                yield k, result


def _by_processes(work: Callable, tasks: Sequence, workers: int) -> Iterator[tuple[int, Any]]:
    """Each worker is a pool of its own, so that one that is killed breaks no other's work and its task is known."""
    waiting, deaths = deque(range(len(tasks))), Counter[int]()
    idle: list[ProcessPoolExecutor] = []
    busy: dict[Future, tuple[ProcessPoolExecutor, int]] = {}
    ready: list[tuple[int, Any]] = []
    try:
        while waiting or busy or ready:
            while waiting and len(busy) < workers:
                pool = idle.pop() if idle else ProcessPoolExecutor(1, multiprocessing.get_context("spawn"), _begin)
                try:
                    with one_thread():
                        busy[pool.submit(work, tasks[waiting[0]])] = pool, waiting[0]
                    waiting.popleft()
                except BrokenProcessPool:  # killed while it had nothing to do
                    _stop(pool)
            yield from ready
            ready = []
            for future in wait(busy, return_when=FIRST_COMPLETED).done:
                pool, k = busy.pop(future)
                try:
                    ready.append((k, future.result()))
                    idle.append(pool)
                except (BrokenProcessPool, MemoryError):
                    _stop(pool)
                    deaths[k] += 1
                    if deaths[k] < TRIES:
                        waiting.append(k)
                    else:
                        ready.append((k, WorkerLost(TRIES)))
    finally:
        for pool in [*idle, *(pool for pool, _ in busy.values())]:
            _stop(pool)


def _begin() -> None:
    """A worker leaves Ctrl-C to the process that started it, and ends with it, even where that is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None
    threading.Thread(target=lambda: (parent.join(), os._exit(1)), daemon=True).start()


def _stop(pool: ProcessPoolExecutor) -> None:
    for process in list((pool._processes or {}).values()):
        process.terminate()
    pool.shutdown()


@contextmanager
def one_thread() -> Iterator[None]:
    """Processes started inside compute on one thread, for more would only get into each other's way, and do not run the
    main script again, as a new interpreter does to find what it defines.

    All that is asked of workers is found in this package, so that a script needs no `if __name__ == "__main__":`.
    """
    environment, script = dict(os.environ), vars(sys.modules["__main__"])
    names = {name: script.pop(name) for name in ("__spec__", "__file__") if name in script}
    os.environ.update(ONE_THREAD)
    script["__spec__"] = None
    try:
        yield
    finally:
        script.update(names)
        os.environ.clear()
        os.environ.update(environment)


def _by_dask(work: Callable, tasks: Sequence, address: str, patience_s: float) -> Iterator[tuple[int, Any]]:
    """Place and result of each task, as they are done by the cluster whose scheduler is at `address`.

    What is under way as the scheduler goes is asked again once it is back; a result is told once. Raises UsageError
    where there is no scheduler, or none comes back within `patience_s` seconds.
    """
    left, wait_s = dict(enumerate(tasks)), 0.0
    while left:
        client = _client(address, wait_s)
        try:
            for k, result in _until_gone(client, work, left):
                del left[k]
                yield k, result
        finally:
            client.close(timeout=2)
        if left:
            wait_s = patience_s
            logging.getLogger(__name__).warning("the scheduler at %s is gone; waiting for it", address)


def _client(address: str, wait_s: float) -> "Client":
    from distributed import Client

    begin = time.monotonic()
    while True:
        try:
            return Client(address, timeout=ANSWER_S, set_as_default=False)
        except (OSError, ValueError) as error:
            if isinstance(error, ValueError) or time.monotonic() - begin >= wait_s:
                raise UsageError(
                    f"--scheduler {address}: no Dask scheduler answers ({str(error)[:80]}); start one by `dask "
                    "scheduler`, or leave the option out"
                ) from None
            time.sleep(1.0)


def _until_gone(client: "Client", work: Callable, left: dict[int, Any]) -> Iterator[tuple[int, Any]]:
    """Results as they come, until all are there or the scheduler is gone.

    A worker that dies takes what waits for it along, so that who killed it is known only of a task asked alone: one
    that seems to have is asked again after all others.
    """
    from distributed import CancelledError, KilledWorker, as_completed

    queue, alone, killed, asked = deque(left), deque[int](), set[int](), dict[Any, int]()
    running: Any = as_completed(loop=client.loop)
    while queue or alone or asked:
        try:
            while (queue and len(asked) < AHEAD) or (alone and not asked):
                k = (queue or alone).popleft()
                future = client.submit(work, left[k], pure=False, retries=TRIES)
                asked[future.key] = k
                running.add(future)
            future = next(running)
            if future.status in ("cancelled", "lost"):
                return
            failure, result = _outcome(future)
        except Exception as error:
            # The line can break at any instant, that between a future's status and its result included.
            if client.status == "running" and not isinstance(error, (OSError, CancelledError)):
                raise
            return
        k = asked.pop(future.key)
        if isinstance(failure, KilledWorker) and k not in killed:
            killed.add(k)
            alone.append(k)
        elif isinstance(failure, (KilledWorker, MemoryError)):
            yield k, WorkerLost(getattr(failure, "allowed_failures", TRIES) + 1)
        elif failure is not None:
            raise failure
        else:
            yield k, result


def _outcome(future: Any) -> tuple[Any, Any]:
    """What a task that is done raised, or its result: to be found anew where its worker has died with it since."""
    from distributed import KilledWorker

    if future.status == "error":
        return future.exception(), None
    try:
        return None, future.result()
    except KilledWorker as error:
        return error, None
