"""Dry friction that grows with the contact pressure of the braid."""

from ..core import Inputs, Param
from .base import AddsForce, Array, Effect, Values, bladder_area, free_form, keeping_no_more, slip, with_pressure
from .coulomb_friction import CONTACT, stuck

MU = Param("mu_f", "N/MPa", "friction force per pressure", 0.0, 5000.0, scale=20.0)
F_0 = Param("F_0", "N", "friction force without pressure", 0.0, 2000.0, scale=10.0)
MU_HOLD = Param("mu_hold", "N/MPa", "friction force per pressure left in holds", -5000.0, 5000.0, scale=20.0)
GROWTH = Param(
    "growth",
    "1",
    "exponent of the contact area over contraction",
    -6.0,
    6.0,
    start=1.0,
    grid=(1.0, -2.0, 3.0),
)

P_0 = Param("p_0", "MPa", "pressure of the braid on the bladder by itself", 0.0, 1.0, start=0.2, grid=(0.1, 0.4))
POWER = Param("n", "1", "exponent of the pressure over 0.3 MPa", 0.3, 2.5, start=1.0, grid=(0.7, 1.4))


def _constant(inputs: Inputs, values: Values, force: Array) -> Array:
    return -slip(inputs)[0][:, None] * inputs.pressure[:, None]


def _held(inputs: Inputs, values: Values, force: Array) -> Array:
    return -inputs.xp.stack(slip(inputs)).T * inputs.pressure[:, None]


def _preloaded(inputs: Inputs, values: Values, force: Array) -> Array:
    return -inputs.xp.stack(slip(inputs)).T * (inputs.pressure + values["p_0"])[:, None]


def _area(inputs: Inputs, values: Values, force: Array) -> Array:
    """The bladder's area over its area at rest, to a power."""
    return _held(inputs, values, force) * bladder_area(inputs)[:, None] ** values["growth"]


def _bending(inputs: Inputs, values: Values, force: Array) -> Array:
    return with_pressure(stuck(inputs, values, force), inputs)


def _power(inputs: Inputs, values: Values, force: Array) -> Array:
    share = inputs.xp.maximum(inputs.pressure, 1e-6) / 0.3
    return -inputs.xp.stack(slip(inputs)).T * (0.3 * share ** values["n"])[:, None]


EFFECT = Effect(
    name="pressure_friction",
    title="friction that grows with pressure",
    source="Davis & Caldwell 2006, Int. J. Robotics Research 25(4), 359–369 (thread contact area under pressure)",
    forms=(
        AddsForce("textbook", "−μ_f p sgn(ε̇)", (MU,), _constant),
        AddsForce("held", "−μ_f p sgn(ε̇), μ_hold in holds", (MU, MU_HOLD), _held),
        AddsForce("preloaded", "−μ_f (p + p_0) sgn(ε̇), μ_hold in holds", (MU, MU_HOLD), _preloaded, (P_0,)),
        AddsForce(
            "bending", "dz/dx = (1 − z sgn ẋ)/x_s, −(F_0 + μ_f p) z", (F_0, MU), _bending, (CONTACT,), remembers=True
        ),
        AddsForce("power", "−μ_f 0.3 MPa (p/0.3 MPa)^n sgn(ε̇)", (MU, MU_HOLD), _power, (POWER,)),
        AddsForce("contact_area", "−μ_f p S(ε)^g sgn(ε̇), S the bladder's area", (MU, MU_HOLD), _area, (GROWTH,)),
        free_form(
            "−(p + p_0) sgn(ε̇), and in motion alone",
            keeping_no_more(_preloaded),
            2,
            pressure=0,
            contraction=2,
            nonlinear=(P_0,),
            resisting=2,
        ),
    ),
    follows=("direction",),
    test="pressures over 4:1: the gap between the branches grows with them",
    needs=("branch",),
    levers=("pressure",),
    own=MU.name,
)
