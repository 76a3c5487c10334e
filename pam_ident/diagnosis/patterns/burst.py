"""A force for a while."""

from collections.abc import Sequence

import numpy as np

from ...core import Inputs
from ...core.digits import number
from ...effects import AddsForce, Form
from ...effects.base import Array, Values
from .base import SIZE, Extent, PatternShape, bell, like, searched


def _burst(inputs: Inputs, values: Values, force: Array) -> Array:
    assert inputs.time is not None
    return bell(like(inputs, (inputs.time[:, None] - np.asarray(values["moment"])) / np.asarray(values["length"])))


def _forms(span: Extent) -> Sequence[Form]:
    length = searched("length", "s", "how long", [span.duration * w for w in (0.08, 0.03, 0.012)])
    return (AddsForce("bell", "bell over time", (SIZE,), _burst, (span.moment(), length)),)


PATTERN = PatternShape(
    "burst",
    "force for a while",
    "local",
    "time",
    _forms,
    lambda at, along: f"a force for a while around {number(at['moment'])} s",
)
