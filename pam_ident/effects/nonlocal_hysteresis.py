"""Hysteresis that remembers every reversal that a larger one has not wiped out, and differs between the branches."""

from dataclasses import replace

from ..core import Inputs, Param
from ._history import first_bend, stop_operator
from .base import AddsForce, Array, Effect, Values
from .presliding_hysteresis import BEGUN, slipping

SHARES = (0.25, 0.5, 1.0)
"""Widths of the operators over the widest."""
SIZES = tuple(
    Param(f"W_{k}", "N", f"force of the {word} operator", 0.0, 2000.0, scale=10.0)
    for k, word in enumerate(("narrowest", "middle", "widest"), 1)
)
GROWTHS = tuple(
    replace(p, name=f"G_{p.name[2:]}", doc=f"growth of {p.name} with ε", lower=-1e5, upper=1e5, scale=50.0)
    for p in SIZES
)
CURVES = (
    Param("V", "N", "force of all operators alike", 0.0, 2000.0, scale=20.0),
    Param("V_c", "N", "what is added near full contraction force", -2000.0, 2000.0, scale=10.0),
    Param("V_e", "N", "what is added near full extension force", -2000.0, 2000.0, scale=10.0),
)
WIDTH = Param("r", "mm", "travel in which the widest operator yields", 0.2, 80.0, start=8.0, grid=(2.0, 6.0, 15.0))
GROWTH = Param("q", "1", "growth of the extension branch's force with ε", -2.0, 60.0, start=3.0, grid=(-1.0, 3.0, 12.0))
DEAD = 0.5
"""Zone of the curve, as a share of the largest state, that its outer parts leave out."""


def _operators(inputs: Inputs, values: Values, growth: float = 0.0) -> Array:
    """States of the operators, shape (n, 3), from −(1 + growth · ε) on the extension branch to 1 on the other."""
    least = -inputs.xp.maximum(1.0 + growth * inputs.contraction, 0.05)
    widest = slipping(inputs, values["r"])
    return inputs.xp.stack(
        [stop_operator(inputs, share * widest, least=least, begun=first_bend(values)) for share in SHARES]
    ).T


def _generalised(inputs: Inputs, values: Values, force: Array) -> Array:
    """An asymmetry that is the same everywhere would be a constant force, which laws take up: it must grow."""
    return -_operators(inputs, values, values["q"])


def _growing(inputs: Inputs, values: Values, force: Array) -> Array:
    columns = -_operators(inputs, values)
    return inputs.xp.hstack([columns, columns * inputs.contraction[:, None]])


def _curved(inputs: Inputs, values: Values, force: Array) -> Array:
    xp, state = inputs.xp, _operators(inputs, values).mean(axis=1)
    return -xp.stack([state, xp.maximum(state - DEAD, 0.0), xp.minimum(state + DEAD, 0.0)]).T


EFFECT = Effect(
    name="nonlocal_hysteresis",
    title="hysteresis with nonlocal memory",
    source="Al Janaideh, Rakheja & Su 2011, IEEE/ASME Trans. Mechatronics 16(4), 734–744 (generalised "
    "Prandtl–Ishlinskii); Kuhnen 2003, European Journal of Control 9, 407–418 (modified); Liu, Zang, Lin, Liu & Zhao "
    "2017, Strojniški vestnik 63(1), 56–64, and Capace, Cosentino, Amato & Merola 2019, Actuators 8(2), 49 (muscles)",
    forms=(
        AddsForce(
            "textbook",
            "−Σ W_i z_i, z_i = clip(z_i + Δx/r_i, −(1 + q ε), 1), r_i = r/4, r/2, r",
            SIZES,
            _generalised,
            (WIDTH, GROWTH, BEGUN),
            remembers=True,
        ),
        AddsForce(
            "growing",
            "as textbook at q = 0, W_i + G_i ε for W_i",
            SIZES + GROWTHS,
            _growing,
            (WIDTH, BEGUN),
            remembers=True,
        ),
        AddsForce(
            "curved",
            "−[V z + V_c max(z−½, 0) + V_e min(z+½, 0)], z the mean of the z_i at q = 0",
            CURVES,
            _curved,
            (WIDTH, BEGUN),
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
