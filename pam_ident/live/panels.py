"""What interactive figures share: panels over a record, their samples, and what a pointer reads."""

from collections.abc import Iterable, Sequence
from importlib.resources import files
from itertools import pairwise
from typing import Any

import numpy as np
from bokeh.models import (
    BoxAnnotation,
    ColumnDataSource,
    CrosshairTool,
    GlyphRenderer,
    HoverTool,
    Range1d,
    Span,
    WheelZoomTool,
)
from bokeh.plotting import figure

from ..records import Record

Array = np.ndarray
MOST_POINTS = 6000
"""Samples that are drawn; of more, those at the ends of what each part of the record spans."""
BLUE, ORANGE, GREEN, PINNED = "#2b7bba", "#d55e00", "#1a8a63", "#9a6fb0"
INK = "#1f2933"
"""Of Bokeh's notices, which are white on a dark page too."""
CLEAR: dict[str, Any] = {"background_fill_color": None, "border_fill_color": None}
"""From the first stroke on: of a ground that is painted and then cleared the edges stay."""
ZOOM = {
    "Zoom in": "const d = (r.end - r.start) / 4; r.start += d; r.end -= d",
    "Zoom out": "const d = (r.end - r.start) / 2; r.start -= d; r.end += d",
    "Left": "const d = (r.end - r.start) / 4; r.start -= d; r.end -= d",
    "Right": "const d = (r.end - r.start) / 4; r.start += d; r.end += d",
    "Whole record": "for (const one of [r, top, bottom]) { one.start = one.reset_start; one.end = one.reset_end }",
}
"""What each button does, in JavaScript, to the range `r` along and to those of the uppermost and the lowest panel."""
THEME = (files("pam_ident.live") / "theme.js").read_text(encoding="utf-8")
"""JavaScript that colours `figures` as the browser's page is."""


def panel(label: str, x: Range1d, y: Range1d | None = None, **size: Any) -> Any:
    """A figure along `x` with `label` on its y axis. To drag zooms, and so does the wheel with Ctrl."""
    made = figure(
        x_range=x, y_range=y or Range1d(), y_axis_label=label, tools="box_zoom,pan", active_drag="box_zoom",
        toolbar_location=None, styles={"color": INK} | size.pop("styles", {}), **size, **CLEAR,
    )  # fmt: skip
    made.add_tools(WheelZoomTool(dimensions="width", modifiers={"ctrl": True}))
    return made


def dots(on: Any, source: ColumnDataSource, y: str, **look: Any) -> GlyphRenderer:
    """The column `y` of a source over its column x, a dot a sample."""
    plain: dict[str, Any] = {"size": 3, "fill_color": BLUE, "line_color": None, "fill_alpha": 0.7}
    return on.scatter(look.pop("x", "x"), y, source=source, **plain | look)


def noise_band(on: Any) -> BoxAnnotation:
    """A pale band for the noise about zero, not seen before it is known."""
    band = BoxAnnotation(fill_color=GREEN, fill_alpha=0.15, line_color=None, level="underlay", visible=False)
    on.add_layout(band)
    return band


def tips(model: str = "model", error: str = "error", follows: bool = False) -> list[tuple[str, str]]:
    """What a pointer on a sample reads, from the columns of `samples` and these."""
    return [
        ("measured", "@measured{0.0} N"),
        ("model", f"@{model}{{0.0}} N"),
        ("error", f"@{error}{{0.00}} N"),
        *([("of it follows something", "@follows{0.00} N")] if follows else []),
        ("at", "@pressure{0.000} MPa, @contraction{0.0 %}, @branch"),
        ("time", "@seconds{0.00} s"),
    ]


def hover(on: Iterable[Any], over: Sequence[GlyphRenderer], read: list[tuple[str, str]]) -> HoverTool:
    """Lets a pointer on panels read the nearest sample of the dots that it is over."""
    made = HoverTool(tooltips=read, renderers=list(over), limit=1)
    for one in on:
        one.add_tools(made)
    return made


def link(panels: Iterable[Any]) -> None:
    """One line under the pointer through all panels, and a legend above each whose entries are switched by a click."""
    across = Span(dimension="height", line_dash="dotted", line_color="gray")
    for one in panels:
        one.add_tools(CrosshairTool(overlay=across))
        one.legend.update(
            orientation="horizontal", padding=0, margin=2, spacing=10, border_line_color=None, click_policy="hide"
        )
        one.legend.label_text_font_size = "12px"
        one.add_layout(one.legend[0], "above")  # beside the samples, not over them


def samples(record: Record, rows: Array) -> dict[str, Array]:
    """Columns of the samples `rows` (m,) of a record: force in N, pressure in MPa, contraction, branch, time in s."""
    inputs, words = record.inputs, np.array(["extension", "no branch", "contraction"])
    return {
        "measured": record.force[rows],
        "pressure": inputs.pressure[rows],
        "contraction": inputs.contraction[rows],
        "branch": words[1 + np.sign(inputs.direction[rows]).astype(int)],
        "seconds": np.full(len(rows), np.nan) if inputs.time is None else inputs.time[rows],
    }


def drawn_rows(values: Array) -> Array:
    """Indices of the samples that are drawn of values (n,): all, or the least and the largest of each of many parts."""
    if len(values) <= MOST_POINTS:
        return np.arange(len(values))
    edges = np.linspace(0, len(values), MOST_POINTS // 2 + 1).astype(int)
    parts = [(begin, values[begin:end]) for begin, end in pairwise(edges)]
    return np.unique([begin + at for begin, part in parts for at in (part.argmin(), part.argmax())])


def span(axis: Any, values: Sequence[float] | Array) -> None:
    """The range of finite values (n,), with a little room, which a reset goes back to."""
    low, high = float(np.min(values)), float(np.max(values))
    room = 0.04 * (high - low) or 1.0
    axis.update(start=low - room, end=high + room, reset_start=low - room, reset_end=high + room)
