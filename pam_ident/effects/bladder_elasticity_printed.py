"""The bladder's force in the form printed in the paper, kept for comparison only."""

import math

from ..core import Inputs, Param
from .base import AddsForce, Array, Effect, Values, one
from .bladder_elasticity import wall

E_MOD = Param("E_printed", "MPa·mm⁻¹", "modulus by the printed form: not a Young's modulus", 0.0, 5000.0, scale=0.01)


def _printed(inputs: Inputs, values: Values, force: Array) -> Array:
    s, shortened = inputs.specimen, 1.0 - inputs.contraction
    stretch = 1.0 - 1.0 / s.radius_ratio(inputs.contraction)
    factor = 2.0 * math.sqrt(3.0 * s.a) / 3.0 * math.pi * s.initial_radius_mm * s.initial_length_mm * wall(inputs)
    return one(-factor * shortened**2 * stretch)


EFFECT = Effect(
    name="bladder_elasticity_printed",
    title="elasticity of the bladder, as printed",
    source="equation (2) of the heterogeneous-leg paper, as printed",
    forms=(AddsForce("textbook", "−(2√(3a)/3) π r0 L0 t E (1−ε)² (1 − r0/r)", (E_MOD,), _printed),),
    follows=("map",),
    test="use bladder_elasticity",
    levers=("pressure",),
    candidate=False,
    warning=(
        "the printed form has units N·m, not N: with lengths in m a modulus fitted with it comes out 11 to 13 times "
        "Young's; use bladder_elasticity"
    ),
)
