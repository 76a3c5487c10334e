"""Hysteresis that remembers every reversal that a larger one has not wiped out, and differs between the branches."""

from dataclasses import replace

from ..core import Inputs, Param
from ._history import stop_operator
from .base import AddsForce, Array, Effect, Values
from .presliding_hysteresis import slipping

SHARES = (0.25, 0.5, 1.0)
"""Widths of the operators over the widest."""
SIZES = tuple(
    Param(f"W_{k}", "N", f"force of the {word} operator", 0.0, 2000.0, scale=10.0)
    for k, word in enumerate(("narrowest", "middle", "widest"), 1)
)
GROWTHS = tuple(replace(p, name=f"G_{p.name[2:]}", doc=f"growth of {p.name} with ε", lower=-1e5, upper=1e5, scale=50.0)
                for p in SIZES)  # fmt: skip
CURVES = (
    Param("V", "N", "force of all operators alike", 0.0, 2000.0, scale=20.0),
    Param("V_c", "N", "what is added near full contraction force", -2000.0, 2000.0, scale=10.0),
    Param("V_e", "N", "what is added near full extension force", -2000.0, 2000.0, scale=10.0),
)
WIDTH = Param("r", "mm", "travel in which the widest operator yields", 0.2, 80.0, start=8.0, grid=(2.0, 6.0, 15.0))
RATIO = Param("w", "1", "force on the extension branch over that on the contraction branch", 0.1, 10.0, start=1.0,
              grid=(0.5, 2.0))  # fmt: skip
DEAD = 0.5
"""Zone of the curve, as a share of the largest state, that its outer parts leave out."""


def _operators(inputs: Inputs, values: Values, ratio: float = 1.0) -> list[Array]:
    """States of the operators, (n,) each, from −ratio (extension) to 1 (contraction)."""
    widest = slipping(inputs, values["r"] * 0.5 * (1.0 + ratio)) / (0.5 * (1.0 + ratio))
    return [stop_operator(inputs, share * widest, least=-ratio) for share in SHARES]


def _asymmetric(inputs: Inputs, values: Values, force: Array) -> Array:
    return -inputs.xp.stack(_operators(inputs, values, values["w"])).T


def _growing(inputs: Inputs, values: Values, force: Array) -> Array:
    columns = _asymmetric(inputs, values, force)
    return inputs.xp.hstack([columns, columns * inputs.contraction[:, None]])


def _curved(inputs: Inputs, values: Values, force: Array) -> Array:
    xp = inputs.xp
    state = sum(_operators(inputs, values)) / len(SHARES)
    return -xp.stack([state, xp.maximum(state - DEAD, 0.0), xp.minimum(state + DEAD, 0.0)]).T


EFFECT = Effect(
    name="nonlocal_hysteresis",
    title="Hysteresis with nonlocal memory",
    source="Kuhnen 2003, European Journal of Control 9, 407–418 (modified Prandtl–Ishlinskii); Liu, Zang, Lin, Liu & "
    "Zhao 2017, Strojniški vestnik 63(1), 56–64 (operators of their own for each branch of a muscle); Capace, "
    "Cosentino, Amato & Merola 2019, Actuators 8(2), 49",
    forms=(
        AddsForce(
            "textbook",
            "−Σ W_i z_i, z_i = clip(z_i + Δx/r_i, −w, 1), r_i = r/4, r/2, r",
            SIZES,
            _asymmetric,
            (WIDTH, RATIO),
            remembers=True,
        ),
        AddsForce(
            "growing", "as textbook, W_i + G_i ε for W_i", SIZES + GROWTHS, _growing, (WIDTH, RATIO), remembers=True
        ),
        AddsForce(
            "curved",
            "−[V z + V_c max(z−½, 0) + V_e min(z+½, 0)], z the mean of the z_i at w = 1",
            CURVES,
            _curved,
            (WIDTH,),
            remembers=True,
        ),
    ),
    follows=("way", "direction"),
    test="minor loops of several sizes inside a large one, at one slow speed",
    needs=("branch", "motion"),
    levers=("reversal",),
    special_case_of="presliding_hysteresis",
    candidate=False,
)
