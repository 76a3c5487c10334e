"""What every command has: progress while it works, and `--quiet`."""

import inspect
import sys
import time
from collections.abc import Callable
from contextlib import ExitStack
from functools import wraps
from typing import TYPE_CHECKING, Annotated, Any

import typer

from . import text
from .options import Asked, answered, check_json, give_refused

if TYPE_CHECKING:
    from rich.progress import Progress

    from ..core.progress import Stage

PATIENCE, PAUSE = 2.0, 0.2
"""Seconds of work before progress is shown, and between two lines of it."""
EVERY = 20.0
"""The same where stderr is no terminal and each line stays."""
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print errors only; answers go to the files asked for.")]


def verb(command: Callable[..., None]) -> Callable[..., None]:
    """The command with `--quiet`, the options of its argument `asked` one by one, a `--json` that can be written and is
    also where the command is refused, and its progress shown on stderr, on a terminal by a line that is written anew.

    With `--quiet`, or with `--json -`, which puts the answer on stdout, nothing else is printed there.
    """
    own = inspect.signature(command).parameters
    shared = inspect.signature(Asked).parameters if "asked" in own else {}
    extra = inspect.Parameter("quiet", inspect.Parameter.KEYWORD_ONLY, default=False, annotation=Quiet)

    @wraps(command)
    def run(quiet: bool, **given: Any) -> None:
        check_json(given.get("json"))
        with ExitStack() as after:
            after.callback(text.silent.reset, text.silent.set(quiet or given.get("json") == "-"))
            after.callback(answered.reset, answered.set(False))
            if not quiet:
                from ..core.progress import heard

                line = ProgressLine() if sys.stderr.isatty() else PlainLines()
                after.callback(line.clear)
                after.enter_context(heard(line.tell))
            words = dict(given)
            if shared:
                given["asked"] = Asked(**{name: given.pop(name) for name in shared})
            try:
                command(**given)
            except Exception as error:
                give_refused(words.get("json"), error, words)
                raise

    spread = [p for name, one in own.items() for p in (shared.values() if name == "asked" else [one])]
    spread = [p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in [*spread, extra]]
    run.__signature__ = inspect.Signature(spread)  # pyright: ignore[reportAttributeAccessIssue]
    run.__annotations__ = {p.name: p.annotation for p in spread}
    return run


class ProgressLine:
    """Where the work is, how much of it is done and how long the rest takes, on one line of stderr."""

    def __init__(self) -> None:
        self.next = time.monotonic() + PATIENCE
        self.counted = ""
        self.bar: Progress | None = None

    def tell(self, stage: "Stage") -> None:
        """Write the line anew, if it is time."""
        if time.monotonic() < self.next:
            return
        self.next = time.monotonic() + PAUSE
        bar = self.bar = self.bar or _bar()
        counted = next((one for one in stage.line if one.of or one.done), stage)
        if not bar.tasks or counted.what != self.counted or counted.done < bar.tasks[0].completed:
            for task in bar.task_ids:
                bar.remove_task(task)
            bar.add_task("", total=counted.of)
        self.counted = counted.what
        bar.update(bar.task_ids[0], description=_words(stage), completed=counted.done)
        bar.start()
        bar.refresh()
        text.unfinished = self.clear

    def clear(self) -> None:
        """Take the line away, before anything else is printed."""
        text.unfinished = None
        if self.bar is not None:
            self.bar.stop()


class PlainLines:
    """The same where stderr is a file or a pipe: now and then a line of what is being done."""

    def __init__(self) -> None:
        self.begun = self.told = time.monotonic()

    def tell(self, stage: "Stage") -> None:
        """Write a line, if it is time."""
        if (now := time.monotonic()) < self.told + EVERY:
            return
        self.told = now
        count = next((f" ({one.done} of {one.of})" for one in stage.line if one.of), "")
        text.warn(f"after {now - self.begun:.0f} s: {_words(stage)}{count}")

    def clear(self) -> None:
        """Nothing: what was written stays."""


def _words(stage: "Stage") -> str:
    return " · ".join(one.what for one in stage.line)


def _bar() -> "Progress":
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    return Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(20),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        console=Console(stderr=True, force_terminal=True),
        auto_refresh=False,
        speed_estimate_period=3600.0,
        transient=True,
        redirect_stdout=False,
        redirect_stderr=False,
        get_time=time.monotonic,
    )
