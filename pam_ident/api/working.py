"""What every verb does around its work: one thread for small matrices, and a bar in Jupyter where it takes long."""

import re
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import wraps
from inspect import signature
from typing import Any, ParamSpec, TypeVar

from ..core import PamError, UsageError
from ..core.nearest import unknown
from ..core.progress import Stage, heard
from ..core.threads import one_blas_thread

P = ParamSpec("P")
Result = TypeVar("Result")
OF_COMMANDS = re.compile(
    r"`pam-ident (?P<list>laws|effects)`|(?P<command>`[^`]*`)|"
    r"--(?P<option>assume|branch|gait|heldout|intervals|law|loss|method|specimen|to|weights|where)\b"
    r"""(?: (?P<value>'[^']*'|"[^"]*"|\w+))?"""
)
"""What errors call the lists of what is known, a whole command, which stays as it is, and an option with its value."""
PATIENCE, PAUSE = 1.0, 0.3
"""Seconds of work before a bar is shown, and between two changes of it."""


@contextmanager
def working() -> Iterator[None]:
    """BLAS on one thread, and a bar where a notebook shows it. An interrupt takes the bar away and goes on to the
    caller."""
    with ExitStack() as after:
        after.enter_context(one_blas_thread())
        if in_jupyter():
            bar = NotebookBar()
            after.callback(bar.clear)
            after.enter_context(heard(bar.tell))
        yield


def worked(verb: Callable[P, Result]) -> Callable[P, Result]:
    """The verb with small matrices on one thread, and a bar where a notebook shows it; called as it can be."""

    @wraps(verb)
    def inside(*args: P.args, **kwargs: P.kwargs) -> Result:
        check_call(verb, *args, **kwargs)
        with working():
            try:
                return verb(*args, **kwargs)
            except PamError as error:
                error.args = (in_python(str(error)), *error.args[1:])
                raise

    return inside


def check_call(function: Callable[..., Any], /, *args: Any, **kwargs: Any) -> None:
    """Raises UsageError for arguments that a function does not have, or that it lacks."""
    try:
        signature(function).bind(*args, **kwargs)
    except TypeError as error:
        for word in set(kwargs) - set(signature(function).parameters):
            raise no_argument(function, word) from None
        raise UsageError(f"{_name(function)}: {error}; see help({_name(function)})") from None


def no_argument(function: Callable[..., Any], word: str) -> UsageError:
    """The error of an argument that a function does not have."""
    known = [one.name for one in signature(function).parameters.values() if one.kind is not one.VAR_KEYWORD]
    return UsageError(f"{_name(function)}: {unknown('argument', word, known, f'help({_name(function)})')}")


def _name(function: Callable[..., Any]) -> str:
    name = function.__qualname__
    return name if "." in name else f"pam.{name}"


def in_python(said: str) -> str:
    """What an error says of the command's options, of this verb's arguments."""

    def argument(found: "re.Match[str]") -> str:
        if found["option"] is None:
            return found["command"] or f"pam.{found['list']}"
        value = found["value"] or ""
        return f"{found['option']}=" + (repr(value) if value.isidentifier() else value)

    return OF_COMMANDS.sub(argument, said)


def in_jupyter() -> bool:
    """Whether this is the kernel of a notebook."""
    shell = sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None
    return type(shell).__name__ == "ZMQInteractiveShell"


class NotebookBar:
    """A bar below the cell, with what is being done, as long as that lasts."""

    def __init__(self) -> None:
        self.next = time.monotonic() + PATIENCE
        self.handle: Any = None

    def tell(self, stage: Stage) -> None:
        """Draw the bar anew, if it is time."""
        if time.monotonic() < self.next:
            return
        self.next = time.monotonic() + PAUSE
        self._show(bar_html(stage))

    def clear(self) -> None:
        """Take it away."""
        if self.handle is not None:
            self._show("")

    def _show(self, text: str) -> None:
        from IPython.display import HTML, display

        if self.handle is None:
            self.handle = display(HTML(text), display_id=True)
        else:
            self.handle.update(HTML(text))


def bar_html(stage: Stage) -> str:
    """The stage as a bar of HTML, with the larger ones that it is part of in words."""
    from html import escape

    counted = next((one for one in stage.line if one.of), stage)
    size = f' value="{counted.done}" max="{counted.of}"' if counted.of else ""
    count = f" {counted.done} of {counted.of}" if counted.of else ""
    return f"<progress{size}></progress> {escape(' · '.join(one.what for one in stage.line))}{count}"
