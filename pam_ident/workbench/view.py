"""The record, the model and what is left as linked figures to zoom and to point at."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import panel as pn
from bokeh.models import BoxAnnotation, ColumnDataSource, CrosshairTool, CustomJS, HoverTool, Range1d, Span
from bokeh.palettes import RdBu11
from bokeh.plotting import figure
from bokeh.transform import linear_cmap

from ..core.digits import newtons, percent
from ..fitting import Fit
from .bench import Bench
from .parts import STYLE, in_turn

Array = np.ndarray
MOST_POINTS = 6000
"""Samples that are drawn; of more, those at the ends of what each part of the record spans."""
ALONG = {"time": "time (s)", "contraction": "contraction (ratio)", "pressure": "pressure (MPa)", "sample": "sample"}
BLUE, ORANGE, GREEN, PINNED = "#2b7bba", "#d55e00", "#1a8a63", "#9a6fb0"
COLUMNS = ("x", "measured", "model", "error", "follows", "pressure", "contraction", "branch", "seconds", "pinned")
TIPS = [
    ("measured", "@measured{0.0} N"),
    ("model", "@model{0.0} N"),
    ("error", "@error{0.00} N"),
    ("of it follows something", "@follows{0.00} N"),
    ("at", "@pressure{0.000} MPa, @contraction{0.0 %}, @branch"),
    ("time", "@seconds{0.00} s"),
]
CLEAR: dict[str, Any] = {"background_fill_color": None, "border_fill_color": None}
"""From the first stroke on: of a ground that is painted and then cleared the edges stay."""
ZOOM = {
    "Zoom in": "const d = (r.end - r.start) / 4; r.start += d; r.end -= d",
    "Zoom out": "const d = (r.end - r.start) / 2; r.start -= d; r.end += d",
    "Left": "const d = (r.end - r.start) / 4; r.start -= d; r.end -= d",
    "Right": "const d = (r.end - r.start) / 4; r.start += d; r.end += d",
    "Whole record": "for (const one of [r, top, bottom]) { one.start = one.reset_start; one.end = one.reset_end }",
}
THEME = """
const dark = window.matchMedia("(prefers-color-scheme: dark)")
const paint = () => {
  const ink = dark.matches ? "#e6e9ed" : "#1f2933", line = dark.matches ? "#3d4650" : "#d5dae1"
  for (const one of figures) {
    one.outline_line_color = line
    for (const axis of [...one.below, ...one.left])
      axis.setv({ axis_label_text_color: ink, major_label_text_color: ink, axis_line_color: line,
                  major_tick_line_color: line, minor_tick_line_color: null })
    for (const grid of one.center) if (grid.type.endsWith("Grid")) grid.grid_line_color = line
    for (const legend of one.above) if (legend.type.endsWith("Legend"))
      legend.setv({ background_fill_color: null, label_text_color: ink })
    if (one.title) one.title.text_color = ink
  }
}
paint()
dark.addEventListener("change", paint)
"""


class Views:
    """`figures` over the record, with `along` and `zoom` to steer them, and `map`, where the model fails."""

    def __init__(self) -> None:
        self.points = ColumnDataSource({name: [] for name in COLUMNS})
        self.traces = ColumnDataSource({"x": []}, name="traces")
        self.preview = ColumnDataSource({"x": [], "y": []}, name="preview")
        self._record, self._rows = None, np.empty(0, int)
        self.x = Range1d()
        self.force = self._figure("force (N)", 260)
        self.error = self._figure("error (N)", 230)
        self.noise = BoxAnnotation(fill_color=GREEN, fill_alpha=0.15, line_color=None, level="underlay", visible=False)
        self.error.add_layout(self.noise)
        dots: dict[str, Any] = {"source": self.points, "size": 3, "line_color": None, "fill_alpha": 0.7}
        self.force.line("x", "model", source=self.points, color=ORANGE, line_width=2.5, legend_label="model")
        seen = [
            self.force.scatter("x", "measured", fill_color=BLUE, legend_label="measured", **dots),
            self.error.scatter("x", "error", fill_color=BLUE, legend_label="error", **dots),
        ]
        self.error.scatter("x", "pinned", fill_color=PINNED, legend_label="error of A", **dots | {"size": 2})
        self.error.scatter("x", "y", source=self.preview, color=ORANGE, size=2)
        self.error.scatter("x", "x", source=self.traces, visible=False)  # so that the browser has them
        self.hover = HoverTool(tooltips=TIPS, renderers=seen, limit=1)
        across = Span(dimension="height", line_dash="dotted", line_color="gray")
        for one in (self.force, self.error):
            one.add_tools(self.hover, CrosshairTool(overlay=across))
            one.legend.update(orientation="horizontal", padding=0, margin=2, border_line_color=None)
            one.legend.label_text_font_size = "12px"
            one.add_layout(one.legend[0], "above")  # beside the samples, not over them
        self.along = pn.widgets.Select(label="Along", options=["time"], width=140, stylesheets=[STYLE])
        self.along.param.watch(lambda _: in_turn(self._place), "value")
        self.maps = [self._map(), self._map()]
        fit: dict[str, Any] = {"sizing_mode": "stretch_width"}
        self.figures = pn.Column(pn.pane.Bokeh(self.force, **fit), pn.pane.Bokeh(self.error, **fit), **fit)
        self.zoom = pn.FlexBox(self.along, *map(self._button, ZOOM), align_items="end", **fit)
        self.map = pn.FlexBox(*(pn.pane.Bokeh(one, width=350) for one in self.maps), **fit)

    def _figure(self, label: str, height: int) -> Any:
        made = figure(
            height=height, sizing_mode="stretch_width", x_range=self.x, y_range=Range1d(), y_axis_label=label,
            tools="box_zoom,pan,xwheel_zoom", active_drag="box_zoom", toolbar_location=None, **CLEAR,
        )  # fmt: skip
        return made

    def _map(self) -> Any:
        cells = ColumnDataSource(
            {name: [] for name in ("left", "right", "row", "pressure", "mean", "error", "rms", "share")}
        )
        made = figure(height=260, width=350, x_range=Range1d(), y_range=Range1d(), x_axis_label=ALONG["contraction"],
                      y_axis_label=ALONG["pressure"], tools="", toolbar_location=None, **CLEAR)  # fmt: skip
        drawn = made.hbar(
            y="row", left="left", right="right", height=1.0, source=cells, line_color=None,
            fill_color=linear_cmap("mean", RdBu11, -1.0, 1.0),
        )  # fmt: skip
        tips = [("mean error", "@error"), ("rms", "@rms"), ("share of the squared error", "@share")]
        made.add_tools(HoverTool(tooltips=[("at", "@pressure{0.000} MPa"), *tips], renderers=[drawn]))
        made.grid.visible = False
        return made

    def _button(self, name: str) -> pn.widgets.Button:
        made = pn.widgets.Button(label=name, stylesheets=[STYLE])
        made.jscallback(clicks=ZOOM[name], args={"r": self.x, "top": self.force.y_range, "bottom": self.error.y_range})
        return made

    @property
    def themed(self) -> CustomJS:
        """What colours the figures as the browser's are, once the page stands."""
        return CustomJS(args={"figures": [self.force, self.error, *self.maps]}, code=THEME)

    def show(self, bench: Bench, pinned: Fit | None) -> None:
        """Draw a bench; what was zoomed into stays in sight as long as the record does."""
        record, model = bench.record, bench.fit
        fresh = record is not self._record
        if fresh:
            self._record, self._rows = record, drawn_rows(record.force)
            ways = {name: along for along, name in ALONG.items() if along != "time" or record.inputs.time is not None}
            self.along.param.update(options=ways, value="sample" if record.inputs.time is None else "time")
            _span(self.force.y_range, record.force)
        pinned = pinned if pinned is not None and pinned.record is record else None
        rows, inputs = self._rows, record.inputs
        words = np.array(["extension", "no branch", "contraction"])
        nothing = np.full(len(rows), np.nan)
        self.points.data = {
            "x": self._along(), "measured": record.force[rows], "model": model.force[rows],
            "error": model.residual[rows],
            "follows": nothing if bench.followed is None else bench.followed[rows],
            "pressure": inputs.pressure[rows], "contraction": inputs.contraction[rows],
            "branch": words[1 + np.sign(inputs.direction[rows]).astype(int)],
            "seconds": nothing if inputs.time is None else inputs.time[rows],
            "pinned": nothing if pinned is None else pinned.residual[rows],
        }  # fmt: skip
        self.traces.data = {"x": self.points.data["x"]} | {one.label: one.takes[rows] for one in bench.previews}
        self.preview.data = {"x": [], "y": []}
        self.error.legend[0].items[1].visible = pinned is not None
        most = max(np.abs(bench.law_alone.residual).max(), np.abs(model.residual).max())
        _span(self.error.y_range, (-most, most))
        floor = bench.noise_floor
        self.noise.update(visible=floor is not None, bottom=-(floor or 0.0), top=floor or 0.0)
        self._show_map(bench)
        if fresh:
            self._place()

    def _along(self) -> Array:
        assert self._record is not None
        inputs, rows = self._record.inputs, self._rows
        along = {"time": inputs.time, "contraction": inputs.contraction, "pressure": inputs.pressure}
        found = along.get(self.along.value)
        return rows.astype(float) if found is None else found[rows]

    def _place(self) -> None:
        """Draw along what is chosen, the whole of it."""
        if self._record is None or len(self.points.data["error"]) != len(self._rows):
            return  # what is drawn is still another record's
        x = self._along()
        for source in (self.points, self.traces):
            source.data = {name: x if name == "x" else column for name, column in source.data.items()}  # type: ignore[reportAttributeAccessIssue]
        self.preview.data = {"x": [], "y": []}
        self.error.xaxis.axis_label = ALONG[self.along.value]
        self.hover.mode = "vline" if self.along.value in ("time", "sample") else "mouse"
        _span(self.x, x)

    def _show_map(self, bench: Bench) -> None:
        found = bench.comparison
        told = {"error": (newtons, found.mean), "rms": (newtons, found.rms), "share": (percent, found.share)}
        most = max(float(np.nanmax(np.abs(found.mean))), bench.noise_floor or 0.0, 1e-9)
        for k, one in enumerate(self.maps):
            one.visible = k < len(found.branches)
            if not one.visible:
                continue
            row, cell = np.nonzero(np.isfinite(found.mean[k]))
            drawn = one.renderers[0]
            drawn.data_source.data = {
                "left": found.edges[cell], "right": found.edges[cell + 1], "row": row, "pressure": found.pressures[row],
                "mean": found.mean[k][row, cell],
            } | {name: [say(v) for v in of[k][row, cell]] for name, (say, of) in told.items()}  # fmt: skip
            drawn.glyph.fill_color.transform.update(low=-most, high=most)
            one.title.text = f"{found.branches[k]}: mean error (red: measured above)"
            _span(one.x_range, found.edges)
            one.y_range.update(start=-0.6, end=len(found.pressures) - 0.4)
            one.yaxis.ticker = list(range(len(found.pressures)))
            one.yaxis.major_label_overrides = {j: f"{p:.3g}" for j, p in enumerate(found.pressures)}


def drawn_rows(values: Array) -> Array:
    """Indices of the samples that are drawn of values (n,): all, or the least and the largest of each of many parts."""
    if len(values) <= MOST_POINTS:
        return np.arange(len(values))
    edges = np.linspace(0, len(values), MOST_POINTS // 2 + 1).astype(int)
    parts = [(begin, values[begin:end]) for begin, end in pairwise(edges)]
    return np.unique([begin + at for begin, part in parts for at in (part.argmin(), part.argmax())])


def _span(axis: Any, values: Sequence[float] | Array) -> None:
    """The range of finite values, with a little room, which a reset goes back to."""
    low, high = float(np.min(values)), float(np.max(values))
    room = 0.04 * (high - low) or 1.0
    axis.update(start=low - room, end=high + room, reset_start=low - room, reset_end=high + room)
