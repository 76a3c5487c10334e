"""Measured and modelled force over contraction, isobar by isobar, and what the model leaves."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..core.digits import newtons
from ..fitting import Fit
from . import over_pressure
from .curves import CELLS, by_isobar, label_isobars, model_curve, stride
from .style import BRANCH_COLOUR, BRANCH_DASH, BRANCH_MARK, BRANCH_NAME, GREY, INK, cloud, styled, thin

Array = np.ndarray


@dataclass(frozen=True)
class Curve:
    """One isobar and branch. Points (n,): contraction ratio, measured force and error before and after in N.

    `line` and `line_force` (m,) are the last model's curve, `half` (m,) half the width of its 95 % interval, NaN where
    there is none; `after` is None without a second fit.
    """

    pressure_MPa: float
    branch: str
    contraction: Array
    measured: Array
    before: Array
    after: Array | None
    line: Array
    line_force: Array
    half: Array


def data(fit: Fit, after: Fit | None = None, limit: int = 1500) -> tuple[Curve, ...]:
    """Curves by pressure and branch, at most `limit` points in all. The line is the last fit's.

    In a record in time the line is the model's mean over cells of contraction, all cycles and speeds
    together; in a static table it is the model itself at the isobar's pressure.
    """
    record, last = fit.record, after or fit
    groups = list(by_isobar(record, fit.rows))
    step = stride([len(rows) for _, _, rows in groups], limit)
    few = [rows[thin(len(rows), CELLS)] for _, _, rows in groups]
    halves = np.split(last.half_width(np.concatenate(few)), np.cumsum([len(f) for f in few])[:-1])
    curves = []
    for (level, sign, rows), taken, half in zip(groups, few, halves, strict=True):
        shown = rows[::step]
        line, line_force = model_curve(last, rows, sign)
        curves.append(
            Curve(
                level,
                BRANCH_NAME[sign],
                record.inputs.contraction[shown],
                record.force[shown],
                fit.residual[shown],
                after.residual[shown] if after else None,
                line,
                line_force,
                np.interp(line, record.inputs.contraction[taken], half),
            )
        )
    return tuple(curves)


@styled
def draw(fit: Fit, after: Fit | None = None, limit: int = 1500) -> Figure:
    """Force over contraction on top; below it the error of `fit`, and of `after` on the same scale. Where the pressure
    was driven and length or load held, what answered, over the pressure.

    The grey band in the lowest panel is the 95 % interval of the last fit's curve, the widest of all isobars.
    """
    if fit.record.drives_pressure:
        return over_pressure.draw(fit, after, limit)
    curves = data(fit, after, limit)
    figure, top, errors = over_pressure.panels(after)
    gids = {pressure: gid for gid, pressure in isobars(fit).items()}
    size = 3.2 if sum(len(c.measured) for c in curves) > 300 else 4.2
    for curve in curves:
        gid = gids[curve.pressure_MPa]
        colour, mark = BRANCH_COLOUR[curve.branch], BRANCH_MARK[curve.branch]
        look: dict[str, Any] = {"marker": mark, "gid": gid}
        cloud(top, curve.contraction, curve.measured, colour, size, **look)
        top.plot(curve.line, curve.line_force, color=INK, linestyle=BRANCH_DASH[curve.branch], linewidth=0.9, gid=gid)
        cloud(errors[0], curve.contraction, curve.before, colour, size, 0.45, **look)
        if curve.after is not None:
            cloud(errors[1], curve.contraction, curve.after, colour, size, 0.45, **look)
    top.set_ylabel("force (N)")
    label_isobars(top, curves)
    _legend(top, curves)
    reach = 1.08 * max(float(np.max(np.abs(c.before))) for c in curves)
    for panel, one in zip(errors, (fit, after), strict=False):
        panel.set_ylim(-reach, reach)
        panel.set_ylabel("error (N)")
        if one:
            panel.set_title(f"{panel.get_title('left')}: {newtons(one.rmse)} rms")
    grid, half = widest(curves)
    low = errors[-1]
    low.fill_between(grid, -half, half, color=GREY, alpha=0.3, linewidth=0.0, label="95 % interval of the model")
    low.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2, labelcolor=INK)
    low.set_xlabel("contraction ratio ε (1)")
    return figure


def isobars(fit: Fit) -> dict[str, float]:
    """Pressures in MPa by the id that the parts of an isobar have in the figure."""
    levels = dict.fromkeys(level for level, _, _ in by_isobar(fit.record, fit.rows))
    return {f"isobar-{k}": level for k, level in enumerate(levels, start=1)}


def widest(curves: tuple[Curve, ...]) -> tuple[Array, Array]:
    """Contraction and the largest half width in N of all curves that reach there, (m,) each; NaN where none does."""
    grid = np.linspace(min(c.line[0] for c in curves), max(c.line[-1] for c in curves), 4 * CELLS)
    halves = np.array([np.interp(grid, c.line, c.half, left=np.nan, right=np.nan) for c in curves])
    return grid, np.where(np.isnan(halves).all(axis=0), np.nan, np.nanmax(np.nan_to_num(halves, nan=0.0), axis=0))


def _legend(axes: Axes, curves: tuple[Curve, ...]) -> None:
    names = [n for n in BRANCH_COLOUR if any(c.branch == n for c in curves)]
    handles = []
    for name in names:
        word = "" if name == "static" else f", {name}"
        common = {"linestyle": "", "markersize": 4.5, "markeredgewidth": 0.0}
        handles.append(
            Line2D([], [], marker=BRANCH_MARK[name], color=BRANCH_COLOUR[name], label=f"measured{word}", **common)
        )
        handles.append(Line2D([], [], color=INK, linestyle=BRANCH_DASH[name], linewidth=1.2, label=f"model{word}"))
    axes.legend(handles=handles, loc="upper right", labelcolor=INK)
