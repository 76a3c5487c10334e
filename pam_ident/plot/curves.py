"""What figures of force over contraction share: samples by isobar and branch, mean curves, pressures as labels."""

from collections.abc import Iterator, Sequence
from typing import Protocol

import numpy as np
from matplotlib.axes import Axes

from ..core import Inputs
from ..fitting import Fit
from ..records import Record
from .style import spread, thin

Array = np.ndarray
CELLS = 60
MOST_LABELS = 12


def by_isobar(record: Record, rows: Array | None = None) -> Iterator[tuple[float, float, Array]]:
    """Pressure in MPa, direction and samples of each isobar and branch among `rows` (mask (n,), default all).

    The samples are numbers in the order of contraction, so that every n-th of them still covers the stroke.
    """
    kept = np.ones(len(record), bool) if rows is None else rows
    for level in record.levels:
        for sign in (1.0, -1.0, 0.0):
            found = np.flatnonzero(kept & (record.level == level) & (record.inputs.direction == sign))
            if len(found):
                yield float(level), sign, found[np.argsort(record.inputs.contraction[found], kind="stable")]


def stride(sizes: Sequence[int], limit: int) -> int:
    """The smallest step through curves of so many points that leaves at most `limit` in all, or one a curve."""
    step = 1
    while sum(-(-n // step) for n in sizes) > max(limit, len(sizes)) and step < max(sizes):
        step += 1
    return step


def mean_curve(contraction: Array, force: Array) -> tuple[Array, Array]:
    """Mean contraction and force, (m,) each, in at most CELLS equal cells of contraction; both given as (n,)."""
    width = max(float(np.ptp(contraction)), 1e-12) / CELLS
    cell = np.minimum(((contraction - contraction.min()) / width).astype(int), CELLS - 1)
    count = np.bincount(cell, minlength=CELLS)
    full = count > 0
    means = (np.bincount(cell, values, CELLS)[full] / count[full] for values in (contraction, force))
    return tuple(means)  # type: ignore[return-value]


def model_curve(fit: Fit, rows: Array, sign: float) -> tuple[Array, Array]:
    """Contraction and the model's force in N, (m,) each, along the samples `rows` of one isobar and branch.

    In a record in time the mean over cells of contraction, all cycles and speeds together; in a static table the
    model itself at the isobar's mean pressure.
    """
    inputs = fit.record.inputs
    contraction = inputs.contraction[rows]
    if inputs.time is not None or np.ptp(contraction) == 0.0:
        return mean_curve(contraction, fit.force[rows])
    grid = np.linspace(contraction.min(), contraction.max(), CELLS)
    ones = np.ones(CELLS)
    dense = Inputs(
        pressure=inputs.pressure[rows].mean() * ones,
        contraction=grid,
        specimen=inputs.specimen,
        direction=sign * ones,
        temperature=None if inputs.temperature is None else inputs.temperature[rows].mean() * ones,
    )
    return grid, fit.model.force(dense, fit.values)


class Line(Protocol):
    """A curve of one isobar: contraction and force in N, (m,) each."""

    @property
    def pressure_MPa(self) -> float:
        """Pressure of the isobar."""
        ...

    @property
    def line(self) -> Array:
        """Contraction ratio."""
        ...

    @property
    def line_force(self) -> Array:
        """Force."""
        ...


def label_isobars(axes: Axes, curves: Sequence[Line]) -> None:
    """Pressure beside the left end of each isobar's curves, moved apart where labels would overlap."""
    pressures = dict.fromkeys(c.pressure_MPa for c in curves)
    starts = {p: float(np.mean([c.line_force[0] for c in curves if c.pressure_MPa == p])) for p in pressures}
    left, right = min(float(c.line[0]) for c in curves), max(float(c.line[-1]) for c in curves)
    levels = sorted(starts)
    levels = [levels[i] for i in thin(len(levels), MOST_LABELS)]
    span = right - left or 0.01
    low, high = axes.get_ylim()
    places = spread(np.array([starts[level] for level in levels]), 0.047 * (high - low))
    for level, place in zip(levels, places, strict=True):
        axes.text(left - 0.012 * span, place, f"{level:.3g} MPa", ha="right", va="center", fontsize=8.5, clip_on=False)
    axes.set_xlim(left - 0.1 * span, left + 1.03 * span)
    axes.set_ylim(min(low, float(places.min())), max(high, float(places.max())))
