"""Friction that falls from its breakaway value as sliding begins."""

import numpy as np

from ..core import Inputs, Param
from .base import AddsForce, Array, Effect, Shape, slip, speed

SIZES = (
    Param("F_c", "N", "friction force at high speed", 0.0, 2000.0, scale=10.0),
    Param("F_s_minus_F_c", "N", "what friction gains towards rest", 0.0, 2000.0, scale=10.0),
    Param("F_hold", "N", "friction force left in holds", -2000.0, 2000.0, scale=10.0),
)
V_S = Param("v_s", "mm/s", "Stribeck speed", 0.2, 100.0, start=5.0, grid=(1.5, 5.0, 15.0))


def _columns(inputs: Inputs, shape: Shape, force: Array, dip: Array) -> Array:
    moving, held = slip(inputs)
    return -np.column_stack([moving, moving * dip, held])


def _gaussian(inputs: Inputs, shape: Shape, force: Array) -> Array:
    return _columns(inputs, shape, force, np.exp(-((speed(inputs) / shape["v_s"]) ** 2)))


def _exponential(inputs: Inputs, shape: Shape, force: Array) -> Array:
    return _columns(inputs, shape, force, np.exp(-speed(inputs) / shape["v_s"]))


EFFECT = Effect(
    name="stribeck_friction",
    title="Stribeck friction",
    source="Armstrong-Hélouvry, Dupont & Canudas de Wit 1994, Automatica 30(7), 1083–1138",
    forms=(
        AddsForce("textbook", "−[F_c + (F_s−F_c) exp(−(v/v_s)²)] sgn(ε̇)", SIZES, _gaussian, (V_S,)),
        AddsForce("exponential", "−[F_c + (F_s−F_c) exp(−v/v_s)] sgn(ε̇)", SIZES, _exponential, (V_S,)),
    ),
    test="at least four speeds over two decades: the gap narrows with speed",
    needs=("branch", "motion"),
    levers=("speed",),
    special_case_of="coulomb_friction",
)
