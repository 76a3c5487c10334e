"""The bladder's rubber after Ogden: powers of its stretches, which follow measured rubber to large stretch."""

import math

from ..core import Inputs, Param
from .base import AddsForce, Array, Effect, Values
from .bladder_elasticity import SHEAR, wall

MU = Param("mu", "MPa", "modulus; the shear modulus is mu alpha/2", 0.0, 200.0, scale=0.3, range=SHEAR)
ALPHA = Param("alpha", "1", "exponent of the stretches", 0.5, 12.0, start=3.0, grid=(1.3, 5.0, 9.0))
MODULI = (
    Param("mu_1", "MPa", "modulus of the exponent 1.3", 0.0, 200.0, scale=0.6),
    Param("mu_2", "MPa", "modulus of the exponent 5", 0.0, 200.0, scale=0.01),
    Param("mu_3", "MPa", "modulus of the exponent −2", -200.0, 0.0, scale=0.05),
)
TRELOAR = (1.3, 5.0, -2.0)
"""Exponents by which Ogden fits Treloar's rubber in tension, shear and biaxial tension at once."""


def _pull(inputs: Inputs, alpha: float) -> Array:
    """Force in N per MPa of one term (μ/α)(λ_z^α + λ_θ^α + λ_t^α − 3), by virtual work on 2π r0 t L0, shape (n,)."""
    z, hoop = 1.0 - inputs.contraction, inputs.specimen.radius_ratio(inputs.contraction)
    widening = inputs.specimen.a * z / (3.0 * hoop**2)  # d ln λ_θ/dε, of λ_θ² = b − a z²/3
    thin = (z * hoop) ** -alpha
    slope = -(z ** (alpha - 1.0)) + (hoop**alpha - thin) * widening + thin / z
    return -2.0 * math.pi * inputs.specimen.initial_radius_mm * wall(inputs) * slope


def _term(inputs: Inputs, values: Values, force: Array) -> Array:
    return _pull(inputs, values["alpha"])[:, None]


def _treloar(inputs: Inputs, values: Values, force: Array) -> Array:
    return inputs.xp.stack([_pull(inputs, alpha) for alpha in TRELOAR]).T


EFFECT = Effect(
    name="ogden_bladder",
    title="bladder of Ogden's rubber",
    source="Ogden 1972, Proceedings of the Royal Society A 326, 565–584",
    forms=(
        AddsForce("textbook", "−2π r0 t dW/dε, W = (μ/α)(λ_z^α + λ_θ^α + λ_t^α − 3)", (MU,), _term, (ALPHA,)),
        AddsForce("treloar", "the same, a sum of three terms with α = 1.3, 5, −2", MODULI, _treloar),
    ),
    follows=("map",),
    test="a sweep at low pressure over the whole stroke: the force that is left is the bladder's",
    levers=("pressure",),
    special_case_of="bladder_elasticity",
    candidate=False,
)
