"""A ripple over displacement, such as the pitch of a spindle leaves."""

from collections.abc import Sequence
from functools import lru_cache, partial

import numpy as np

from ...core import Inputs
from ...core.digits import number
from ...effects import AddsForce, Form
from ...effects._history import runs, way_since_reversal
from ...effects.base import Array, Values, slip
from ...records.roughness import position_noise
from ...records.smoothing import FEWEST, along, smooth_basis
from .base import SINCE_REVERSAL, WAVE, Extent, PatternShape, like, searched, wave

NEARLY = 3.0
"""Noises of the length that a smooth course may miss of a stroke: it speeds up and brakes."""


@lru_cache(maxsize=8)
def _course(inputs: Inputs, blurred: float) -> Array:
    """The displacement in mm, (n,), along the smooth course of each stroke that has one; of rows that are read within
    so many mm of each other, and none just beyond, the mean.

    In strokes that are read at the same places again, a wave as short as their distance would follow what the sensor
    is off there, and with it the error that this makes of the force.
    """
    x = inputs.displacement_mm.astype(float)
    if inputs.time is None or inputs.moving is None:
        return like(inputs, x)
    order = np.argsort(x)
    for rows in np.split(order, np.flatnonzero(np.diff(x[order]) > 0.5 * blurred) + 1):
        if len(rows) and np.ptp(x[rows]) < 1.5 * blurred:
            x[rows] = x[rows].mean()
    for part in runs(inputs):
        rows = part.start + np.flatnonzero(inputs.moving[part])
        if len(rows) >= FEWEST and np.ptp(inputs.time[rows]) > 0.0:
            smooth = along(smooth_basis(inputs.time[rows], len(rows)), x[rows])
            if np.std(x[rows] - smooth) < NEARLY * position_noise(x[rows], inputs.time[rows]):
                x[rows] = smooth
    return like(inputs, x)


def _ripple(inputs: Inputs, values: Values, force: Array, blurred: float) -> Array:
    return wave(_course(inputs, blurred), values["period"])


def _loaded_ripple(inputs: Inputs, values: Values, force: Array, blurred: float) -> Array:
    return _ripple(inputs, values, force, blurred) * (force / max(float(np.mean(np.abs(force))), 1e-9))[:, None]


def _odd_ripple(inputs: Inputs, values: Values, force: Array, blurred: float) -> Array:
    return _ripple(inputs, values, force, blurred) * slip(inputs)[0][:, None]


def _stick_slip(inputs: Inputs, values: Values, force: Array) -> Array:
    """Sticking and letting go: the first tooth begins at the reversal."""
    return wave(way_since_reversal(inputs), values["period"]) * slip(inputs)[0][:, None]


def _forms(span: Extent) -> Sequence[Form]:
    numbers = np.arange(1.0, max(2.0, span.stroke / max(1.0, 2.0 * span.blurred)), 0.25)[::-1]
    periods = [span.stroke / k for k in numbers if span.stroke / k < 0.5 * span.stroke]
    period = searched("period", "mm", "period over displacement", periods or [0.25 * span.stroke])
    even, loaded, odd = (partial(one, blurred=span.blurred) for one in (_ripple, _loaded_ripple, _odd_ripple))
    return (
        AddsForce("even", "ripple", WAVE, even, (period,)),
        AddsForce("loaded", "ripple in proportion to force", WAVE, loaded, (period,), uses_force=True),
        AddsForce("odd", "ripple against motion", WAVE, odd, (period,)),
        AddsForce("stick_slip", "ripple against motion over the way since a reversal", WAVE, _stick_slip, (period,)),
    )


PATTERN = PatternShape(
    "periodic",
    "ripple over displacement",
    "periodic",
    "displacement",
    _forms,
    lambda at, along: f"a ripple over {along} with a period of {number(at['period'], 3)} mm",
    {"stick_slip": SINCE_REVERSAL},
)
