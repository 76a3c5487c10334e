"""Threads stretch under pressure."""

import math

from ..core import Inputs, Param, Range
from .base import AddsForce, Array, Effect, Values, one

THREADS = Range(0.0, 0.5, "48 threads of 0.25 mm polyamide at 2 GPa and stiffer, EA above 2 kN (Davis et al. 2003)")
SOFTNESS = Param("inv_EA", "1/kN", "compliance of all threads, 1/EA", 0.0, 10.0, scale=0.01, range=THREADS)

SPREAD = Param("g", "1", "exponent of the radius over that at rest", -6.0, 3.0, start=0.5, grid=(0.5, -1.0, -4.0))
POWER = Param("q", "1", "exponent of the pressure", 1.3, 3.0, start=2.0, grid=(1.7, 2.4))


def _flat(inputs: Inputs, values: Values, force: Array) -> Array:
    s = inputs.specimen
    sin = math.sin(math.radians(s.braid_angle_deg))
    return one(-4e-3 * math.pi**2 * (s.initial_radius_mm / sin) ** 4 * inputs.pressure**2)


def _columns(inputs: Inputs, values: Values, force: Array) -> Array:
    cos = (1.0 - inputs.contraction) * math.cos(math.radians(inputs.specimen.braid_angle_deg))
    return _flat(inputs, values, force) * cos[:, None]


def _spreading(inputs: Inputs, values: Values, force: Array) -> Array:
    return _columns(inputs, values, force) * inputs.specimen.radius_ratio(inputs.contraction)[:, None] ** values["g"]


def _power(inputs: Inputs, values: Values, force: Array) -> Array:
    """Crimped threads give way at first and stiffen: another power of pressure than the second."""
    times = inputs.xp.maximum(inputs.pressure / 0.3, 1e-6) ** (values["q"] - 2.0)
    return _spreading(inputs, values, force) * times[:, None]


EFFECT = Effect(
    name="braid_extensibility",
    title="extensible threads",
    source="Davis, Tsagarakis, Canderle & Caldwell 2003, Int. J. Robotics Research 22(3–4), 213–227",
    forms=(
        AddsForce("textbook", "−4π² r0⁴ p² cosθ/(sin⁴θ0 EA)", (SOFTNESS,), _columns),
        AddsForce("flat", "−4π² r0⁴ p²/(sin⁴θ0 EA)", (SOFTNESS,), _flat),
        AddsForce("spreading", "−4π² r0⁴ p² cosθ (r/r0)^g/(sin⁴θ0 EA)", (SOFTNESS,), _spreading, (SPREAD,)),
        AddsForce("power", "as spreading, × (p/0.3 MPa)^(q − 2)", (SOFTNESS,), _power, (SPREAD, POWER)),
    ),
    follows=("map",),
    test="high pressures: the loss grows with the square of pressure",
    levers=("pressure",),
)
