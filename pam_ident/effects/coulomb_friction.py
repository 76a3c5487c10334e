"""Dry friction between braid, bladder and threads."""

from collections.abc import Callable

from ..core import Inputs, Param
from ._history import dahl_operator, time_held
from .base import AddsForce, Array, Effect, Values, bladder_area, free_form, keeping_no_more, one, slip, speed

F_C = Param("F_c", "N", "friction force in motion", 0.0, 2000.0, start=0.0, scale=10.0)
F_IN = Param("F_in", "N", "friction force while the muscle contracts", 0.0, 2000.0, scale=10.0)
F_OUT = Param("F_out", "N", "friction force while it extends", 0.0, 2000.0, scale=10.0)
F_HOLD = Param("F_hold", "N", "friction force left in holds", -2000.0, 2000.0, scale=10.0)
F_BREAK = Param("F_s_minus_F_c", "N", "what friction gains towards rest", 0.0, 2000.0, scale=10.0)
HOLD_GAIN = Param("F_hold_gain", "N", "what that gains after slow strokes", -2000.0, 2000.0, scale=10.0)
V_S = Param("v_s", "mm/s", "Stribeck speed", 0.2, 100.0, start=5.0, grid=(1.5, 5.0, 15.0))
V_0 = Param("v_0", "mm/s", "speed at which friction is fully developed", 0.05, 4.0, start=1.0, grid=(0.5, 2.0))
GROWTH = Param("growth", "1", "exponent of the contact area", -6.0, 6.0, start=1.0, grid=(1.5, -1.5))
TAU_H = Param("tau_h", "s", "time in which friction fades in a hold", 0.05, 1000.0, start=2.0, grid=(0.7, 3.0))

CONTACT = Param(
    "x_s", "mm", "travel in which the contact bends before it slides", 0.02, 0.5, start=0.1, grid=(0.05, 0.2)
)
"""With the load cell and the fixture behind it; a longer one shows in minor loops, and is presliding."""


def _sliding(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(-slip(inputs)[0])


def _held(inputs: Inputs, values: Values, force: Array) -> Array:
    return -inputs.xp.stack(slip(inputs)).T


def _asymmetric(inputs: Inputs, values: Values, force: Array) -> Array:
    moving, held = slip(inputs)
    xp = inputs.xp
    return -xp.stack([xp.maximum(moving, 0.0), xp.minimum(moving, 0.0), held]).T


def stuck(inputs: Inputs, values: Values, force: Array) -> Array:
    """Per newton, (n, 1): friction holds all of its force at rest, and lets go over a short way after a reversal; in a
    state without a way it slides."""
    if inputs.time is None:
        return _sliding(inputs, values, force)
    return one(-dahl_operator(inputs, values["x_s"]))


def _area(inputs: Inputs, values: Values, force: Array) -> Array:
    """The bladder's area over its area at rest, to a power."""
    return _held(inputs, values, force) * bladder_area(inputs)[:, None] ** values["growth"]


def _smooth(inputs: Inputs, values: Values, force: Array) -> Array:
    xp = inputs.xp
    moving, held = slip(inputs)
    ramp = xp.tanh(speed(inputs) / values["v_0"]) if inputs.velocity is not None else 1.0
    return -xp.stack([moving * ramp, held]).T


def _relaxing(inputs: Inputs, values: Values, force: Array) -> Array:
    """What friction holds at rest fades, because the rubber under the threads creeps."""
    if inputs.time is None:
        return _held(inputs, values, force)
    moving, held = slip(inputs)
    fading = inputs.xp.exp(-time_held(inputs, held != 0.0) / values["tau_h"])
    return -inputs.xp.stack([moving, held * fading]).T


def stribeck_columns(inputs: Inputs, dip: Callable[[Array], Array]) -> Array:
    """Sliding, its gain towards rest, and both as a hold keeps them from the stroke before it, shape (n, 4).

    `dip` takes a speed in mm/s to a share of the gain. A table without speeds has no gain.
    """
    moving, held = slip(inputs)
    if inputs.velocity is None or inputs.stroke_speed is None:
        return -inputs.xp.stack([moving, 0.0 * moving, held, 0.0 * held]).T
    return -inputs.xp.stack([moving, moving * dip(speed(inputs)), held, held * dip(inputs.stroke_speed)]).T


def gaussian_dip(inputs: Inputs, values: Values, force: Array) -> Array:
    """Columns of the Stribeck form exp(−(v/v_s)²), shape (n, 4)."""
    return stribeck_columns(inputs, lambda v: inputs.xp.exp(-((v / values["v_s"]) ** 2)))


def exponential_dip(inputs: Inputs, values: Values, force: Array) -> Array:
    """Columns of the Stribeck form exp(−v/v_s), shape (n, 4)."""
    return stribeck_columns(inputs, lambda v: inputs.xp.exp(-v / values["v_s"]))


EFFECT = Effect(
    name="coulomb_friction",
    title="Coulomb friction",
    source="Tondu & Lopez 2000, IEEE Control Systems 20(2), 15–38; Armstrong-Hélouvry 1991 for the Stribeck form",
    forms=(
        AddsForce("textbook", "−F_c sgn(ε̇)", (F_C,), _sliding),
        AddsForce("held", "−F_c sgn(ε̇), F_hold in holds", (F_C, F_HOLD), _held),
        AddsForce("contact_area", "−F_c S(ε)^g sgn(ε̇), S the bladder's area", (F_C, F_HOLD), _area, (GROWTH,)),
        AddsForce(
            "asymmetric",
            "−F_in in contraction, +F_out in extension, F_hold in holds",
            (F_IN, F_OUT, F_HOLD),
            _asymmetric,
        ),
        AddsForce("stuck", "dz/dx = (1 − z sgn ẋ)/x_s, −F_c z", (F_C,), stuck, (CONTACT,), remembers=True),
        AddsForce(
            "relaxing", "−F_c sgn(ε̇), F_hold exp(−t/τ_h) in holds", (F_C, F_HOLD), _relaxing, (TAU_H,), remembers=True
        ),
        AddsForce("smooth", "−F_c tanh(v/v_0), F_hold in holds", (F_C, F_HOLD), _smooth, (V_0,)),
        AddsForce(
            "stribeck",
            "−[F_c + (F_s−F_c) exp(−(v/v_s)²)] sgn(ε̇), F_hold in holds",
            (F_C, F_BREAK, F_HOLD, HOLD_GAIN),
            gaussian_dip,
            (V_S,),
            same_as="stribeck_friction",
        ),
        AddsForce(
            "stribeck_exponential",
            "−[F_c + (F_s−F_c) exp(−v/v_s)] sgn(ε̇), F_hold in holds",
            (F_C, F_BREAK, F_HOLD, HOLD_GAIN),
            exponential_dip,
            (V_S,),
            same_as="stribeck_friction",
        ),
        free_form(
            "−sgn(ε̇), in holds times exp(−t/τ_h), and −sgn(ε̇) in motion alone",
            keeping_no_more(_relaxing),
            2,
            pressure=0,
            nonlinear=(TAU_H,),
            remembers=True,
            resisting=2,
        ),
    ),
    follows=("direction",),
    test="slow reversals at several pressures: the gap between the branches keeps its width",
    needs=("branch",),
    levers=("speed", "pressure"),
)
