"""The map of the error over pressure and contraction, each cell with its numbers under the pointer."""

from typing import Any

import matplotlib
from bokeh.layouts import column
from bokeh.models import Column, ColumnDataSource, FixedTicker, Range1d
from bokeh.plotting import figure
from matplotlib.colors import Normalize, to_hex

from ..core.digits import newtons, percent
from ..diagnosis.nouns import Comparison
from ..plot import failure_map
from ..plot.style import INK, signed
from .panels import CLEAR, hover

LOOK: dict[str, Any] = {"toolbar_location": None, "tools": "", "sizing_mode": "stretch_both", "min_border_left": 62}
READ = [
    ("mean error", "@mean"),
    ("rms", "@rms"),
    ("share of square", "@share"),
    ("samples", "@n"),
    ("pressure", "@pressure MPa"),
    ("contraction", "@low to @high"),
]


def mapped(comparison: Comparison) -> Column:
    """A panel a branch as in the picture: colour and mean error of each cell, the worst framed."""
    shown = failure_map.data(comparison)
    rows, edges = len(shown.pressures), [f"{round(e, 3) + 0.0:.3f}" for e in shown.edges]
    x, panels = Range1d(start=0, end=len(edges) - 1), []
    for branch in shown.branches:
        title, y = None if branch == "static" else branch, Range1d(start=0, end=rows)
        one: Any = figure(x_range=x, y_range=y, y_axis_label="pressure (MPa)", title=title, **LOOK, **CLEAR)
        one.rect(0.5 * (len(edges) - 1), 0.5 * rows, len(edges) - 1, rows, color="gray", alpha=0.1, line_color=None)
        cells = [cell for cell in failure_map.cells(shown) if cell.branch == branch]
        source = ColumnDataSource(_columns(cells, shown))
        drawn = one.rect("x", "y", 0.97, 0.95, source=source, fill_color="fill", line_color=None)
        drawn.hover_glyph = drawn.glyph.clone(line_color="gray", line_width=2)
        one.rect("x", "y", 0.93, 0.88, source=source, line_color="frame", line_width=2, fill_color=None)
        words: dict[str, Any] = {"text_align": "center", "text_baseline": "middle", "text_font_size": "11px"}
        one.text("x", "y", "text", source=source, text_color="ink", **words)
        _ticks(one.yaxis, [k + 0.5 for k in range(rows)], [f"{p:.3g}" for p in shown.pressures])
        every = 1 if len(edges) <= 8 else 2
        _ticks(one.xaxis, list(range(len(edges)))[::every], edges[::every])
        one.xaxis.visible = False
        one.grid.visible = False
        hover([one], [drawn], READ)
        panels.append(one)
    panels[-1].xaxis.visible = True
    panels[-1].xaxis.axis_label = "contraction ratio ε (1), cell edges"
    return column(panels, sizing_mode="stretch_both")


def _columns(cells: list[failure_map.Cell], shown: failure_map.FailureMap) -> dict[str, Any]:
    colours, norm = matplotlib.colormaps[failure_map.COLOURS], Normalize(-shown.limit, shown.limit)
    paints = [colours(norm(cell.mean)) for cell in cells]
    marked = [cell.place in shown.marked for cell in cells]
    return {
        "x": [cell.place[2] + 0.5 for cell in cells],
        "y": [cell.place[1] + 0.5 for cell in cells],
        "fill": [to_hex(paint) for paint in paints],
        "ink": [_ink(paint) for paint in paints],
        "frame": [_ink(paint) if one else "#00000000" for one, paint in zip(marked, paints, strict=True)],
        "text": [signed(cell.mean) for cell in cells],
        "mean": [newtons(cell.mean).replace("-", "−") for cell in cells],
        "rms": [newtons(cell.rms) for cell in cells],
        "share": [percent(cell.share) for cell in cells],
        "n": [cell.n for cell in cells],
        "pressure": [f"{cell.pressure_MPa:.3g}" for cell in cells],
        "low": [f"{cell.contraction[0]:.4f}" for cell in cells],
        "high": [f"{cell.contraction[1]:.4f}" for cell in cells],
    }


def _ink(paint: tuple[float, float, float, float]) -> str:
    """For words and frame on a colour, on a light page and on a dark one."""
    return "white" if failure_map.is_dark(paint) else INK


def _ticks(axis: Any, at: list[float] | list[int], words: list[str]) -> None:
    axis.ticker = FixedTicker(ticks=at)
    axis.major_label_overrides = dict(zip(at, words, strict=True))
    axis.major_tick_line_color = None
