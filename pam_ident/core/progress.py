"""What long work says while it runs, and how it is stopped.

Work says where it is by `tell` or `steps`; whoever started it listens by `heard`. Without a listener nothing happens.
A listener that raises `Stopped` ends the work there.
"""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import TypeVar

T = TypeVar("T")


class Stopped(BaseException):
    """Work was stopped by whoever listened to it; no handler of errors on the way is to catch it."""


@dataclass(frozen=True)
class Stage:
    """What is being done and how much of it, `done` of `of`, None where nobody knows; `within` a larger one."""

    what: str
    done: int = 0
    of: int | None = None
    within: "Stage | None" = None

    @property
    def line(self) -> "tuple[Stage, ...]":
        """This stage and all it is part of, the largest first."""
        return (*(self.within.line if self.within else ()), self)


Ear = Callable[[Stage], None]
_ear: ContextVar[Ear | None] = ContextVar("pam_ident_ear", default=None)
_within: ContextVar[Stage | None] = ContextVar("pam_ident_within", default=None)


def tell(what: str, done: int = 0, of: int | None = None) -> None:
    """Say where the work is. Raises Stopped where the listener wants it to end."""
    ear = _ear.get()
    if ear is not None:
        ear(Stage(what, done, of, _within.get()))


def steps(items: Iterable[T], what: str, of: int | None = None) -> Iterator[T]:
    """The items one by one, each told before it is worked on; what is said meanwhile is part of that.

    `of` is their number where they have no length. Raises Stopped as `tell` does.
    """
    of = len(items) if of is None and hasattr(items, "__len__") else of  # pyright: ignore[reportArgumentType]
    for done, item in enumerate(items):
        tell(what, done, of)
        with part(what, done, of):
            yield item


@contextmanager
def part(what: str, done: int = 0, of: int | None = None) -> Iterator[None]:
    """What is said inside is part of this."""
    outer = _within.get()
    _within.set(Stage(what, done, of, outer))
    try:
        yield
    finally:
        _within.set(outer)


@contextmanager
def heard(ear: Ear) -> Iterator[None]:
    """Listen to all work begun inside, in this thread."""
    outer = _ear.get()
    _ear.set(ear)
    try:
        yield
    finally:
        _ear.set(outer)
