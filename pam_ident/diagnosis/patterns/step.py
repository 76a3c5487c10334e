"""A step in time: a mount that slips, a gauge whose zero jumps."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...core import Inputs, Param
from ...core.digits import number
from ...effects import AddsForce, Form, ScalesForce, TransformsContraction, TransformsPressure
from ...effects.base import Array, Values
from .base import GAIN, SIZE, ZERO, Extent, PatternShape, after, like

LATER = Param("later", "N", "size of the second", scale=10.0)
SHIFT = Param("shift", "mm", "shift of the length", -20.0, 20.0, scale=0.1)


def _force_step(inputs: Inputs, values: Values, force: Array) -> Array:
    return after(inputs, values)


def _two_steps(inputs: Inputs, values: Values, force: Array) -> Array:
    ordered = like(inputs, np.where(np.asarray(values["end"]) > values["moment"], 1.0, np.nan))  # else no pair
    return np.hstack([after(inputs, values) * ordered, after(inputs, {"moment": values["end"]})])


def _length_step(inputs: Inputs, values: Values, force: Array) -> Array:
    return after(inputs, values) / inputs.specimen.initial_length_mm


def _forms(span: Extent) -> Sequence[Form]:
    moment, end = span.moment(), replace(span.moment(24), name="end", doc="when it ends")  # each is zoomed in on alone
    return (
        AddsForce("force", "step of the force", (SIZE,), _force_step, (moment,)),
        AddsForce("two", "two steps of the force", (SIZE, LATER), _two_steps, (span.moment(50), end)),
        ScalesForce("gain", "step of the force's scale", (GAIN,), _force_step, (moment,)),
        TransformsContraction("length", "step of the length", (SHIFT,), _length_step, (moment,)),
        TransformsPressure("pressure", "step of the pressure", (ZERO,), _force_step, (moment,)),
    )


PATTERN = PatternShape(
    "step",
    "step in time",
    "step",
    "time",
    _forms,
    lambda at, along: f"a step at {number(at['moment'])} s",
)
