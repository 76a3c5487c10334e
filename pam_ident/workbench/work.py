"""Long work in a thread of its own, which tells how far it is and can be stopped."""

import threading
from collections import deque
from collections.abc import Callable, Iterable
from contextvars import copy_context
from typing import Generic, TypeVar

from ..core import PamError
from ..core.progress import Stage, Stopped, heard

T = TypeVar("T")


class Work(Generic[T]):
    """Runs through `begin()` in a thread. What it yields can be taken while it goes on.

    `stage` is where it is, `error` in words what ended it early, empty where nothing did; `stopped` that it was.
    """

    def __init__(self, begin: Callable[[], Iterable[T]]) -> None:
        self.stage: Stage | None = None
        self.error = ""
        self.stopped = False
        self._found: deque[T] = deque()
        self._stop = threading.Event()
        self._begin = begin
        self._thread = threading.Thread(target=copy_context().run, args=(self._run,), daemon=True)
        self._thread.start()

    @property
    def busy(self) -> bool:
        """Whether it still runs."""
        return self._thread.is_alive()

    def take(self) -> list[T]:
        """What has been found since the last call, in order."""
        return [self._found.popleft() for _ in range(len(self._found))]

    def stop(self) -> None:
        """Ask it to end at the next stage."""
        self._stop.set()

    def wait(self, seconds: float | None = None) -> None:
        """Until it has ended, or for so long."""
        self._thread.join(seconds)

    def _run(self) -> None:
        try:
            with heard(self._hear):
                for found in self._begin():
                    self._found.append(found)
        except Stopped:
            self.stopped = True
        except PamError as error:
            self.error = str(error)
        except Exception as error:  # a thread that dies unheard would leave the page waiting
            self.error = f"the program failed where it should not ({type(error).__name__}: {error}); please report it"

    def _hear(self, stage: Stage) -> None:
        if self._stop.is_set():
            raise Stopped
        self.stage = stage
