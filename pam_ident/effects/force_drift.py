"""The load cell's zero wanders with time."""

from dataclasses import replace

from ..core import Inputs, Param, Range
from ._history import since_first
from .base import AddsForce, Array, Effect, Values, one

CELL = "strain-gauge load cells, a tenth of 2 kN, or of the largest force"
RATE = Param("rate", "N/min", "drift of the zero", -1000.0, 1000.0, scale=1.0, range=Range(-60.0, 60.0, CELL, 2000.0))
LEVEL = Param("F_d", "N", "drift once settled", -5000.0, 5000.0, scale=10.0, range=Range(-200.0, 200.0, CELL, 2000.0))
TAU = Param("tau", "s", "settling time of the drift", 5.0, 1e5, start=200.0, grid=(15.0, 60.0, 200.0, 600.0, 2000.0))
SWING = (
    replace(LEVEL, name="F_sin", doc="sine part of a swing"),
    replace(LEVEL, name="F_cos", doc="cosine part of a swing"),
)
SOON = replace(TAU, lower=40.0, upper=300.0, start=100.0, grid=(60.0, 200.0))
"""What settles more slowly is what powers of the time follow; faster, and one stroke alone would show it."""
FREE = (
    replace(LEVEL, lower=-1e5, upper=1e5, range=None),  # parts of a course, each of which may be far larger
    *(Param(f"F_{k}", "N", f"coefficient of (t/10 min)^{k}", scale=10.0) for k in range(1, 6)),
)
PERIOD = Param("T", "s", "period of the swing", 120.0, 1e5, start=1800.0, grid=(450.0, 900.0, 1800.0, 3600.0, 7200.0))


def elapsed(inputs: Inputs) -> Array:
    """Seconds since the first sample, shape (n,)."""
    assert inputs.time is not None
    return since_first(inputs, inputs.time)


def _linear(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(elapsed(inputs) / 60.0)


def _settling(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(-inputs.xp.expm1(-elapsed(inputs) / values["tau"]))


def _settling_on(inputs: Inputs, values: Values, force: Array) -> Array:
    return inputs.xp.hstack([_settling(inputs, values, force), _linear(inputs, values, force)])


def _logarithmic(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(inputs.xp.log1p(elapsed(inputs) / values["tau"]))


def _swinging(inputs: Inputs, values: Values, force: Array) -> Array:
    xp = inputs.xp
    angle = elapsed(inputs) * (2.0 * xp.pi / values["T"])
    return xp.stack([xp.sin(angle), 1.0 - xp.cos(angle)]).T


def _smooth(inputs: Inputs, values: Values, force: Array) -> Array:
    late = elapsed(inputs) / 600.0
    powers = inputs.xp.stack([late**k for k in range(1, 6)]).T
    return inputs.xp.hstack([_settling(inputs, values, force), powers])


EFFECT = Effect(
    name="force_drift",
    title="drift of the force",
    source="zero drift of strain-gauge load cells: linear, settling, logarithmic, and with "
    "a room whose temperature swings",
    forms=(
        AddsForce("textbook", "+rate · t", (RATE,), _linear),
        AddsForce("settling", "+F_d (1 − exp(−t/τ))", (LEVEL,), _settling, (TAU,)),
        AddsForce("logarithmic", "+F_d ln(1 + t/τ)", (LEVEL,), _logarithmic, (TAU,)),
        AddsForce("settling_on", "+F_d (1 − exp(−t/τ)) + rate · t", (LEVEL, RATE), _settling_on, (TAU,)),
        AddsForce("swinging", "+F_sin sin(2πt/T) + F_cos (1 − cos(2πt/T))", SWING, _swinging, (PERIOD,)),
        AddsForce("free", "+F_d (1 − exp(−t/τ)) + Σ F_k (t/10 min)^k, k = 1 … 5", FREE, _smooth, (SOON,)),
    ),
    follows=("clock",),
    test="tare before and after; pressures in random order",
    needs=("time",),
    levers=("hold",),
)
