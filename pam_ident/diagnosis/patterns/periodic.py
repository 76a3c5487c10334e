"""A ripple over displacement, such as the pitch of a spindle leaves."""

from collections.abc import Sequence

import numpy as np

from ...core import Inputs
from ...core.digits import number
from ...effects import AddsForce, Form
from ...effects._history import way_since_reversal
from ...effects.base import Array, Values, slip
from .base import SINCE_REVERSAL, WAVE, Extent, PatternShape, searched, wave


def _ripple(inputs: Inputs, values: Values, force: Array) -> Array:
    return wave(inputs.displacement_mm, values["period"])


def _loaded_ripple(inputs: Inputs, values: Values, force: Array) -> Array:
    return _ripple(inputs, values, force) * (force / max(float(np.mean(np.abs(force))), 1e-9))[:, None]


def _odd_ripple(inputs: Inputs, values: Values, force: Array) -> Array:
    return _ripple(inputs, values, force) * slip(inputs)[0][:, None]


def _stick_slip(inputs: Inputs, values: Values, force: Array) -> Array:
    """Sticking and letting go: the first tooth begins at the reversal."""
    return wave(way_since_reversal(inputs), values["period"]) * slip(inputs)[0][:, None]


def _forms(span: Extent) -> Sequence[Form]:
    numbers = np.arange(1.0, max(2.0, span.stroke / max(1.0, 2.0 * span.blurred)), 0.25)[::-1]
    periods = [span.stroke / k for k in numbers if span.stroke / k < 0.5 * span.stroke]
    period = searched("period", "mm", "period over displacement", periods or [0.25 * span.stroke])
    return (
        AddsForce("even", "ripple", WAVE, _ripple, (period,)),
        AddsForce("loaded", "ripple in proportion to force", WAVE, _loaded_ripple, (period,), uses_force=True),
        AddsForce("odd", "ripple against motion", WAVE, _odd_ripple, (period,)),
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
