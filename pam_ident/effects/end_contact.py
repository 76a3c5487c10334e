"""Near an end of the stroke something touches, or buckles: a stop, the end fittings, threads that are straight."""

from ..core import Inputs, Param
from .base import AddsForce, Array, Effect, Values, one

K = Param("K", "N/mm", "stiffness of the contact", 0.0, 1e5, scale=10.0)
K_H = Param("K_h", "N/mm", "stiffness of the contact at 1 mm", 0.0, 1e5, scale=10.0)
SHORT = Param(
    "e_c", "1", "contraction beyond which it touches", 0.0, 0.4, start=0.125, grid=(0.05, 0.1, 0.15, 0.2, 0.25)
)
LONG = Param("e_c", "1", "contraction below which it touches", -0.1, 0.3, start=0.055, grid=(0.01, 0.03, 0.07, 0.12))


def _beyond(inputs: Inputs, values: Values) -> Array:
    """Way in mm past the place where it touches, shape (n,)."""
    past = inputs.contraction - values["e_c"]
    return inputs.xp.maximum(past, 0.0) * inputs.specimen.initial_length_mm


def _short(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(-_beyond(inputs, values))


def _rounded(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(-(_beyond(inputs, values) ** 1.5))


def _long(inputs: Inputs, values: Values, force: Array) -> Array:
    past = inputs.xp.maximum(values["e_c"] - inputs.contraction, 0.0)
    return one(past * inputs.specimen.initial_length_mm)


EFFECT = Effect(
    name="end_contact",
    title="contact or buckling near an end of the stroke",
    source="Johnson 1985, Contact Mechanics, Cambridge University Press (the power 3/2 of round bodies: Hertz 1882)",
    forms=(
        AddsForce("textbook", "−K L0 max(ε − ε_c, 0)", (K,), _short, (SHORT,)),
        AddsForce("hertz", "−K_h [L0 max(ε − ε_c, 0)]^(3/2)", (K_H,), _rounded, (SHORT,)),
        AddsForce("long", "+K L0 max(ε_c − ε, 0)", (K,), _long, (LONG,)),
    ),
    follows=("map",),
    test="a slow stroke at low pressure to each end: the force has a corner at one length, whatever the pressure",
    levers=("pressure", "reversal"),
    candidate=False,
)
