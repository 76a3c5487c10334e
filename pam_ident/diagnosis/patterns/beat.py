"""A beat in time, of the force or of the pressure."""

from collections.abc import Sequence

import numpy as np

from ...core import Inputs, Param
from ...core.digits import number
from ...effects import AddsForce, Form, TransformsPressure
from ...effects.base import Array, Values
from .base import WAVE, Extent, PatternShape, searched, wave

PRESSURE_WAVE = (
    Param("cosine", "MPa", "cosine part", -0.5, 0.5, scale=0.01),
    Param("sine", "MPa", "sine part", -0.5, 0.5, scale=0.01),
)


def _beat(inputs: Inputs, values: Values, force: Array) -> Array:
    assert inputs.time is not None
    return wave((inputs.time - inputs.time[0]).astype(inputs.contraction.dtype), values["period"])


def _forms(span: Extent) -> Sequence[Form]:
    slow = searched("period", "s", "period in time", span.duration / np.arange(3.0, 400.0, 0.4))
    found: list[Form] = [AddsForce("even", "beat", WAVE, _beat, (slow,))]
    if span.beats:
        seen = searched("period", "s", "period in time", sorted(span.beats, reverse=True))
        found += [
            AddsForce("seen", "beat", WAVE, _beat, (seen,)),
            TransformsPressure("pressure", "beat of the pressure", PRESSURE_WAVE, _beat, (seen,)),
        ]
    return found


PATTERN = PatternShape(
    "beat",
    "beat in time",
    "periodic",
    "time",
    _forms,
    lambda at, along: f"a beat with a period of {number(at['period'], 3)} s",
)
