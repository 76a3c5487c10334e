"""Parts of the page: text as HTML, the column that is all of it, and the muscle, typed in."""

import threading
from collections.abc import Callable
from importlib.resources import files
from typing import Any

import panel as pn

from ..core import Specimen
from . import words

STYLE = (files("pam_ident.workbench") / "style.css").read_text(encoding="utf-8")
LOOK: dict[str, Any] = {"stylesheets": [STYLE]}
"""What every widget is given, so that it is dark where the browser is."""
FIELDS = {
    "initial_length_mm": "Initial length (mm)",
    "initial_radius_mm": "Initial radius (mm)",
    "braid_angle_deg": "Braid angle (°)",
    "wall_thickness_mm": "Wall thickness (mm), if known",
}


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


class SpecimenForm:
    """Fields for a muscle at rest; `fields` by the names of a specimen.toml."""

    def __init__(self) -> None:
        self.fields = {key: pn.widgets.TextInput(label=label, width=200, **LOOK) for key, label in FIELDS.items()}
        self.row = pn.FlexBox(*self.fields.values(), sizing_mode="stretch_width")

    def given(self, name: str) -> Specimen | None:
        """The muscle that is typed in, under that name; None where too little is. Raises UsageError for what is no
        number, DataError for no muscle."""
        values = {key: words.length(field.label, field.value) for key, field in self.fields.items() if field.value}
        if len(values.keys() - {"wall_thickness_mm"}) < 3:
            return None
        return Specimen(name, **values)  # pyright: ignore[reportArgumentType] - lengths and an angle

    def show(self, specimen: Specimen) -> None:
        """Fill in a muscle."""
        for key, field in self.fields.items():
            value = getattr(specimen, key)
            field.value = "" if value is None else f"{value:.10g}"
