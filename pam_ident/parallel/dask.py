"""Tasks done by the workers of a Dask cluster, whatever of it is killed meanwhile."""

import logging
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from ..core import UsageError
from .executor import TRIES, WorkerLost

if TYPE_CHECKING:
    from distributed import Client

AHEAD = 2000
"""Tasks that wait at the scheduler, more than any cluster does at a time; all of many would fill its memory."""
ANSWER_S = 5.0
"""How long a scheduler may take to answer."""


def by_dask(work: Callable, tasks: Sequence, address: str, patience_s: float) -> Iterator[tuple[int, Any]]:
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
