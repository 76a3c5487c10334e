"""Measured force over contraction, an isobar each (Figure 7 of the paper), from any record."""

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..records import Record
from .curves import by_isobar, label_isobars, mean_curve, stride
from .style import BRANCH_COLOUR, BRANCH_DASH, BRANCH_MARK, BRANCH_NAME, INK, canvas, cloud, styled

Array = np.ndarray


@dataclass(frozen=True)
class IsobarPoints:
    """One isobar and branch: points (n,) and their mean over cells of contraction (m,), forces in N."""

    pressure_MPa: float
    branch: str
    contraction: Array
    force: Array
    line: Array
    line_force: Array


def data(record: Record, limit: int = 1500) -> tuple[IsobarPoints, ...]:
    """Isobars by pressure and branch, at most `limit` points in all; the mean is over all samples."""
    groups = list(by_isobar(record))
    step = stride([len(rows) for _, _, rows in groups], limit)
    found = []
    for level, sign, rows in groups:
        contraction, force = record.inputs.contraction[rows], record.force[rows]
        line, line_force = mean_curve(contraction, force)
        found.append(IsobarPoints(level, BRANCH_NAME[sign], contraction[::step], force[::step], line, line_force))
    return tuple(found)


@styled
def draw(record: Record, limit: int = 1500) -> Figure:
    """Samples as pale points, their mean as a line, the pressure at the left end of each isobar."""
    curves = data(record, limit)
    size = 3.2 if sum(len(c.force) for c in curves) > 300 else 4.2
    figure = canvas(4.8)
    axes = figure.subplots()
    for curve in curves:
        colour = BRANCH_COLOUR[curve.branch]
        cloud(axes, curve.contraction, curve.force, colour, size, marker=BRANCH_MARK[curve.branch])
        axes.plot(curve.line, curve.line_force, color=colour, linestyle=BRANCH_DASH[curve.branch], linewidth=1.2)
    label_isobars(axes, curves)
    axes.set_title("Measured (points) and their mean (lines)")
    axes.set_xlabel("contraction ratio ε (1)")
    axes.set_ylabel("force (N)")
    shown = [name for name in BRANCH_COLOUR if any(c.branch == name for c in curves)]
    handles = []
    for name in shown:
        look = {"color": BRANCH_COLOUR[name], "linestyle": BRANCH_DASH[name], "marker": BRANCH_MARK[name]}
        label = "no branch" if name == "static" else name
        handles.append(Line2D([], [], markersize=4.5, markeredgewidth=0.0, linewidth=1.2, label=label, **look))
    axes.legend(handles=handles, loc="upper right", labelcolor=INK)
    return figure
