"""Many tasks done alike: here, by processes of this machine, or by a Dask cluster. Who does them changes no bit."""

import logging
import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from importlib.util import find_spec
from typing import Any, TypeVar

from ..core import UsageError
from ..core.progress import steps, tell
from .one_thread import ONE_THREAD, one_thread, without_script

Task = TypeVar("Task")
Result = TypeVar("Result")
RETRIES = 2


def check_crew(workers: int | None, scheduler: str | None) -> None:
    """Raises UsageError for a crew that cannot be."""
    if workers is not None and scheduler is not None:
        raise UsageError("--workers with --scheduler: the cluster has its own workers; give one of the two")
    if workers is not None and workers < 1:
        raise UsageError(f"workers = {workers}: expected 1 or more")
    if scheduler is not None and find_spec("distributed") is None:
        raise UsageError("--scheduler needs Dask; pip install 'pam-ident[cluster]'")


def do_all(
    work: Callable[[Task], Result],
    tasks: Sequence[Task],
    what: str,
    workers: int | None = None,
    scheduler: str | None = None,
) -> list[Result]:
    """`work` of each task, in their order; both must be such as can be pickled. Progress is told as of `what`.

    By the Dask cluster at `scheduler`, else by `workers` processes of one thread each, which are a Dask cluster of this
    machine where Dask is installed; in this process where that is one. Raises what a task raises, and UsageError where
    no scheduler answers.
    """
    check_crew(workers, scheduler)
    workers = min(workers or 1, len(tasks))
    if scheduler is None and workers <= 1:
        return [work(task) for task in steps(tasks, what)]
    with _executor(workers, scheduler) as (submit, completed):
        futures = {submit(work, task): k for k, task in enumerate(tasks)}
        done: dict[int, Result] = {}
        for future in completed(futures):
            done[futures[future]] = future.result()
            tell(what, len(done), len(tasks))
    return [done[k] for k in range(len(tasks))]


@contextmanager
def _executor(workers: int, scheduler: str | None) -> Iterator[tuple[Callable, Callable]]:
    """What hands a task over, and what gives the futures as they are done."""
    if scheduler is None and find_spec("distributed") is None:
        with one_thread(), without_script():
            pool = ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"))
            try:
                yield pool.submit, as_completed
            finally:
                pool.shutdown(cancel_futures=True)
        return
    with cluster(workers, scheduler) as address:
        from distributed import Client
        from distributed import as_completed as completed

        try:
            client = Client(address, timeout=5, set_as_default=False)
        except (OSError, ValueError) as error:
            raise UsageError(
                f"--scheduler {address}: no Dask scheduler answers ({str(error)[:80]}); start one by `dask scheduler`, "
                "or leave the option out"
            ) from None
        try:
            yield (
                lambda work, task: client.submit(work, task, pure=False, retries=RETRIES),
                lambda futures: completed(list(futures), loop=client.loop),
            )
        finally:
            client.close(timeout=2)


@contextmanager
def cluster(workers: int, scheduler: str | None) -> Iterator[str]:
    """The address of a Dask scheduler: the one given, else of one on this machine with `workers` of one thread."""
    if scheduler is not None:
        yield scheduler
        return
    import dask.config
    from distributed import LocalCluster

    options: Any = {"dashboard_address": "127.0.0.1:0", "silence_logs": logging.CRITICAL}
    # Dask's own choice gives each array back to the system at once: to fetch it anew takes a third of our time.
    environment = {"distributed.nanny.pre-spawn-environ": ONE_THREAD}
    with without_script():  # to the end, for a worker that dies is started again
        with one_thread(), dask.config.set(environment):
            here: Any = LocalCluster(n_workers=workers, threads_per_worker=1, **options)
        with here:
            yield here.scheduler_address
