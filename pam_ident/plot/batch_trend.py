"""A quantity of many muscles over what they differ in, a panel each."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from .style import BLUE, INK, VERMILION, small_multiples, styled, thin

Array = np.ndarray


@dataclass(frozen=True)
class TrendPanel:
    """One quantity `name` over `over`, a point a muscle: x, y and the outliers' mask, shape (n,), and the ends of a
    robust straight line, shape (2,) each."""

    name: str
    over: str
    title: str
    x: Array
    y: Array
    outlier: Array
    line_x: Array
    line_y: Array


def data(
    name: str,
    over: str,
    title: str,
    x: Array,
    y: Array,
    outlier: Array,
    line: tuple[float, float],
    limit: int = 400,
) -> TrendPanel:
    """The panel of points (n,) with the line (slope, intercept); beyond `limit` points some are left out."""
    shown = np.union1d(thin(len(x), limit), np.flatnonzero(outlier))
    ends = np.array([x.min(), x.max()])
    return TrendPanel(name, over, title, x[shown], y[shown], outlier[shown], ends, line[1] + line[0] * ends)


@styled
def draw(panels: Sequence[TrendPanel]) -> Figure:
    """Points with a robust straight line; outliers as triangles."""
    figure, grid = small_multiples(len(panels), 3, 0.3, 2.4)
    for axes, panel in zip(grid.flat, panels, strict=False):
        for mask, colour, mark in ((~panel.outlier, BLUE, "o"), (panel.outlier, VERMILION, "^")):
            axes.plot(panel.x[mask], panel.y[mask], linestyle="", marker=mark, markersize=3.6, color=colour)
        axes.plot(panel.line_x, panel.line_y, color=INK, linewidth=1.2)
        axes.set(xlabel=panel.over, ylabel=panel.name, title=panel.title)
        axes.locator_params(axis="x", nbins=4)
    return figure
