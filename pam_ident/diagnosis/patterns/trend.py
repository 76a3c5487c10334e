"""A trend in time, of the force or of a sensor."""

from collections.abc import Sequence

from ...core import Inputs, Param
from ...effects import AddsForce, Form, ScalesForce, TransformsContraction, TransformsPressure
from ...effects.base import Array, Values
from .base import GAIN, SIZE, ZERO, Extent, PatternShape, hats, knots, like

KNOTS = 8
STRETCH = Param("stretch", "mm", "shift of the length by the end", -20.0, 20.0, scale=0.1)
SENSE = Param("sense", "1", "change of the pressure's scale by the end", -0.5, 0.5, scale=0.01)


def _passed(inputs: Inputs, values: Values, force: Array) -> Array:
    """Share of the record's time that has passed, shape (n, 1)."""
    assert inputs.time is not None
    passed = inputs.time - inputs.time[0]
    return like(inputs, passed / max(float(passed[-1]), 1e-9))[:, None]


def _of_length(inputs: Inputs, values: Values, force: Array) -> Array:
    return _passed(inputs, values, force) / inputs.specimen.initial_length_mm


def _of_pressure(inputs: Inputs, values: Values, force: Array) -> Array:
    return _passed(inputs, values, force) * inputs.pressure[:, None]


def _of_stiffness(inputs: Inputs, values: Values, force: Array) -> Array:
    return _passed(inputs, values, force) * inputs.contraction[:, None]


def _curve(inputs: Inputs, values: Values, force: Array) -> Array:
    assert inputs.time is not None
    return hats(inputs.time, KNOTS)[:, 1:]


def _forms(span: Extent) -> Sequence[Form]:
    return (
        AddsForce("even", "free curve", knots(KNOTS - 1), _curve),
        ScalesForce("gain", "trend of the force's scale", (GAIN,), _passed),
        AddsForce("stiffness", "trend of the stiffness", (SIZE,), _of_stiffness),
        TransformsContraction("length", "trend of the length", (STRETCH,), _of_length),
        TransformsPressure("pressure", "trend of the pressure's scale", (SENSE,), _of_pressure),
        TransformsPressure("zero", "trend of the pressure's zero", (ZERO,), _passed),
    )


PATTERN = PatternShape(
    "trend",
    "trend in time",
    "trend",
    "time",
    _forms,
    lambda at, along: "a trend in time that no known drift follows",
)
