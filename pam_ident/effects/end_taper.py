"""The ends stay narrow, so that the cylinder contracts more than the muscle."""

from dataclasses import replace

from ..core import Inputs, Param, Range
from .base import Array, Effect, TransformsContraction, Values, free_form, one

CYLINDER = Range(0.8, 3.0, "ends of one or two diameters at rest on muscles of six (Tondu & Lopez 2000)")
K1 = Param("k1", "1", "effective contraction per contraction", 0.2, 20.0, start=1.0, neutral=1.0, range=CYLINDER)
FORMED = replace(K1, range=None)
FADES = Param("w", "MPa", "pressure over which the taper fades", 0.02, 0.5, start=0.1, grid=(0.05, 0.15))
SPAN = Param("e_s", "1", "contraction at which the taper is fully formed", 0.02, 1.0, start=0.1, grid=(0.03, 0.1))


def _linear(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(inputs.contraction)


def _saturating(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(values["e_s"] * -inputs.xp.expm1(-inputs.contraction / values["e_s"]))


def _fading(inputs: Inputs, values: Values, force: Array) -> Array:
    """Pressure blows the ends up: what tapers at every pressure, and what does at low ones alone."""
    low = inputs.xp.exp(-inputs.xp.maximum(inputs.pressure, 0.0) / values["w"])
    return inputs.xp.stack([inputs.contraction, low * inputs.contraction]).T


EFFECT = Effect(
    name="end_taper",
    title="tapered ends",
    source="Tondu & Lopez 2000, IEEE Control Systems 20(2), 15–38",
    # None written that begins late or is cubic: on few lengths they take the bladder's place.
    forms=(
        TransformsContraction("textbook", "ε → k1 ε", (K1,), _linear),
        TransformsContraction("saturating", "ε → ε + (k1−1) e_s (1 − exp(−ε/e_s))", (FORMED,), _saturating, (SPAN,)),
        free_form(
            "ε → ε + (1, exp(−p/w)) ε",
            _fading,
            count=2,
            pressure=0,
            contraction=4,
            nonlinear=(FADES,),
            role=TransformsContraction,
            unit=("1", 0.1),
            upper=CYLINDER.high - 1.0,
            resisting=2,
        ),
    ),
    follows=("map",),
    test="measure the shape or the length of the cylindrical part apart",
    levers=("pressure",),
)
