"""The load cell reads a force where there is none."""

from ..core import Inputs, Param, Range
from .base import AddsForce, Array, Effect, Values, one

ZERO = Range(-100.0, 100.0, "zero balance of a load cell, 5 % of 2 kN, or of the largest force", 2000.0)
BIAS = Param("F_b", "N", "force read at no load", -2000.0, 2000.0, scale=10.0, range=ZERO)


def _columns(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(inputs.xp.ones(len(inputs)))


EFFECT = Effect(
    name="force_bias",
    title="bias of the load cell",
    source="tare error of a load cell, F_b constant",
    forms=(AddsForce("textbook", "+F_b", (BIAS,), _columns),),
    follows=("map",),
    test="tare before and after",
    levers=("pressure",),
)
