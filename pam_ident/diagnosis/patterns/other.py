"""A free curve over contraction or pressure: what depends on them in a way that no effect does."""

from collections.abc import Sequence

import numpy as np

from ...core import Inputs
from ...effects import AddsForce, Form
from ...effects.base import Array, Values, slip
from ..schedule import mean_of_each
from .base import Extent, PatternShape, hats, knots

KNOTS, PRESSURE_KNOTS = 9, 5
BETWEEN_LEVELS = 0.02
"""Share of their range by which pressures that are held differ."""


def _even(inputs: Inputs, values: Values, force: Array) -> Array:
    return hats(inputs.contraction, KNOTS)


def _odd(inputs: Inputs, values: Values, force: Array) -> Array:
    return -hats(inputs.contraction, KNOTS) * slip(inputs)[0][:, None]


def _pressed(inputs: Inputs, values: Values, force: Array) -> Array:
    return hats(inputs.contraction, KNOTS) * inputs.pressure[:, None]


def _over_pressure(inputs: Inputs, values: Values, force: Array) -> Array:
    return hats(inputs.pressure, PRESSURE_KNOTS)[:, 1:]


def _levels(inputs: Inputs) -> int:
    """How many pressures there are. Of held ones readings differ by their noise, which a curve with more knots than
    levels would follow, and are none."""
    if inputs.time is None or inputs.segment is None or inputs.pressure_rate is not None:
        return len(np.unique(np.round(inputs.pressure, 2)))
    means = np.unique(mean_of_each(inputs.segment, inputs.pressure))
    return 1 + int(np.count_nonzero(np.diff(means) > BETWEEN_LEVELS * float(np.ptp(means))))


def _forms(span: Extent) -> Sequence[Form]:
    over_pressure = AddsForce("over_pressure", "free curve over pressure", knots(PRESSURE_KNOTS - 1), _over_pressure)
    return (
        AddsForce("even", "free curve", knots(KNOTS), _even),
        AddsForce("odd", "free curve against motion", knots(KNOTS), _odd),
        AddsForce("pressed", "free curve in proportion to pressure", knots(KNOTS), _pressed),
        *([over_pressure] if _levels(span.inputs) >= PRESSURE_KNOTS else []),
    )


PATTERN = PatternShape(
    "other",
    "free curve over contraction",
    "other",
    "contraction",
    _forms,
    lambda at, along: f"a dependence on {along} that no known effect follows",
    {"over_pressure": "pressure"},
)
