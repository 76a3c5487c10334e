"""The length called initial is not the length of no contraction."""

from ..core import Inputs, Param, Range
from .base import Array, Effect, TransformsContraction, Values, one

ENDS = Range(-0.06, 0.06, "definitions of the initial length, which differ by 5 % (Martens & Boblan 2017)")
OFFSET = Param("e_off", "1", "contraction read where there is none", -0.2, 0.2, scale=0.01, range=ENDS)


def _constant(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(-inputs.xp.ones(len(inputs)))


def _of_the_rest_length(inputs: Inputs, values: Values, force: Array) -> Array:
    """A rest length that is off by a share e_off/(1 + e_off) changes what the contraction is divided by, too."""
    return one(inputs.contraction - 1.0)


EFFECT = Effect(
    name="length_offset",
    title="offset of the initial length",
    source="ε → ε − ε_off; see Martens & Boblan 2017, Actuators 6(4), 33 on the definition of the initial length",
    forms=(
        TransformsContraction("textbook", "ε → ε − e_off", (OFFSET,), _constant),
        TransformsContraction("rest_length", "ε → ε − e_off (1 − ε)", (OFFSET,), _of_the_rest_length),
    ),
    follows=("map",),
    test="a gauge block in place of the muscle's length",
    levers=("pressure",),
)
