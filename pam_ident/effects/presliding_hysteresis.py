"""Elastic micro-slip before full sliding: corners of the loop rounded after each reversal."""

from dataclasses import replace

from ..core import Inputs, Param
from ._history import STROKE_MM, dahl_operator, first_bend, stop_operator
from .base import AddsForce, Array, Effect, Values, free_form, one, with_pressure
from .coulomb_friction import V_S
from .stribeck_friction import PEAK, bending

W = Param("W", "N", "friction force when fully slid", 0.0, 2000.0, scale=10.0)
W_PRESSURE = Param("W_p", "N/MPa", "growth of that force with pressure", 0.0, 1e4, scale=30.0)
WIDTH = Param(
    "x_s",
    "mm",
    "travel after a reversal until sliding",
    0.5,
    80.0,
    start=3.0,
    grid=(0.5, 1.0, 2.5, 6.0, 15.0),
)
"""Over a shorter one a contact bends that slides, and the rig behind it: that is dry friction's."""
WIDE = replace(WIDTH, lower=1.0, grid=(1.0, 2.5, 4.0, 6.0, 10.0, 15.0))
"""Shorter than this a friction that grows with pressure is dry."""
LONG = replace(WIDTH, lower=3.0, start=3.0, grid=WIDE.grid[2:])
"""With a shorter one of three, of any dependence on the pressure, few samples would tell it from dry friction."""
BEGUN = Param("z_0", "1", "bend of the contact at the first sample, as a share", -1.0, 1.0, start=0.0, grid=(0.0,))
"""Nobody knows what the muscle did before the record."""
LOW = replace(PEAK, grid=(1.2,))
SEEN = replace(WIDTH, grid=(0.7, 1.5, 3.0, 7.0))
THREE = tuple(
    Param(f"W_{k}", "N", f"friction force of the {word} element", 0.0, 2000.0, scale=10.0)
    for k, word in enumerate(("shortest", "middle", "longest"), 1)
)


def slipping(inputs: Inputs, width: float) -> float:
    """`width`, or what still slips in both directions: an element that never does is a spring, and the bladder's."""
    if inputs.live is not None:
        return width
    reach = STROKE_MM if inputs.locked else inputs.reach_mm
    return min(width, 0.4 * reach or width)


def _single(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(-stop_operator(inputs, slipping(inputs, values["x_s"]), begun=first_bend(values)))


def _dahl(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(-dahl_operator(inputs, slipping(inputs, values["x_s"]), begun=first_bend(values)))


def _growing(inputs: Inputs, values: Values, force: Array) -> Array:
    return with_pressure(_dahl(inputs, values, force), inputs)


def _lugre(inputs: Inputs, values: Values, force: Array) -> Array:
    return bending(inputs, {**values, "x_s": slipping(inputs, values["x_s"])}, force)


def _three(inputs: Inputs, values: Values, force: Array, rested: bool = False) -> Array:
    widths = [slipping(inputs, values["x_s"] * ratio) for ratio in (0.3, 1.0, 3.0)]
    return -inputs.xp.stack([stop_operator(inputs, width, rested, begun=first_bend(values)) for width in widths]).T


def _rested(inputs: Inputs, values: Values, force: Array) -> Array:
    """The braid lets go of the bladder while the pressure is changed."""
    return _three(inputs, values, force, rested=True)


EFFECT = Effect(
    name="presliding_hysteresis",
    title="presliding hysteresis",
    source="Vo-Minh, Tjahjowidodo, Ramon & Van Brussel 2011, IEEE/ASME Trans. Mechatronics 16(1), 177–186 "
    "(Maxwell slip); Dahl 1968; Canudas de Wit et al. 1995, IEEE Trans. Automatic Control 40(3), 419–425 (LuGre)",
    forms=(
        AddsForce("textbook", "−W clip(Δx/x_s, ±1)", (W,), _single, (WIDTH, BEGUN), remembers=True),
        AddsForce("dahl", "dz/dx = (1 − z sgn ẋ)/x_s, −W z", (W,), _dahl, (WIDTH, BEGUN), remembers=True),
        AddsForce(
            "pressed",
            "dz/dx = (1 − z sgn ẋ)/x_s, −(W + W_p p) z",
            (W, W_PRESSURE),
            _growing,
            (WIDE, BEGUN),
            remembers=True,
            same_as="pressure_friction",
        ),
        AddsForce(
            "lugre",
            "−W z, dz/dx = (1 − z sgn ẋ/g)/x_s, g = 1 + (peak−1) exp(−(v/v_s)²)",
            (W,),
            _lugre,
            (LOW, V_S, SEEN, BEGUN),
            remembers=True,
            same_as="stribeck_friction",
        ),
        AddsForce("maxwell_slip_3", "−Σ W_i clip(Δx/x_i, ±1)", THREE, _three, (WIDTH, BEGUN), remembers=True),
        AddsForce(
            "rested",
            "as maxwell_slip_3, bent by z_0 anew as a segment begins",
            THREE,
            _rested,
            (WIDTH, BEGUN),
            remembers=True,
        ),
        replace(
            free_form(
                "−clip(Δx/x_i, ±1)", _three, 3, contraction=1, nonlinear=(LONG, BEGUN), remembers=True, resisting=3
            ),
            same_as="pressure_friction",
        ),
    ),
    follows=("way", "direction"),
    test="reversals and minor loops at one slow speed",
    needs=("branch", "motion"),
    levers=("reversal",),
)
