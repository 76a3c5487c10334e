"""What every command has: progress while it works, and `--quiet`."""

import inspect
import shutil
import sys
import time
from collections.abc import Callable
from contextlib import nullcontext
from functools import wraps
from typing import TYPE_CHECKING, Annotated, Any

import typer

from . import text

if TYPE_CHECKING:
    from ..core.progress import Stage

PATIENCE, PAUSE = 2.0, 0.2
"""Seconds of work before progress is shown, and between two lines of it."""
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print errors only; answers go to the files asked for.")]


def verb(command: Callable[..., None]) -> Callable[..., None]:
    """The command with `--quiet`, and with its progress shown where stderr is a terminal.

    With `--quiet`, or with `--json -`, which puts the answer on stdout, nothing else is printed there.
    """

    @wraps(command)
    def run(*args: Any, quiet: bool, **kwargs: Any) -> None:
        token = text.silent.set(quiet or kwargs.get("json") == "-")
        try:
            with nullcontext() if quiet or not sys.stderr.isatty() else shown():
                command(*args, **kwargs)
        finally:
            text.silent.reset(token)

    own = inspect.signature(command)
    extra = inspect.Parameter("quiet", inspect.Parameter.KEYWORD_ONLY, default=False, annotation=Quiet)
    run.__signature__ = own.replace(parameters=[*own.parameters.values(), extra])  # pyright: ignore[reportAttributeAccessIssue]
    run.__annotations__ = {**command.__annotations__, "quiet": Quiet}
    return run


class shown:
    """Work done inside shows its progress on one line of stderr, which is gone at the end."""

    def __enter__(self) -> None:
        from ..core.progress import heard

        self.clock = Clock()
        self.listening = heard(self.tell)
        self.listening.__enter__()

    def __exit__(self, *error: Any) -> None:
        self.listening.__exit__(*error)
        self.clear()

    def tell(self, stage: "Stage") -> None:
        """Write the line anew, if it is time."""
        line = self.clock.line(stage, time.monotonic())
        if line is not None:
            room = shutil.get_terminal_size().columns - 1
            typer.echo(f"\r\x1b[K{line[:room]}", nl=False, err=True)
            text.unfinished = self.clear

    def clear(self) -> None:
        """Take the line away, before anything else is printed."""
        if text.unfinished is not None:
            text.unfinished = None
            typer.echo("\r\x1b[K", nl=False, err=True)


class Clock:
    """Puts a stage in words, with its rate and the time left, at most every PAUSE seconds."""

    def __init__(self) -> None:
        self.begin: float | None = None
        self.last = 0.0
        self.counts: dict[str, tuple[float, int, int]] = {}

    def line(self, stage: "Stage", now: float) -> str | None:
        """What to show at the time `now` in s; None where it is too early."""
        self.begin = now if self.begin is None else self.begin
        counted = next((one for one in stage.line if one.of or one.done), None)
        if counted is not None:
            began, first, last = self.counts.get(counted.what, (now, counted.done, counted.done))
            if counted.done < last:  # the same once more
                began, first = now, counted.done
            self.counts[counted.what] = began, first, counted.done
        if now - self.begin < PATIENCE or now - self.last < PAUSE:
            return None
        self.last = now
        words = [one.what if one is not counted else self.count(one, now) for one in stage.line]
        return " · ".join([*words, duration(now - self.begin)])

    def count(self, stage: "Stage", now: float) -> str:
        """How much is done, how fast, and how long the rest will take."""
        began, first, _ = self.counts[stage.what]
        words = f"{stage.what}: {stage.done}" + (f" of {stage.of}" if stage.of else "")
        if stage.done == first or now == began:
            return words
        rate = (stage.done - first) / (now - began)
        left = f", {duration((stage.of - stage.done) / rate)} left" if stage.of else ""
        return f"{words}, {text.number(rate, 2)}/s{left}"


def duration(seconds: float) -> str:
    """A time in the unit in which it is read: s, min or h."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"
