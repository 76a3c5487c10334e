"""The first, lonely stroke after a rest carries more force than all later ones."""

from ..core import Inputs, Param
from ._history import in_first_stroke
from .base import AddsForce, Array, Effect, Values, one

F_1 = Param("F_1", "N", "force that the first stroke has more", -2000.0, 2000.0, scale=10.0)
G_1 = Param("G_1", "N", "growth of that force with contraction", -1e5, 1e5, scale=100.0)
P_1 = Param("P_1", "N/MPa", "growth of that force with pressure", -2e4, 2e4, scale=30.0)


def _first(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(in_first_stroke(inputs))


def _shaped(inputs: Inputs, values: Values, force: Array) -> Array:
    first = in_first_stroke(inputs)
    return inputs.xp.stack([first, first * inputs.contraction]).T


def _rested(inputs: Inputs, values: Values, force: Array) -> Array:
    """The rubber rests while the pressure is changed."""
    first = in_first_stroke(inputs, rested=True)
    return inputs.xp.stack([first, first * inputs.pressure]).T


EFFECT = Effect(
    name="first_cycle",
    title="loss of the first stroke",
    source="Diani, Fayolle & Gilormini 2009, European Polymer Journal 45, 601–612 (most of what rubber loses it loses "
    "when it is first stretched)",
    forms=(
        AddsForce("textbook", "+F_1 in the record's first stroke", (F_1,), _first, remembers=True),
        AddsForce("shaped", "+(F_1 + G_1 ε) in the record's first stroke", (F_1, G_1), _shaped, remembers=True),
        AddsForce("rested", "+(F_1 + P_1 p) in the first stroke of each segment", (F_1, P_1), _rested, remembers=True),
    ),
    follows=("cycle",),
    test="the first stroke again after a rest, and after none",
    needs=("branch", "motion", "time"),
    levers=("cycles",),
    candidate=False,
)
