"""Friction that falls from its breakaway value as sliding begins."""

from .base import AddsForce, Effect
from .coulomb_friction import F_BREAK, F_C, F_HOLD, HOLD_GAIN, V_S, exponential_dip, gaussian_dip

SIZES = (F_C, F_BREAK, F_HOLD, HOLD_GAIN)

EFFECT = Effect(
    name="stribeck_friction",
    title="Stribeck friction",
    source="Armstrong-Hélouvry, Dupont & Canudas de Wit 1994, Automatica 30(7), 1083–1138",
    forms=(
        AddsForce("textbook", "−[F_c + (F_s−F_c) exp(−(v/v_s)²)] sgn(ε̇)", SIZES, gaussian_dip, (V_S,)),
        AddsForce("exponential", "−[F_c + (F_s−F_c) exp(−v/v_s)] sgn(ε̇)", SIZES, exponential_dip, (V_S,)),
    ),
    test="at least four speeds over two decades: the gap narrows with speed",
    needs=("branch", "motion"),
    levers=("speed",),
    special_case_of="coulomb_friction",
)
