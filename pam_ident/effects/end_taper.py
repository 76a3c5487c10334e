"""The ends stay narrow, so that the cylinder contracts more than the muscle."""

from ..core import Inputs, Param
from .base import Array, Effect, Shape, TransformsContraction, one

K1 = Param("k1", "1", "effective contraction per contraction", 0.2, 20.0, start=1.0, neutral=1.0)
SPAN = Param("e_s", "1", "contraction at which the taper is fully formed", 0.02, 1.0, start=0.1, grid=(0.03, 0.1))


def _linear(inputs: Inputs, shape: Shape, force: Array) -> Array:
    return one(inputs.contraction)


def _saturating(inputs: Inputs, shape: Shape, force: Array) -> Array:
    return one(shape["e_s"] * -inputs.xp.expm1(-inputs.contraction / shape["e_s"]))


EFFECT = Effect(
    name="end_taper",
    title="Tapered ends",
    source="Tondu & Lopez 2000, IEEE Control Systems 20(2), 15–38",
    # None that begins late or is cubic: on few lengths they take the bladder's place, and rubs and ripples elsewhere.
    forms=(
        TransformsContraction("textbook", "ε → k1 ε", (K1,), _linear),
        TransformsContraction("saturating", "ε → ε + (k1−1) e_s (1 − exp(−ε/e_s))", (K1,), _saturating, (SPAN,)),
    ),
    follows=("map",),
    test="measure the shape or the length of the cylindrical part apart",
    levers=("pressure",),
)
