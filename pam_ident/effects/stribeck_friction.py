"""Friction that falls from its breakaway value as sliding begins."""

from ..core import Inputs, Param
from ._history import first_bend, lugre_operator, time_held
from .base import AddsForce, Array, Effect, Values, free_form, keeping_no_more, one, slip, speed
from .coulomb_friction import F_BREAK, F_C, F_HOLD, HOLD_GAIN, TAU_H, V_S, exponential_dip, gaussian_dip

SIZES = (F_C, F_BREAK, F_HOLD, HOLD_GAIN)
PEAK = Param("peak", "1", "friction towards rest over that at speed", 1.0, 20.0, start=1.5, grid=(1.4, 3.0))
WIDTH = Param("x_s", "mm", "travel in which the contact bends before it slides", 0.02, 1.2, start=0.5, grid=(0.3, 0.9))
"""A longer one is presliding, which has the same form under a name of its own."""


def _relaxing(inputs: Inputs, values: Values, force: Array) -> Array:
    """What a hold keeps fades."""
    columns = gaussian_dip(inputs, values, force)
    if inputs.time is None:
        return columns
    fading = inputs.xp.exp(-time_held(inputs, slip(inputs)[1] != 0.0) / values["tau_h"])
    return inputs.xp.hstack([columns[:, :2], columns[:, 2:] * fading[:, None]])


def bending(inputs: Inputs, values: Values, force: Array) -> Array:
    """Friction per N at speed of a contact that bends before it slides, shape (n, 1)."""
    level = 1.0 + (values["peak"] - 1.0) * inputs.xp.exp(-((speed(inputs) / values["v_s"]) ** 2))
    return one(-lugre_operator(inputs, values["x_s"], level, first_bend(values)))


EFFECT = Effect(
    name="stribeck_friction",
    title="Stribeck friction",
    source="Armstrong-Hélouvry, Dupont & Canudas de Wit 1994, Automatica 30(7), 1083–1138; "
    "Canudas de Wit, Olsson, Åström & Lischinsky 1995, IEEE Trans. Automatic Control 40(3), 419–425 (LuGre)",
    forms=(
        AddsForce("textbook", "−[F_c + (F_s−F_c) exp(−(v/v_s)²)] sgn(ε̇)", SIZES, gaussian_dip, (V_S,)),
        AddsForce("exponential", "−[F_c + (F_s−F_c) exp(−v/v_s)] sgn(ε̇)", SIZES, exponential_dip, (V_S,)),
        AddsForce(
            "relaxing", "the textbook's, in holds times exp(−t/τ_h)", SIZES, _relaxing, (V_S, TAU_H), remembers=True
        ),
        AddsForce(
            "bending",
            "−F_c z, dz/dx = (1 − z sgn ẋ/g)/x_s, g = 1 + (peak−1) exp(−(v/v_s)²)",
            (F_C,),
            bending,
            (PEAK, V_S, WIDTH),
            remembers=True,
        ),
        free_form(
            "−sgn(ε̇), −exp(−v/v_s) sgn(ε̇), and both in motion alone",
            keeping_no_more(exponential_dip),
            4,
            contraction=1,
            nonlinear=(V_S,),
            resisting=4,
        ),
    ),
    follows=("speed", "direction"),
    test="at least four speeds over two decades: the gap narrows with speed",
    needs=("branch", "motion"),
    levers=("speed",),
    special_case_of="coulomb_friction",
    own=F_BREAK.name,
)
