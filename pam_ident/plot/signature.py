"""The trace an added effect leaves: error before and after it, and what it changes in the model."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..core.digits import newtons
from ..fitting import Fit
from ..records import Record
from ..records.motion import long_pause
from .style import BLUE, GREY, INK, SKY, VERMILION, WIDTH, canvas, cloud, running_mean, styled, thin, zero_line

Array = np.ndarray


@dataclass(frozen=True)
class Signature:
    """Errors in N over the record, shape (points,) each, at the places `x`, which are the record's `rows`: `before` and
    `after`, their running means over `window` samples, and `effect`, the change of the modelled force.

    `isobars` are (begin, end, pressure in MPa) along the same axis.
    """

    axis: str
    rows: Array
    x: Array
    before: Array
    after: Array
    before_mean: Array
    after_mean: Array
    effect: Array
    window: int
    isobars: tuple[tuple[float, float, float], ...]


def data(before: Fit, after: Fit, limit: int = 1500) -> Signature:
    """Errors of two fits of the same record, sample by sample, at most `limit` points and line vertices.

    The axis is time where all strokes have about one speed; else the sample number, which gives fast strokes
    as much room as slow ones. A table is sorted by pressure and contraction.
    """
    record = before.record
    order = np.arange(len(record))
    if record.inputs.time is None:
        order = np.lexsort((record.inputs.contraction, record.inputs.direction, record.level))
    order = order[before.rows[order]]
    axis, place = _place(record, order)
    window = _window(record, order)
    old, new = before.residual[order], after.residual[order]
    pick = thin(len(order), limit)
    return Signature(
        axis,
        order[pick],
        place[pick],
        old[pick],
        new[pick],
        running_mean(old, window)[pick],
        running_mean(new, window)[pick],
        (after.force - before.force)[order][pick],
        window,
        _isobars(record.level[order], place) if record.inputs.pressure_rate is None else (),
    )


def _place(record: Record, order: Array) -> tuple[str, Array]:
    inputs = record.inputs
    if inputs.time is None:
        return "sample, sorted by pressure and contraction (number)", np.arange(1.0, len(order) + 1.0)
    speed = inputs.stroke_speed
    positive = speed[speed > 0] if speed is not None else np.ones(1)
    if len(positive) and np.quantile(positive, 0.95) > 3.0 * np.quantile(positive, 0.05):
        return "sample in order of time (number)", np.arange(1.0, len(order) + 1.0)
    return "time (s)", inputs.time[order]


def _window(record: Record, order: Array) -> int:
    """An odd number of samples: an eighth of the usual stroke in a record in time, one in a table."""
    if record.inputs.time is None:
        return 1
    _, counts = np.unique(record.stroke[order], return_counts=True)
    return 2 * int(np.clip(np.median(counts) / 16, 1, 200)) + 1


def _isobars(level: Array, place: Array) -> tuple[tuple[float, float, float], ...]:
    edges = np.r_[0, np.flatnonzero(np.diff(level)) + 1, len(level)]
    return tuple((float(place[a]), float(place[b - 1]), float(level[a])) for a, b in pairwise(edges))


@styled
def draw(before: Fit, after: Fit | None = None, limit: int = 1500, width: float = WIDTH) -> Figure:
    """Error before with the effect's trace through it, and below what is left after, on one scale.

    Without a second fit the first's error alone. Below the usual `width` (inches) no title names what was added.
    """
    shown = data(before, after or before, limit)
    figure = canvas(5.2 if after else 3.0, width)
    panels = figure.subplots(2 if after else 1, 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    top, low = panels[0], panels[-1]
    smooth = f"mean of {shown.window} samples" if shown.window > 1 else ""
    size = 3.2 if len(shown.x) > 300 else 6.0
    cloud(top, shown.x, shown.before, GREY, size, 0.45, marker=".")
    top.plot(*_in_pieces(shown.x, shown.before_mean), color=SKY, linewidth=2.4, label=smooth or "error")
    top.set_title(f"{'Before' if after else 'Error'}: {newtons(before.rmse)} rms")
    if after is not None:
        top.plot(*_in_pieces(shown.x, shown.effect), color=VERMILION, linewidth=1.0, label="what is added")
        cloud(low, shown.x, shown.after, GREY, size, 0.45, marker=".")
        low.plot(*_in_pieces(shown.x, shown.after_mean), color=BLUE, linewidth=1.1, label=smooth or "error")
        low.set_title(f"After{'' if width < WIDTH else _added(before, after)}: {newtons(after.rmse)} rms")
    for axes in panels:
        zero_line(axes)
        axes.set_ylabel("error (N)")
        _mark_isobars(axes, shown, width)
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.2, labelcolor=INK)
    low.set_xlabel(shown.axis)
    reach = 1.3 * float(np.quantile(np.abs(np.r_[shown.before, shown.after]), 0.995))
    top.set_ylim(-reach, reach)
    return figure


def _in_pieces(x: Array, y: Array) -> tuple[Array, Array]:
    """A line (n,) that ends where the record pauses, and begins anew behind that."""
    steps = np.diff(x)
    behind = np.flatnonzero(steps > long_pause(float(np.quantile(steps, 0.95)) if len(steps) else 0.0)) + 1
    return np.insert(x, behind, np.nan), np.insert(y, behind, np.nan)


def _added(before: Fit, after: Fit) -> str:
    new = [effect.title for effect in after.model.own if effect.name not in before.model.effect_names]
    return f" adding {', '.join(new or ['nothing']) if sum(map(len, new)) < 40 else f'{len(new)} effects'}"


def _mark_isobars(axes: Axes, shown: Signature, width: float) -> None:
    """Pale stripes for every second isobar and the pressure in each, as far as there is room."""
    whole = float(np.ptp(shown.x)) or 1.0
    room = 0.075 * WIDTH / width
    for i, (begin, end, level) in enumerate(shown.isobars):
        if i % 2 == 0:
            axes.axvspan(begin, end, color=SKY, alpha=0.1, linewidth=0.0, zorder=0)
        if (end - begin) / whole > room:
            place = {"transform": axes.get_xaxis_transform(), "ha": "center", "va": "top"}
            axes.text(0.5 * (begin + end), 0.98, f"{level:.3g} MPa", fontsize=8.0, color=GREY, **place)
