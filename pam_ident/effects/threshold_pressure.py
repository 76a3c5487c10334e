"""Pressure that is spent before the bladder touches the braid."""

from ..core import Inputs, Param
from .base import Array, Effect, Shape, TransformsPressure, one

P_TH = Param("p_th", "MPa", "threshold pressure", -0.3, 0.3, scale=0.01)
P_EPS = Param("p_e", "MPa", "growth of the threshold with contraction", -3.0, 3.0, scale=0.1)
WIDTH = Param("w", "MPa", "pressure over which the threshold is reached", 0.005, 0.15, start=0.08, grid=(0.03, 0.08))


def _hard(inputs: Inputs, shape: Shape, force: Array) -> Array:
    return one(-inputs.xp.ones(len(inputs)))


def _soft(inputs: Inputs, shape: Shape, force: Array) -> Array:
    return one(inputs.xp.expm1(-inputs.xp.maximum(inputs.pressure, 0.0) / shape["w"]))


def _stretching(inputs: Inputs, shape: Shape, force: Array) -> Array:
    """The wider the braid, the more the bladder must be stretched to touch it."""
    return -inputs.xp.stack([inputs.xp.ones(len(inputs)), inputs.contraction]).T


EFFECT = Effect(
    name="threshold_pressure",
    title="Threshold pressure",
    source="Chou & Hannaford 1996, IEEE Trans. Robotics and Automation 12(1), 90–102",
    forms=(
        TransformsPressure("textbook", "p → max(p − p_th, 0)", (P_TH,), _hard),
        TransformsPressure("stretching", "p → max(p − p_th − p_e ε, 0)", (P_TH, P_EPS), _stretching),
        TransformsPressure("soft", "p → p − p_th (1 − exp(−p/w))", (P_TH,), _soft, (WIDTH,)),
    ),
    test="low pressures in small steps, and the pressure gauge against a second one",
    levers=("pressure",),
)
