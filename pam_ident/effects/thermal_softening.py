"""The rubber softens as it warms."""

from ..core import Inputs, Param
from ._history import relax, since_first
from .base import AddsForce, Array, Effect, ScalesForce, TransformsPressure, Values, free_form, one
from .bladder_elasticity import hoop_force

# Never below zero: a load cell whose gain wanders passed for rubber that stiffens as it warms.
ALPHA = Param("alpha", "1/K", "loss of force per kelvin of warming since the start", 0.0, 0.1, scale=0.001)
ALPHA_2 = Param("alpha_2", "1/K^2", "change of that loss with warming", -0.01, 0.01, scale=3e-5)
ALPHA_E = Param("alpha_e", "1/K", "change of that loss with contraction", -1.0, 1.0, scale=0.003)
E_LOSS = Param("E_loss", "MPa/K", "loss of the bladder's modulus per kelvin", 0.0, 20.0, scale=0.01)
G_LOSS = Param("G_loss", "N/K", "loss of elastic force per contraction and kelvin", 0.0, 1e4, scale=1.0)

COLD = Param(
    "T_c", "K", "first temperature above that at which the law holds", -10.0, 10.0, start=0.0, grid=(-2.0, 2.0, 6.0)
)
TAU = Param("tau", "s", "time in which the wall follows the sensor", 2.0, 600.0, start=60.0, grid=(20.0, 100.0, 400.0))


def warming(inputs: Inputs) -> Array:
    """Temperature above that of the first sample in K, shape (n,)."""
    assert inputs.temperature is not None
    return since_first(inputs, inputs.temperature)


def _whole(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(-warming(inputs))


def _from_cold(inputs: Inputs, values: Values, force: Array) -> Array:
    """A law without free parameters holds at some temperature, which need not be that of the first sample."""
    return one(-(warming(inputs) + values["T_c"]))


def _lagging(inputs: Inputs, values: Values, force: Array) -> Array:
    warmer = warming(inputs)
    if inputs.time is None:  # a table is taken at rest
        return one(-warmer)
    return one(relax(inputs, warmer, values["tau"]) - warmer)


def _pressure(inputs: Inputs, values: Values, force: Array) -> Array:
    loss = -inputs.pressure * warming(inputs)
    return inputs.xp.stack([loss, loss * inputs.contraction]).T


def _quadratic(inputs: Inputs, values: Values, force: Array) -> Array:
    return -inputs.xp.stack([warming(inputs), warming(inputs) ** 2]).T


def _elastic(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(-hoop_force(inputs) * warming(inputs))


def _linear(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(inputs.contraction * warming(inputs))


EFFECT = Effect(
    name="thermal_softening",
    title="thermal softening",
    source="temperature dependence of rubber elasticity, first order in ΔT",
    forms=(
        ScalesForce("textbook", "F (1 − α ΔT)", (ALPHA,), _whole),
        ScalesForce("quadratic", "F (1 − α ΔT − α_2 ΔT²)", (ALPHA, ALPHA_2), _quadratic),
        ScalesForce("from_cold", "F (1 − α (ΔT + T_c))", (ALPHA,), _from_cold, (COLD,)),
        ScalesForce("lagging", "F (1 − α ΔT_w), τ dT_w/dt = T − T_w", (ALPHA,), _lagging, (TAU,), remembers=True),
        TransformsPressure("pressure", "p → p (1 − (α + α_e ε) ΔT)", (ALPHA, ALPHA_E), _pressure),
        AddsForce("elastic", "E → E − E_loss ΔT in the bladder's force", (E_LOSS,), _elastic),
        AddsForce("linear", "+G_loss ΔT ε", (G_LOSS,), _linear),
        free_form("−ΔT/10 K", lambda inputs, values, force: one(-0.1 * warming(inputs))),
    ),
    follows=("temperature",),
    test="temperature logged and varied while the protocol is repeated",
    needs=("temperature",),
    levers=("temperature",),
)
