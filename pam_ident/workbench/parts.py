"""Parts of the page: text as HTML, and the column that is all of it."""

import threading
from collections.abc import Callable
from importlib.resources import files
from typing import Any

import panel as pn

STYLE = (files("pam_ident.workbench") / "style.css").read_text(encoding="utf-8")
LOOK: dict[str, Any] = {"stylesheets": [STYLE]}
"""What every widget is given, so that it is dark where the browser is."""


def html(text: str = "", **options: Any) -> pn.pane.HTML:
    """A pane in the style of the workbench, as wide as there is room."""
    return pn.pane.HTML(str(text), stylesheets=[STYLE], **({"sizing_mode": "stretch_width"} | options))


def in_turn(change: Callable[[], None]) -> None:
    """Change the page after a click. Where a click is heard before a change that waits, Bokeh's lock on the page is
    not held before the next turn, and what is changed may never reach the browser; without a server at once."""
    pn.state.execute(change, schedule=True)


def on_press(button: pn.widgets.Button, change: Callable[[], None]) -> None:
    """Change the page, in its turn, when a button is pressed."""
    button.on_click(lambda _: in_turn(change))


class Page(pn.Column):
    """A column that hears the browser only while nobody else changes it.

    A kernel of JupyterLab hears it in another thread than the one that looks for what the work has found, and what is
    changed while Panel takes in a message never reaches the browser.
    """

    def __init__(self, *objects: Any, **options: Any) -> None:
        self.turn = threading.RLock()
        super().__init__(*objects, **options)

    def _on_msg(self, ref: str, manager: Any, msg: Any) -> None:
        with self.turn:
            super()._on_msg(ref, manager, msg)
