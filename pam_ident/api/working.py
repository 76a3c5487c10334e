"""What every verb does around its work: one thread for small matrices, and a bar in Jupyter where it takes long."""

import re
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import wraps
from typing import Any, ParamSpec, TypeVar

from ..core import PamError
from ..core.progress import Stage, heard
from ..core.threads import one_blas_thread

P = ParamSpec("P")
Result = TypeVar("Result")
OPTION = re.compile(r"--(assume|branch|heldout|intervals|law|loss|method|specimen|weights)\b(?: ('[^']*'|\w+))?")
LISTS = re.compile(r"`pam-ident (laws|effects)`")
"""What errors call an option with its value, and the lists of what is known."""
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
    """The verb with small matrices on one thread, and a bar where a notebook shows it."""

    @wraps(verb)
    def inside(*args: P.args, **kwargs: P.kwargs) -> Result:
        with working():
            try:
                return verb(*args, **kwargs)
            except PamError as error:
                error.args = (in_python(str(error)), *error.args[1:])
                raise

    return inside


def in_python(said: str) -> str:
    """What an error says of the command's options, of this verb's arguments."""

    def argument(found: "re.Match[str]") -> str:
        return f"{found[1]}=" + (repr(found[2].strip("'")) if found[2] else "")

    return OPTION.sub(argument, LISTS.sub(r"pam.\1", said))


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
