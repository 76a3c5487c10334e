"""The figures of a report to zoom into: errors over the record, and the measurement against the model."""

from functools import cached_property
from typing import Any

import numpy as np
from bokeh.layouts import column
from bokeh.models import CDSView, Column, ColumnDataSource, GlyphRenderer, IndexFilter, Label, Range1d, Span

from ..core.digits import newtons
from ..diagnosis.nouns import Comparison
from ..fitting import Fit
from ..plot import measured_against_model, signature
from ..plot.style import SKY
from .failure_map import mapped
from .panels import BLUE, ORANGE, dots, hover, link, panel, samples, span, tips

FILL: dict[str, Any] = {"sizing_mode": "stretch_both", "min_border_left": 62}
"""As large as the picture that they stand in for, their axes above one another."""
BRANCHES = {"contraction": (BLUE, "solid"), "extension": (ORANGE, "dashed"), "static": (BLUE, "solid")}
PALE: dict[str, Any] = {"fill_color": "gray", "fill_alpha": 0.5}
"""Samples behind lines, on a light page and on a dark one."""
LEAST_ROOM = 0.12
"""Of the panel's width, for a stripe to be named in."""


class Figures:
    """Of two fits of a record, or of one: `trace` and `isobars`, which share at most `limit` samples.

    No text of a record goes into them, so that none can become markup or mathematics.
    """

    def __init__(self, before: Fit, after: Fit | None, limit: int) -> None:
        self.before, self.after, self.limit = before, after, limit
        self.fits = {"before": before} | ({"after": after} if after else {})
        shown = self.shown = signature.data(before, after or before, limit)
        self.size = 3 if len(shown.rows) > 300 else 6
        columns = samples(before.record, shown.rows) | {"x": shown.x, "change": shown.effect}
        for name, one in self.fits.items():
            columns |= {f"model_{name}": one.force[shown.rows], name: one.residual[shown.rows]}
        columns |= {"mean_before": shown.before_mean, "mean_after": shown.after_mean}
        self.points = ColumnDataSource({name: _single(values) for name, values in columns.items()})

    @cached_property
    def trace(self) -> Column:
        """The error over the record, before with what is added drawn through it, and after."""
        x, reach = Range1d(), Range1d()
        panels = [self._errors(name, x, reach) for name in self.fits]
        span(x, self.shown.x)
        smooth = f"mean of {self.shown.window} samples" if self.shown.window > 1 else ""
        for one, (name, fit) in zip(panels, self.fits.items(), strict=True):
            one.vstrip(
                x0=[begin for begin, _, _ in self.shown.isobars[::2]],
                x1=[end for _, end, _ in self.shown.isobars[::2]],
                fill_color=SKY, fill_alpha=0.1, line_color=None, level="underlay",
            )  # fmt: skip
            self._name_isobars(one)
            words = _words(name, fit, len(self.fits))
            seen = dots(one, self.points, name, legend_label=words, size=self.size, **PALE)
            hover([one], [seen], tips(f"model_{name}", name)).mode = "vline"  # the sample above or below the pointer
            line: dict[str, Any] = {"color": SKY, "line_width": 2.5} if name == "before" else {"color": BLUE}
            one.line("x", f"mean_{name}", source=self.points, legend_label=smooth or words, **line)
        if self.after is not None:
            panels[0].line("x", "change", source=self.points, color=ORANGE, legend_label="what is added")
        panels[-1].xaxis.axis_label = self.shown.axis
        link(panels)
        return column(panels, sizing_mode="stretch_both")

    @cached_property
    def isobars(self) -> Column:
        """Force over contraction, measured and modelled, and the error of each fit below; parts are named by isobar."""
        x, reach, last = Range1d(), Range1d(), list(self.fits)[-1]
        force = panel("force (N)", x, **FILL, styles={"flex": "3 1 0"})
        panels = [force, *(self._errors(name, x, reach) for name in self.fits)]
        span(x, self.before.record.inputs.contraction[self.before.rows])
        span(force.y_range, self.before.record.force[self.before.rows])
        names = {level: gid for gid, level in measured_against_model.isobars(self.before).items()}
        seen: list[list[GlyphRenderer]] = [[] for _ in panels]
        for curve in measured_against_model.data(self.before, self.after, 0):
            (colour, dash), name = BRANCHES[curve.branch], names[curve.pressure_MPa]
            look = {"x": "contraction", "fill_color": colour, "size": self.size, "name": name}
            look |= {"view": self._view(curve)}
            branch = "" if curve.branch == "static" else f", {curve.branch}"
            force.line(
                curve.line, curve.line_force, name=name, line_width=1.5, color="gray", line_dash=dash,
                legend_label="model",
            )  # fmt: skip
            seen[0].append(dots(force, self.points, "measured", legend_label=f"measured{branch}", **look))
            for k, (name, fit) in enumerate(self.fits.items(), start=1):
                words = _words(name, fit, len(self.fits))
                seen[k].append(dots(panels[k], self.points, name, legend_label=words, **look))
        for one, over, name in zip(panels, seen, (last, *self.fits), strict=True):
            hover([one], over, tips(f"model_{name}", name))
        panels[-1].xaxis.axis_label = "contraction ratio ε (1)"
        link(panels)
        return column(panels, sizing_mode="stretch_both")

    def step(self, before: Fit, after: Fit, share: int) -> Column:
        """The `trace` of a step of a ladder, of one in `share` samples."""
        return Figures(before, after, self.limit // share).trace

    @staticmethod
    def mapped(comparison: Comparison) -> Column:
        """Where a model fails."""
        return mapped(comparison)

    def _name_isobars(self, on: Any) -> None:
        """The pressure of each stripe that has room for it."""
        whole = float(np.ptp(self.shown.x)) or 1.0
        for begin, end, level in self.shown.isobars:
            if (end - begin) / whole > LEAST_ROOM:
                look: dict[str, Any] = {"text_align": "center", "text_font_size": "11px", "text_color": "gray"}
                on.add_layout(Label(x=(begin + end) / 2, y=3, y_units="screen", text=f"{level:.3g} MPa", **look))

    def _errors(self, name: str, x: Range1d, reach: Range1d) -> Any:
        """An empty panel for an error; all have one scale."""
        most = max(float(np.abs(one.residual[one.rows]).max()) for one in self.fits.values())
        span(reach, (-most, most))
        made = panel("error (N)", x, reach, **FILL, styles={"flex": "2 1 0"}, name=name)
        made.add_layout(Span(dimension="width", location=0.0, line_color="gray", line_width=1))
        return made

    def _view(self, curve: measured_against_model.Curve) -> CDSView:
        """The samples of an isobar and branch."""
        record, rows = self.before.record, self.shown.rows
        sign = {"contraction": 1.0, "extension": -1.0}.get(curve.branch, 0.0)
        mine = (record.level[rows] == curve.pressure_MPa) & (record.inputs.direction[rows] == sign)
        return CDSView(filter=IndexFilter(indices=np.flatnonzero(mine).tolist()))


def _words(name: str, fit: Fit, of: int) -> str:
    return f"error {name if of > 1 else ''}".strip() + f": {newtons(fit.rmse)} rms"


def _single(values: np.ndarray) -> np.ndarray:
    """Numbers in single precision: a picture shows no more, and half the page is enough for them."""
    return values.astype(np.float32) if values.dtype.kind == "f" else values
