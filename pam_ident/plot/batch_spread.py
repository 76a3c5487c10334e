"""How a quantity is spread over many muscles, a panel each."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from .style import BLUE, FAINT, GREY, VERMILION, small_multiples, styled, thin

Array = np.ndarray


@dataclass(frozen=True)
class SpreadPanel:
    """One quantity: its values in ascending order, their standard errors (NaN where none is known) and the share of
    muscles below each, its own counted half, all of shape (n,), with the outliers' mask and the median."""

    name: str
    unit: str
    value: Array
    stderr: Array
    share: Array
    outlier: Array
    median: float


def data(name: str, unit: str, value: Array, stderr: Array, outlier: Array, limit: int = 400) -> SpreadPanel:
    """The panel of a quantity's values (n,); of more than `limit` muscles some are left out, never an outlier."""
    order = np.argsort(value, kind="stable")
    share = (np.arange(len(value)) + 0.5) / len(value)
    shown = np.union1d(thin(len(value), limit), np.flatnonzero(outlier[order]))
    pick = order[shown]
    return SpreadPanel(name, unit, value[pick], stderr[pick], share[shown], outlier[pick], float(np.median(value)))


@styled
def draw(panels: Sequence[SpreadPanel]) -> Figure:
    """Cumulative share over the value with bars of a standard error; the median as a line, outliers as triangles."""
    figure, grid = small_multiples(len(panels), 4, 0.3, 1.9, sharey=True)
    for axes, panel in zip(grid.flat, panels, strict=False):
        axes.axvline(panel.median, color=GREY, linewidth=0.9)
        bars = np.isfinite(panel.stderr)
        value, stderr = panel.value[bars], panel.stderr[bars]
        axes.hlines(panel.share[bars], value - stderr, value + stderr, color=FAINT, linewidth=1.2)
        for mask, colour, mark in ((~panel.outlier, BLUE, "o"), (panel.outlier, VERMILION, "^")):
            axes.plot(panel.value[mask], panel.share[mask], linestyle="", marker=mark, markersize=3.4, color=colour)
        axes.set_xlabel(f"{panel.name} ({panel.unit or '1'})")
        axes.locator_params(axis="x", nbins=4)
    for axes in grid[:, 0]:
        axes.set_ylabel("share of muscles (1)")
    return figure
