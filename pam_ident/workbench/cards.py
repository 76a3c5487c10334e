"""Parts of the page that are drawn in the browser: buttons that say more than a word, and sliders."""

import math
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import panel as pn
import param
from panel.custom import JSComponent

from ..fitting import Fit
from .parts import STYLE, in_turn

SPAN = 6.0
"""Standard errors to each side that a slider spans."""


class Cards(JSComponent):
    """`items` as buttons, each a dictionary: key, title, text, and perhaps bar and noise (shares of a width), kind,
    disabled, current, traced (a pointer on it draws the trace of that key). `chosen` is told the key of a click."""

    items = param.List(default=[])
    label = param.String(default="")

    _esm = Path(__file__).parent / "cards.js"

    def __init__(self, label: str, chosen: Callable[[str], None], **options: Any) -> None:
        super().__init__(label=label, stylesheets=[STYLE], **({"sizing_mode": "stretch_width"} | options))
        self._chosen = chosen

    def _handle_msg(self, data: Any) -> None:
        key = str(data.get("key")) if isinstance(data, dict) else ""
        if any(item["key"] == key and not item.get("disabled") for item in self.items):
            in_turn(partial(self._chosen, key))


class Tabs(pn.Column):
    """Parts of which one is shown, each behind a button: Panel's own tabs do not answer to the keyboard."""

    def __init__(self, parts: Mapping[str, pn.viewable.Viewable], **options: Any) -> None:
        self._parts = parts
        self.buttons = Cards("Parts", self.turn_to, css_classes=["strip"])
        self.turn_to(next(iter(parts)))
        super().__init__(self.buttons, *parts.values(), **options)

    def turn_to(self, name: str) -> None:
        """Show the part of this name alone."""
        for title, part in self._parts.items():
            part.visible = title == name
        self.buttons.items = [{"key": title, "title": title, "current": title == name} for title in self._parts]


class Sliders(JSComponent):
    """A slider for each parameter that is held by hand; `held` is told its name and value, None to release it."""

    items = param.List(default=[])

    _esm = Path(__file__).parent / "sliders.js"

    def __init__(self, held: Callable[[str, float | None], None], **options: Any) -> None:
        super().__init__(stylesheets=[STYLE], **({"sizing_mode": "stretch_width"} | options))
        self._told = held

    def lay(self, fit: Fit | None, held: Mapping[str, float]) -> None:
        """A slider for each of the held parameters of a fit; those that are there already stay as they are."""
        known = {item["name"]: item for item in self.items}
        self.items = [known.get(name) or _slider(fit, name, value) for name, value in held.items()] if fit else []

    def _handle_msg(self, data: Any) -> None:
        name, value = (data.get("name"), data.get("value")) if isinstance(data, dict) else (None, None)
        item = next((item for item in self.items if item["name"] == name), None)
        if item is not None and (value is None or (isinstance(value, int | float) and math.isfinite(value))):
            kept = None if value is None else min(max(float(value), item["low"]), item["high"])
            in_turn(partial(self._told, item["name"], kept))


def _slider(fit: Fit, name: str, value: float) -> dict[str, Any]:
    at = fit.model.names.index(name)
    bounds, one = fit.model.params[at], fit.estimates[at]
    room = max(SPAN * one.stderr if one.stderr > 0.0 else 0.0, 0.5 * abs(value), 1e-6)
    low, high = max(value - room, bounds.lower), min(value + room, bounds.upper)
    return {"name": name, "unit": bounds.unit, "value": value, "low": low, "high": high}
