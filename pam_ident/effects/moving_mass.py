"""A mass that moves with the muscle's end, between muscle and load cell, must be accelerated."""

from ..core import Inputs, Param
from ._history import acceleration
from .base import AddsForce, Array, Effect, Values, one

MASS = Param("m", "kg", "mass that moves with the end", 0.0, 1000.0, scale=0.5)


def _inertia(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(-1e-3 * acceleration(inputs))


EFFECT = Effect(
    name="moving_mass",
    title="inertia of the moving mass",
    source="Newton's second law; Rayleigh 1894, The Theory of Sound, vol. 1 (of a spring's own mass a third moves with "
    "its end)",
    forms=(AddsForce("textbook", "−m ẍ, x the shortening", (MASS,), _inertia, remembers=True),),
    follows=("acceleration",),
    test="strokes that speed up and brake within them, at two speeds: the force grows with the square of the speed",
    needs=("motion", "time"),
    levers=("speed",),
    candidate=False,
)
