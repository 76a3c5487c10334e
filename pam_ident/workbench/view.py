"""The record, the model and what is left as linked figures to zoom and to point at."""

from typing import Any

import numpy as np
import panel as pn
from bokeh.models import ColumnDataSource, CustomJS, Range1d

from ..fitting import Fit
from ..live.failure_map import Panel
from ..live.panels import (
    ORANGE,
    PINNED,
    THEME,
    ZOOM,
    dots,
    drawn_rows,
    hover,
    link,
    noise_band,
    panel,
    samples,
    span,
    tips,
)
from ..plot import failure_map
from .bench import Bench
from .parts import STYLE, in_turn

Array = np.ndarray
ALONG = {"time": "time (s)", "contraction": "contraction (ratio)", "pressure": "pressure (MPa)", "sample": "sample"}
COLUMNS = ("x", "measured", "model", "error", "follows", "pressure", "contraction", "branch", "seconds", "pinned")


class Views:
    """`figures` over the record, with `along` and `zoom` to steer them, and `map`, where the model fails."""

    def __init__(self) -> None:
        self.points = ColumnDataSource({name: [] for name in COLUMNS})
        self.traces = ColumnDataSource({"x": []}, name="traces")
        self.preview = ColumnDataSource({"x": [], "y": []}, name="preview")
        self._record, self._rows = None, np.empty(0, int)
        self.x = Range1d()
        wide: dict[str, Any] = {"sizing_mode": "stretch_width"}
        self.force = panel("force (N)", self.x, height=260, **wide)
        self.error = panel("error (N)", self.x, height=230, **wide)
        self.noise = noise_band(self.error)
        self.force.line("x", "model", source=self.points, color=ORANGE, line_width=2.5, legend_label="model")
        seen = [
            dots(self.force, self.points, "measured", legend_label="measured"),
            dots(self.error, self.points, "error", legend_label="error"),
        ]
        dots(self.error, self.points, "pinned", fill_color=PINNED, size=2, legend_label="error of A")
        self.error.scatter("x", "y", source=self.preview, color=ORANGE, size=2)
        self.error.scatter("x", "x", source=self.traces, visible=False)  # so that the browser has them
        self.hover = hover((self.force, self.error), seen, tips(follows=True))
        link((self.force, self.error))
        self.along = pn.widgets.Select(label="Along", options=["time"], width=140, stylesheets=[STYLE])
        self.along.param.watch(lambda _: in_turn(self._place), "value")
        self.maps = [Panel(height=260, width=350, x_axis_label="contraction (ratio), cell edges") for _ in range(2)]
        self.figures = pn.Column(pn.pane.Bokeh(self.force, **wide), pn.pane.Bokeh(self.error, **wide), **wide)
        self.zoom = pn.FlexBox(self.along, *map(self._button, ZOOM), align_items="end", **wide)
        self.map = pn.FlexBox(*(pn.pane.Bokeh(one.figure, width=350) for one in self.maps), **wide)

    def _button(self, name: str) -> pn.widgets.Button:
        made = pn.widgets.Button(label=name, stylesheets=[STYLE])
        made.jscallback(clicks=ZOOM[name], args={"r": self.x, "top": self.force.y_range, "bottom": self.error.y_range})
        return made

    @property
    def themed(self) -> CustomJS:
        """What colours the figures as the browser's are, once the page stands."""
        return CustomJS(args={"figures": [self.force, self.error, *(one.figure for one in self.maps)]}, code=THEME)

    def show(self, bench: Bench, pinned: Fit | None) -> None:
        """Draw a bench; what was zoomed into stays in sight as long as the record does."""
        record, model = bench.record, bench.fit
        fresh = record is not self._record
        if fresh:
            self._record, self._rows = record, drawn_rows(record.force)
            ways = {name: along for along, name in ALONG.items() if along != "time" or record.inputs.time is not None}
            self.along.param.update(options=ways, value="sample" if record.inputs.time is None else "time")
            span(self.force.y_range, record.force)
        pinned = pinned if pinned is not None and pinned.record is record else None
        rows = self._rows
        nothing = np.full(len(rows), np.nan)
        self.points.data = samples(record, rows) | {
            "x": self._along(), "model": model.force[rows], "error": model.residual[rows],
            "follows": nothing if bench.followed is None else bench.followed[rows],
            "pinned": nothing if pinned is None else pinned.residual[rows],
        }  # fmt: skip
        self.traces.data = {"x": self.points.data["x"]} | {one.label: one.takes[rows] for one in bench.previews}
        self.preview.data = {"x": [], "y": []}
        self.error.legend[0].items[1].visible = pinned is not None
        most = max(np.abs(bench.law_alone.residual).max(), np.abs(model.residual).max())
        span(self.error.y_range, (-most, most))
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
        span(self.x, x)

    def _show_map(self, bench: Bench) -> None:
        shown = failure_map.data(bench.comparison)
        for branch, one in enumerate(self.maps):
            one.figure.visible = branch < len(shown.branches)
            if one.figure.visible:
                one.show(shown, branch)
