"""A batch's unit of work, and the crew of processes on this machine that does it."""

import multiprocessing
import signal
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path

from .. import __version__
from ..core import UsageError
from ..parallel.one_thread import one_thread, without_script
from .question import Item, Question
from .record import Changed, answer
from .store import Store

TRIES = 2
"""How many workers may die of one record before it is given up."""
LOST = "its worker was killed {} times (out of memory?); nothing is kept of it, the same command tries it again"


@dataclass(frozen=True)
class Done:
    """What came of one record: nothing, the message of its first error, or why no record can be worked at now."""

    error: str | None = None
    stop: str | None = None


Work = Callable[[Item], Done]


@dataclass(frozen=True)
class FitAndKeep:
    """Answer an item and keep the answer, in whatever process."""

    question: Question
    store: Store

    def __call__(self, item: Item) -> Done:
        """The answer is on disk when this returns without `stop`."""
        if __version__ != self.question.version:
            return Done(stop=f"a worker has pam-ident {__version__}, the batch {self.question.version}; install one")
        if not self.store.folder.is_dir() or not Path(item.path).is_file():
            return Done(stop=f"a worker does not see {self.store.folder} or {item.path}; share the folders with it")
        found = self.store.get(item.key)
        if found is None:
            try:
                found = answer(self.question, item)
            except UsageError as error:
                return Done(stop=str(error))
            except Changed as error:
                return Done(str(error))
            try:
                self.store.put(item.key, found)
            except OSError as error:
                return Done(stop=f"{self.store.folder}: {error.strerror or error}")
        return Done(next((row["error"] for row in found["rows"] if row["error"]), None))


@dataclass
class _Hand:
    process: BaseProcess
    item: Item


def work_here(work: Work, items: Iterable[Item], workers: int) -> Iterator[tuple[Item, Done]]:
    """Do the items in `workers` processes of one thread each, as they come; a worker that dies is replaced.

    A record that takes its worker with it is tried once more, then given up with an error.
    """
    waiting, deaths = deque(items), Counter[str]()
    crew: dict[Connection, _Hand] = {}
    try:
        while waiting or crew:
            while waiting and len(crew) < workers:
                line, process = _hire(work)
                crew[line] = _Hand(process, waiting.popleft())
                _hand_over(line, crew[line].item)
            for line in wait(list(crew)):
                assert isinstance(line, Connection)
                item = crew[line].item
                try:
                    done = line.recv()
                except (EOFError, OSError):
                    _dismiss(line, crew.pop(line).process)
                    deaths[item.key] += 1
                    if deaths[item.key] < TRIES:
                        waiting.append(item)
                    else:
                        yield item, Done(f"{item.name}: {LOST.format(TRIES)}")
                    continue
                if waiting:
                    crew[line].item = waiting.popleft()
                    _hand_over(line, crew[line].item)
                else:
                    _dismiss(line, crew.pop(line).process)
                yield item, done
    finally:
        for line, hand in crew.items():
            hand.process.terminate()
            _dismiss(line, hand.process)


def _hand_over(line: Connection, item: Item) -> None:
    with suppress(OSError):  # the worker is dead: reading from the line says so next
        line.send(item)


def _hire(work: Work) -> tuple[Connection, BaseProcess]:
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_serve, args=(theirs, work), daemon=True)
    with one_thread(), without_script():
        process.start()
    theirs.close()
    return ours, process


def _dismiss(line: Connection, process: BaseProcess) -> None:
    line.close()
    process.join()


def _serve(line: Connection, work: Work) -> None:
    """Work until the line is closed, which it also is when the other end is killed, or there is no memory left."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with suppress(EOFError, OSError, MemoryError):
        while True:
            line.send(work(line.recv()))
