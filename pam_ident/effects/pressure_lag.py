"""Air must flow through hose and valve, so that the muscle's pressure lags the sensor's while it moves."""

from ..core import Inputs, Param
from ._history import relax
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
FILLING = Param("T_fill", "s", "the same while the muscle fills", 0.0, 10.0, scale=0.01)
VENTING = Param("T_vent", "s", "the same while it is vented", 0.0, 10.0, scale=0.01)
KAPPA = Param("kappa", "1", "polytropic index of the gas in the muscle", 0.0, 50.0, scale=0.1)
TAU = Param("tau", "s", "time in which the pressure recovers", 0.002, 30.0, start=0.1, grid=(0.01, 0.04, 0.15, 0.6))
N = Param("n", "1", "exponent of the flow", 0.4, 2.5, start=1.5, grid=(0.6, 1.5, 2.0))


def _widening(inputs: Inputs) -> Array:
    """V̇/V of the braid's cylinder in 1/s, shape (n,)."""
    assert inputs.velocity is not None
    stroke_rate = inputs.velocity / inputs.specimen.initial_length_mm
    return inputs.specimen.log_volume_slope(inputs.contraction) * stroke_rate


def _rate(inputs: Inputs) -> Array:
    """p_abs V̇/V in MPa/s, shape (n,)."""
    return (inputs.pressure + ATMOSPHERE_MPA) * _widening(inputs)


def _volume(inputs: Inputs) -> Array:
    """V/V0 of the braid's cylinder, shape (n,)."""
    return inputs.specimen.radius_ratio(inputs.contraction) ** 2 * (1.0 - inputs.contraction)


def _quasi_steady(inputs: Inputs, shape: Shape, force: Array) -> Array:
    return one(-_rate(inputs))


def _mass_flow(inputs: Inputs, shape: Shape, force: Array) -> Array:
    """A line of fixed conductance loses pressure in proportion to the mass that flows, whatever the volume is."""
    return one(-_rate(inputs) * _volume(inputs))


def _volume_flow(inputs: Inputs, shape: Shape, force: Array) -> Array:
    """A line in which the gas is taken as incompressible loses pressure in proportion to the volume that flows."""
    return one(-_rate(inputs) * _volume(inputs) / (inputs.pressure + ATMOSPHERE_MPA) * 0.3)


def _two_ways(inputs: Inputs, shape: Shape, force: Array) -> Array:
    """A valve has one conductance from the supply and another to the exhaust."""
    rate, xp = _rate(inputs), inputs.xp
    return -xp.stack([xp.maximum(rate, 0.0), xp.minimum(rate, 0.0)]).T


def _lagging(inputs: Inputs, shape: Shape, force: Array) -> Array:
    """Driven by ln V itself, which is known at every sample, not by its rate, which jumps between them."""
    log_volume = inputs.xp.log(_volume(inputs))
    return one(-(inputs.pressure + ATMOSPHERE_MPA) * relax(inputs, log_volume, shape["tau"]))


def _conductance(inputs: Inputs, shape: Shape, force: Array) -> Array:
    """A valve of fixed conductance fills a larger volume more slowly: τ grows with V."""
    volume = _volume(inputs)
    return one(-(inputs.pressure + ATMOSPHERE_MPA) * relax(inputs, inputs.xp.log(volume), shape["tau"] * volume))


def _orifice(inputs: Inputs, shape: Shape, force: Array) -> Array:
    rate, xp = _rate(inputs), inputs.xp
    return one(-xp.sign(rate) * 0.1 * (xp.abs(rate) / 0.1) ** shape["n"])


def _throttled(inputs: Inputs, shape: Shape, force: Array) -> Array:
    """A loss in proportion to the gas's density, and to a power of its speed."""
    rate, xp = _widening(inputs), inputs.xp
    return one(-xp.sign(rate) * 0.3 * (inputs.pressure + ATMOSPHERE_MPA) * (xp.abs(rate) / 0.3) ** shape["n"])


EFFECT = Effect(
    name="pressure_lag",
    title="Pressure lag of the muscle behind the sensor",
    source="energy balance of a variable volume, ṗ = κ R T q/V − κ p V̇/V, with a resistance between sensor and muscle",
    forms=(
        TransformsPressure("textbook", "p → p − T_p p_abs V̇/V", (LAG,), _quasi_steady),
        TransformsPressure("mass_flow", "p → p − T_p p_abs V̇/V0", (LAG,), _mass_flow),
        TransformsPressure("volume_flow", "p → p − T_p · 0.3 MPa · V̇/V0", (LAG,), _volume_flow),
        TransformsPressure(
            "two_ways", "p → p − T p_abs V̇/V, T_fill where V̇ > 0, else T_vent", (FILLING, VENTING), _two_ways
        ),
        TransformsPressure("lagging", "p → p − κ p_abs q, q̇ = V̇/V − q/τ", (KAPPA,), _lagging, (TAU,), remembers=True),
        TransformsPressure("conductance", "the same with τ V/V0 for τ", (KAPPA,), _conductance, (TAU,), remembers=True),
        TransformsPressure("orifice", "p → p − T_p |p_abs V̇/V|^n sgn(V̇)", (LAG,), _orifice, (N,)),
        TransformsPressure("throttled", "p → p − T_p p_abs |V̇/V|^n sgn(V̇)", (LAG,), _throttled, (N,)),
    ),
    test="a pressure sensor at the muscle, at several speeds",
    needs=("branch", "motion", "time"),
    levers=("speed", "pressure"),
)
