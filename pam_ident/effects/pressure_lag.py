"""Air must flow through hose and valve, so that the muscle's pressure lags the sensor's while it moves."""

import numpy as np

from ..core import Inputs, Param
from ._history import follow
from .base import Array, Effect, Shape, TransformsPressure, one

ATMOSPHERE_MPA = 0.101325

LAG = Param(
    "T_p",
    "s",
    "droop: pressure lost per relative rate of volume and absolute pressure",
    0.0,
    10.0,
    scale=0.01,
)
TAU = Param("tau", "s", "time in which the pressure recovers", 0.005, 30.0, start=0.3, grid=(0.05, 0.3, 1.5))
N = Param("n", "1", "exponent of the flow", 0.4, 2.5, start=1.5, grid=(0.6, 1.5, 2.0))


def _rate(inputs: Inputs) -> Array:
    """p_abs · d ln V/dt in MPa/s, V the braid's cylinder, shape (n,)."""
    assert inputs.velocity is not None
    stroke_rate = inputs.velocity / inputs.specimen.initial_length_mm
    return (inputs.pressure + ATMOSPHERE_MPA) * inputs.specimen.log_volume_slope(inputs.contraction) * stroke_rate


def _quasi_steady(inputs: Inputs, shape: Shape, force: Array) -> Array:
    return one(-_rate(inputs))


def _lagging(inputs: Inputs, shape: Shape, force: Array) -> Array:
    return one(-follow(inputs, _rate(inputs), shape["tau"]))


def _orifice(inputs: Inputs, shape: Shape, force: Array) -> Array:
    rate = _rate(inputs)
    return one(-np.sign(rate) * 0.1 * (np.abs(rate) / 0.1) ** shape["n"])


EFFECT = Effect(
    name="pressure_lag",
    title="Pressure lag of the muscle behind the sensor",
    source="energy balance of a variable volume, ṗ = κ R T q/V − κ p V̇/V, with a resistance between sensor and muscle",
    forms=(
        TransformsPressure("textbook", "p → p − T_p p_abs V̇/V", (LAG,), _quasi_steady),
        TransformsPressure("lagging", "the same, recovering with τ", (LAG,), _lagging, (TAU,)),
        TransformsPressure("orifice", "p → p − T_p |p_abs V̇/V|^n sgn(V̇)", (LAG,), _orifice, (N,)),
    ),
    test="a pressure sensor at the muscle, at several speeds",
    needs=("branch", "motion", "time"),
    levers=("speed", "pressure"),
    stateful=True,
)
