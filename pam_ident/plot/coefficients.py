"""Coefficients of each isobar over pressure (Figure 9 of the paper), with a straight line through them."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..fitting import IsobarTable
from .style import BRANCH_COLOUR, BRANCH_DASH, BRANCH_MARK, INK, small_multiples, styled

Array = np.ndarray


@dataclass(frozen=True)
class Coefficient:
    """One coefficient of one branch: pressure in MPa, value and standard error in `unit`, (isobars,) each.

    `intercept` (unit) and `slope` (unit/MPa) are those of the least-squares line, `r` its correlation coefficient;
    NaN from fewer than two isobars, and r where the values do not vary. What an isobar alone does not identify is left
    out.
    """

    name: str
    unit: str
    branch: str
    pressure: Array
    value: Array
    stderr: Array
    at_bound: Array
    intercept: float
    slope: float
    r: float


def data(table: IsobarTable) -> tuple[Coefficient, ...]:
    """By name, then by branch."""
    found: dict[tuple[str, str], list[tuple[float, float, float, bool]]] = {}
    units: dict[str, str] = {}
    for row in sorted(table.rows, key=lambda row: row.pressure_MPa):
        for e in (e for e in row.estimates if e.identified or e.at_bound):
            units[e.name] = e.unit
            found.setdefault((e.name, row.branch), []).append((row.pressure_MPa, e.value, e.stderr, e.at_bound))
    return tuple(_coefficient(name, units[name], branch, found[name, branch]) for name, branch in sorted(found))


def _coefficient(name: str, unit: str, branch: str, points: list[tuple[float, float, float, bool]]) -> Coefficient:
    pressure, value, stderr, at_bound = (np.array(column) for column in zip(*points, strict=True))
    slope = intercept = r = math.nan
    if len(pressure) > 1:
        slope, intercept = map(float, np.polyfit(pressure, value, 1))
        if np.ptp(value) > 0.0:
            r = float(np.corrcoef(pressure, value)[0, 1])
    return Coefficient(name, unit, branch, pressure, value, stderr, at_bound, intercept, slope, r)


@styled
def draw(table: IsobarTable) -> Figure:
    """A panel a coefficient; bars are ± one standard error, hollow marks lie at a bound of the fit."""
    shown = data(table)
    names = list(dict.fromkeys(c.name for c in shown))
    figure, grid = small_multiples(len(names), 3, 0.3, 3.2)
    for axes, name in zip(grid.flat, names, strict=False):
        mine = [c for c in shown if c.name == name]
        for coefficient in mine:
            _points(axes, coefficient)
        axes.set_xlabel("pressure (MPa)")
        axes.set_ylabel(f"{name} ({mine[0].unit})")
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), labelcolor=INK)
    return figure


def _points(axes: Axes, c: Coefficient) -> None:
    look = "static" if c.branch == "together" else c.branch
    colour = BRANCH_COLOUR[look]
    word = "both branches" if c.branch == "together" else c.branch
    marks: dict[str, Any] = {"linestyle": "", "marker": BRANCH_MARK[look], "markersize": 5.0}
    label = word + (f", r = {c.r:.4f}".replace("-", "−") if math.isfinite(c.r) else "")
    error = np.nan_to_num(c.stderr)
    axes.errorbar(c.pressure, c.value, error, color=colour, capsize=2.5, elinewidth=1.0, label=label, **marks)
    if c.at_bound.any():
        hollow = {"markeredgecolor": colour, "markerfacecolor": "white", "zorder": 3}
        at = c.pressure[c.at_bound], c.value[c.at_bound]
        axes.plot(*at, label=f"{word}, at a bound of the fit", **hollow, **marks)
    if math.isfinite(c.slope):
        ends = c.pressure[[0, -1]]
        axes.plot(ends, c.intercept + c.slope * ends, color=colour, linestyle=BRANCH_DASH[look], linewidth=1.1)
