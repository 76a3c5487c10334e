"""What a sensor adds by itself: its error follows its own reading, the temperature or the clock, and is the same
whatever the muscle does."""

from collections.abc import Sequence

import numpy as np

from ...core import Inputs, Param
from ...effects import AddsForce, Form, TransformsPressure
from ...effects._history import since_first
from ...effects.base import Array, Values
from .base import Extent, PatternShape, hats, knots

READINGS, MOMENTS = 6, 5
SENSORS = {"force": "a load cell", "time": "the zero of a pressure sensor", "temperature": "the zero of a sensor"}
PER_KELVIN = Param("per_kelvin", "N/K", "zero of the load cell", scale=1.0)
MPA_PER_KELVIN = Param("per_kelvin", "MPa/K", "zero of the pressure sensor", -0.05, 0.05, scale=0.001)
ZEROS = tuple(Param(f"knot_{k}", "MPa", "zero of the pressure sensor", -0.3, 0.3, scale=0.002) for k in range(4))


def _reading(inputs: Inputs, values: Values, force: Array) -> Array:
    return hats(force, READINGS)[:, 1:-1]


def _warming(inputs: Inputs, values: Values, force: Array) -> Array:
    assert inputs.temperature is not None
    return since_first(inputs, inputs.temperature)[:, None]


def _clock(inputs: Inputs, values: Values, force: Array) -> Array:
    assert inputs.time is not None
    return hats(inputs.time, MOMENTS)[:, 1:].astype(inputs.contraction.dtype)


def _forms(span: Extent) -> Sequence[Form]:
    found: list[Form] = [AddsForce("reading", "curve over the force", knots(READINGS - 2), _reading, uses_force=True)]
    if span.inputs.time is not None:
        found.append(TransformsPressure("clock", "free curve of the pressure's zero", ZEROS, _clock))
    if span.inputs.temperature is not None and np.ptp(span.inputs.temperature) > 0.0:
        found.append(AddsForce("warm", "zero of the force", (PER_KELVIN,), _warming))
        found.append(TransformsPressure("warm_gauge", "zero of the pressure", (MPA_PER_KELVIN,), _warming))
    return found


PATTERN = PatternShape(
    "sensor",
    "error of a sensor",
    "other",
    "force",
    _forms,
    lambda at, along: f"what follows the {along} alone, whatever the muscle does, as {SENSORS[along]} may",
    {"clock": "time", "warm": "temperature", "warm_gauge": "temperature"},
)
