"""Fixture and load cell give way under load, so that the muscle is shorter than the sensor says."""

from ..core import Inputs, Param
from .base import Array, Effect, Shape, TransformsContraction, one

COMPLIANCE = Param("compliance", "mm/kN", "stretch of fixture and load cell per force, 1/K", 0.0, 100.0, scale=1.0)


def _columns(inputs: Inputs, shape: Shape, force: Array) -> Array:
    return one(force * 1e-3 / inputs.specimen.initial_length_mm)


EFFECT = Effect(
    name="series_compliance",
    title="Compliance in series",
    source="machine compliance in force–length tests, ε_muscle = ε_measured + F/(K L0)",
    forms=(TransformsContraction("textbook", "ε → ε + F/(K L0)", (COMPLIANCE,), _columns, uses_force=True),),
    test="a steel bar in place of the muscle",
    levers=("pressure",),
)
