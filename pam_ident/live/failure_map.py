"""The map of the error over pressure and contraction, each cell with its numbers under the pointer."""

from typing import Any

import matplotlib
import numpy as np
from bokeh.layouts import column
from bokeh.models import Column, ColumnDataSource, FixedTicker, Range1d
from bokeh.plotting import figure
from matplotlib.colors import Normalize, to_hex

from ..core.digits import newtons, percent
from ..diagnosis.nouns import Comparison
from ..plot import failure_map
from ..plot.failure_map import FailureMap
from ..plot.style import INK, signed
from .panels import CLEAR, hover

READ = [
    ("mean error", "@mean"),
    ("rms", "@rms"),
    ("share of square", "@share"),
    ("samples", "@n"),
    ("pressure", "@pressure MPa"),
    ("contraction", "@low to @high"),
]
NAMES = ("x", "y", "fill", "ink", "frame", "text", "mean", "rms", "share", "n", "pressure", "low", "high")


class Panel:
    """A `figure` for a branch, its cells to be shown."""

    def __init__(self, **size: Any) -> None:
        made: Any = figure(
            x_range=Range1d(), y_range=Range1d(), y_axis_label="pressure (MPa)", title="", tools="",
            toolbar_location=None, **CLEAR | {"background_fill_color": "gray", "background_fill_alpha": 0.1}, **size,
        )  # fmt: skip
        self.figure, self.source = made, ColumnDataSource({name: [] for name in NAMES})
        drawn = made.rect("x", "y", 0.97, 0.95, source=self.source, fill_color="fill", line_color=None)
        drawn.hover_glyph = drawn.glyph.clone(line_color="gray", line_width=2)
        made.rect("x", "y", 0.93, 0.88, source=self.source, line_color="frame", line_width=2, fill_color=None)
        words: dict[str, Any] = {"text_align": "center", "text_baseline": "middle", "text_font_size": "11px"}
        made.text("x", "y", "text", source=self.source, text_color="ink", **words)
        made.grid.visible = False
        for axis in (made.xaxis[0], made.yaxis[0]):
            axis.update(ticker=FixedTicker(), major_tick_line_color=None)
        hover([made], [drawn], READ)

    def show(self, shown: FailureMap, branch: int) -> None:
        """As in the picture: colour and mean error of each cell, the worst framed."""
        name, edges = shown.branches[branch], [f"{round(e, 3) + 0.0:.3f}" for e in shown.edges]
        every, rows = 1 if len(edges) <= 8 else 2, len(shown.pressures)
        self.source.data = _columns([cell for cell in failure_map.cells(shown) if cell.place[0] == branch], shown)
        self.figure.title.update(text=name, visible=name != "static")
        self.figure.x_range.update(start=0, end=len(edges) - 1)
        self.figure.y_range.update(start=0, end=rows)
        _ticks(self.figure.xaxis[0], np.arange(len(edges))[::every], edges[::every])
        _ticks(self.figure.yaxis[0], np.arange(rows) + 0.5, [f"{p:.3g}" for p in shown.pressures])


def mapped(comparison: Comparison) -> Column:
    """A panel a branch above one another, as large as the picture that they stand in for."""
    shown = failure_map.data(comparison)
    panels = [Panel(sizing_mode="stretch_both", min_border_left=62) for _ in shown.branches]
    for branch, one in enumerate(panels):
        one.show(shown, branch)
        one.figure.xaxis.visible = branch == len(panels) - 1
    panels[-1].figure.xaxis.axis_label = "contraction ratio ε (1), cell edges"
    return column([one.figure for one in panels], sizing_mode="stretch_both")


def _columns(cells: list[failure_map.Cell], shown: FailureMap) -> dict[str, Any]:
    colours, norm = matplotlib.colormaps[failure_map.COLOURS], Normalize(-shown.limit, shown.limit)
    paints = [colours(norm(cell.mean)) for cell in cells]
    inks = ["white" if failure_map.is_dark(paint) else INK for paint in paints]
    marked = [cell.place in shown.marked for cell in cells]
    return {
        "x": [cell.place[2] + 0.5 for cell in cells],
        "y": [cell.place[1] + 0.5 for cell in cells],
        "fill": [to_hex(paint) for paint in paints],
        "ink": inks,
        "frame": [ink if one else "#00000000" for ink, one in zip(inks, marked, strict=True)],
        "text": [signed(cell.mean) for cell in cells],
        "mean": [newtons(cell.mean).replace("-", "−") for cell in cells],
        "rms": [newtons(cell.rms) for cell in cells],
        "share": [percent(cell.share) for cell in cells],
        "n": [cell.n for cell in cells],
        "pressure": [f"{cell.pressure_MPa:.3g}" for cell in cells],
        "low": [f"{cell.contraction[0]:.4f}" for cell in cells],
        "high": [f"{cell.contraction[1]:.4f}" for cell in cells],
    }


def _ticks(axis: Any, at: np.ndarray, words: list[str]) -> None:
    axis.ticker.ticks = at.tolist()  # a new ticker would have the page look through all its models
    axis.major_label_overrides = dict(zip(at.tolist(), words, strict=True))
