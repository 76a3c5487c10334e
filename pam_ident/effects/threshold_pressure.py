"""Pressure that is spent before the bladder touches the braid."""

from ..core import Inputs, Param, Range
from .base import Array, Effect, TransformsPressure, Values, free_form, one

SPENT = Range(-0.02, 0.15, "bladders in McKibben muscles, 0 to 0.1 MPa (Chou & Hannaford 1996), gauges to 2 % of 1 MPa")
P_TH = Param("p_th", "MPa", "threshold pressure", -0.3, 0.3, scale=0.01, range=SPENT)
GROWTH = Param(
    "g", "1", "growth of the threshold with contraction, per contraction", 0.0, 5.0, start=2.0, grid=(1.0, 3.0)
)
"""What were nothing without contraction, and then grew, is the bladder's own force."""
WIDTH = Param("w", "MPa", "pressure over which the threshold is reached", 0.005, 0.15, start=0.08, grid=(0.03, 0.08))


def _hard(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(-inputs.xp.ones(len(inputs)))


def _soft(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(inputs.xp.expm1(-inputs.xp.maximum(inputs.pressure, 0.0) / values["w"]))


def _stretching(inputs: Inputs, values: Values, force: Array) -> Array:
    """The wider the braid, the more the bladder must be stretched to touch it."""
    return one(-(1.0 + values["g"] * inputs.contraction))


EFFECT = Effect(
    name="threshold_pressure",
    title="threshold pressure",
    source="Chou & Hannaford 1996, IEEE Trans. Robotics and Automation 12(1), 90–102",
    forms=(
        TransformsPressure("textbook", "p → max(p − p_th, 0)", (P_TH,), _hard),
        TransformsPressure("stretching", "p → max(p − p_th (1 + g ε), 0)", (P_TH,), _stretching, (GROWTH,)),
        TransformsPressure("soft", "p → p − p_th (1 − exp(−p/w))", (P_TH,), _soft, (WIDTH,)),
        free_form(
            "p → p − (1 − exp(−p/w))",
            _soft,
            pressure=0,
            contraction=1,
            nonlinear=(WIDTH,),
            role=TransformsPressure,
            unit=("MPa", 0.01),
            lower=0.0,
        ),
    ),
    follows=("map",),
    test="low pressures in small steps, and the pressure gauge against a second one",
    levers=("pressure",),
)
