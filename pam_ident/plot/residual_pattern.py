"""What is left of the error along the coordinate in which it has a shape."""

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from ..core.digits import number
from ..diagnosis.nouns import Pattern
from ..fitting import Fit
from ..records import Record
from .style import BRANCH_COLOUR, BRANCH_DASH, BRANCH_NAME, GREY, INK, canvas, styled, zero_line

Array = np.ndarray
MAX_PERIODS = 20


@dataclass(frozen=True)
class Series:
    """Binned error of one branch (or `all`): centres, mean and standard error of the mean in N, samples; (bins,)."""

    branch: str
    centre: Array
    mean: Array
    error: Array
    n: Array


@dataclass(frozen=True)
class PatternData:
    """Series along `axis`; `marks` are places on it to point at, such as a moment or the ends of periods."""

    axis: str
    series: tuple[Series, ...]
    marks: tuple[float, ...]
    folded: bool


def coordinate(record: Record, pattern: Pattern) -> tuple[str, Array]:
    """Axis label and value of every sample, shape (n,), of what a pattern runs along.

    The unit decides between contraction as a ratio and in mm. Falls back on the sample number.
    """
    inputs, name = record.inputs, pattern.coordinate.split("_")[0].lower()
    if name in ("contraction", "displacement", "length", "place", "direction"):
        if pattern.unit in ("1", ""):
            return "contraction ratio ε (1)", inputs.contraction
        return "contraction (mm)", inputs.displacement_mm
    known = {
        "time": ("time (s)", inputs.time),
        "pressure": ("pressure (MPa)", inputs.pressure),
        "cycle": ("cycle (number)", inputs.cycle),
        "temperature": ("temperature (°C)", inputs.temperature),
        "speed": ("speed of the stroke (mm/s)", inputs.stroke_speed),
    }
    label, values = known.get(name, ("", None))
    if values is None:
        return "sample in order of time (number)", np.arange(1.0, len(record) + 1.0)
    return label, values


def data(fit: Fit, pattern: Pattern, bins: int = 40) -> PatternData:
    """Mean error of `fit` in cells along the pattern's coordinate, by branch where the coordinate is a length.

    A periodic pattern is folded onto one period when the record spans more than twenty.
    """
    record, rows = fit.record, fit.rows
    axis, values = coordinate(record, pattern)
    low, span = float(values[rows].min()), max(float(np.ptp(values[rows])), 1e-12)
    marks: tuple[float, ...] = ()
    folded = False
    if pattern.kind == "periodic" and pattern.value:
        if span / pattern.value > MAX_PERIODS:
            axis = f"{axis} within a period of {number(pattern.value, 3)} {pattern.unit}"
            values, folded = values - low, True
            values, low, span = values % pattern.value, 0.0, pattern.value
        else:
            bins = max(bins, min(int(10 * span / pattern.value), 200))
            marks = tuple(float(v) for v in np.arange(low, low + span, pattern.value)[1:])
    elif pattern.value is not None and pattern.kind in ("local", "step"):
        marks = (float(pattern.value),)
    edges = np.linspace(low, low + span, bins + 1)
    direction = record.inputs.direction
    signs = [s for s in BRANCH_NAME if np.any(direction[rows] == s)] if axis.startswith("contraction") else []
    if signs:
        series = [_series(BRANCH_NAME[s], values, fit.residual, rows & (direction == s), edges) for s in signs]
    else:
        series = [_series("all", values, fit.residual, rows, edges)]
    return PatternData(axis, tuple(series), marks, folded)


def _series(branch: str, values: Array, residual: Array, rows: Array, edges: Array) -> Series:
    cell = np.clip(np.searchsorted(edges, values[rows], side="right") - 1, 0, len(edges) - 2)
    size = len(edges) - 1
    n = np.bincount(cell, minlength=size)
    full = n > 0
    count = n[full]
    mean = np.bincount(cell, residual[rows], size)[full] / count
    square = np.bincount(cell, residual[rows] ** 2, size)[full] / count
    spread = np.sqrt(np.maximum(square - mean**2, 0.0) * count / np.maximum(count - 1, 1))
    centre = (0.5 * (edges[1:] + edges[:-1]))[full]
    return Series(branch, centre, mean, spread / np.sqrt(count), count)


@styled
def draw(fit: Fit, pattern: Pattern, bins: int = 40) -> Figure:
    """Mean error with a band of ± 2 standard errors over the pattern's coordinate, its place or periods marked."""
    shown = data(fit, pattern, bins)
    figure = canvas(3.4)
    axes = figure.subplots()
    zero_line(axes)
    for mark in shown.marks:
        axes.axvline(mark, color=GREY, linewidth=1.0, linestyle=":")
    if len(shown.marks) == 1:
        place = {"transform": axes.get_xaxis_transform(), "ha": "center", "va": "bottom"}
        mark = shown.marks[0]
        axes.text(mark, 1.01, f"{number(mark)} {pattern.unit}", color=GREY, fontsize=8.5, **place)
    for series in shown.series:
        colour = BRANCH_COLOUR.get(series.branch, INK)
        ends = series.mean - 2 * series.error, series.mean + 2 * series.error
        axes.fill_between(series.centre, *ends, color=colour, alpha=0.18, linewidth=0.0)
        line = {"linestyle": BRANCH_DASH.get(series.branch, "-"), "linewidth": 1.3, "marker": ".", "markersize": 4.0}
        axes.plot(series.centre, series.mean, color=colour, label=series.branch, **line)
    if len(shown.series) > 1:
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.2, labelcolor=INK)
    axes.set_xlabel(shown.axis)
    axes.set_ylabel("mean error left (N)")
    return figure
