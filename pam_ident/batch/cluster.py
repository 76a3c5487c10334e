"""A batch's work done by the workers of a Dask cluster, whatever of it is killed meanwhile."""

import time
from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, Any

from ..core import UsageError
from .question import Item
from .work import LOST, Done, Work

if TYPE_CHECKING:
    from distributed import Client

AHEAD = 4
"""Records that wait at the scheduler for each thread of a worker; more would only fill its memory."""
PATIENCE_S = 300.0
"""How long a scheduler that went away is waited for."""
RETRIES = 2


def work_on_cluster(
    work: Work,
    items: Iterable[Item],
    address: str,
    tell: Callable[[str], None] = lambda line: None,
    patience_s: float = PATIENCE_S,
) -> Iterator[tuple[Item, Done]]:
    """Do the items on the cluster whose scheduler is at `address`, as they come; `tell` hears when it is gone.

    Workers must see the records and the results under the same paths. An answer is kept by the worker that found it,
    so that neither a worker nor the scheduler nor this process takes a finished one with it. Raises UsageError where
    there is no scheduler, or none comes back within `patience_s` seconds.
    """
    waiting = {item.key: item for item in items}
    patience = 0.0
    while waiting:
        client = _client(address, patience)
        try:
            for item, done in _round(client, work, list(waiting.values())):
                del waiting[item.key]
                yield item, done
        finally:
            client.close(timeout=2)
        if waiting:
            patience = patience_s
            tell(f"the scheduler at {address} is gone; waiting for it")


def _client(address: str, patience_s: float) -> "Client":
    from distributed import Client

    begin = time.monotonic()
    while True:
        try:
            return Client(address, timeout=5, set_as_default=False)
        except (OSError, ValueError) as error:
            if isinstance(error, ValueError) or time.monotonic() - begin >= patience_s:
                raise UsageError(
                    f"--scheduler {address}: no Dask scheduler answers ({str(error)[:80]}); start one by `dask "
                    "scheduler`, or leave the option out. What is finished is kept"
                ) from None
            time.sleep(1.0)


def _round(client: "Client", work: Work, items: list[Item]) -> Iterator[tuple[Item, Done]]:
    """Items as the cluster finishes them, until all are done or the scheduler is gone."""
    from distributed import CancelledError, KilledWorker, as_completed

    queue, asked, crew = iter(items), dict[str, Item](), _Crew(client)
    running: Any = as_completed(loop=client.loop)
    try:
        while True:
            for item in _take(queue, AHEAD * crew.threads() - len(asked)):
                asked[item.key] = item
                running.add(client.submit(work, item, key=item.key, pure=False, retries=RETRIES))
            if not asked:
                return
            future = next(running)
            if future.status in ("cancelled", "lost"):
                return
            item = asked.pop(future.key)
            failure: Any = future.exception() if future.status == "error" else None
            if isinstance(failure, KilledWorker):
                yield item, Done(f"{item.name}: {LOST.format(failure.allowed_failures + 1)}")
            elif failure is not None:
                yield item, Done(stop=f"a worker failed at {item.name}: {type(failure).__name__}: {failure}")
            else:
                yield item, future.result()
    except Exception as error:
        # The line can break at any instant, that between a future's status and its result included.
        if client.status == "running" and not isinstance(error, (OSError, CancelledError)):
            raise


def _take(queue: Iterator[Item], count: int) -> Iterator[Item]:
    for _ in range(count):
        item = next(queue, None)
        if item is None:
            return
        yield item


class _Crew:
    """How many threads the workers have, asked at most once a second, for workers come and go."""

    def __init__(self, client: Any) -> None:
        self.client, self.asked, self.known = client, -1.0, 1

    def threads(self) -> int:
        """One at least, so that work waits where a worker will look for it."""
        if time.monotonic() - self.asked > 1.0:
            self.asked, self.known = time.monotonic(), max(sum(self.client.nthreads().values()), 1)
        return self.known
