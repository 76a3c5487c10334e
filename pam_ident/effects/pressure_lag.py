"""Air must flow through hose and valve, so that the muscle's pressure lags the sensor's while it moves."""

from dataclasses import replace

from ..core import Inputs, Param, Range
from ._history import integral, relax
from .base import Array, Effect, TransformsPressure, Values, free_form, one

ATMOSPHERE_MPA, BARE_MPA = 0.101325, 0.1

LAG = Param(
    "T_p",
    "s",
    "droop: pressure lost per relative rate of volume and absolute pressure",
    0.0,
    10.0,
    scale=0.01,
)
BARE = Param("T_0", "s", "droop per relative rate of volume and 0.1 MPa, at any pressure", 0.0, 10.0, scale=0.01)
PARTS = (replace(LAG, doc="droop per relative rate of volume and gauge pressure"), BARE)
FILLS, VENTS = (
    tuple(replace(part, name=f"{part.name}_{way}", doc=f"{part.doc}, {words}") for part in PARTS)
    for way, words in (("fill", "while the muscle fills"), ("vent", "while it is vented"))
)
AIR = Range(0.3, 1.7, "air, 1.0 to 1.4, less what a hose of up to three times the muscle's volume holds")
KAPPA = Param("kappa", "1", "polytropic index of the gas in the muscle", 0.0, 50.0, scale=0.1, range=AIR)
KAPPA_P = Param("kappa_p", "1", "polytropic index, per gauge pressure", 0.0, 50.0, scale=0.1)
KAPPA_0 = Param("kappa_0", "1", "polytropic index, per 0.1 MPa at any pressure", 0.0, 50.0, scale=0.1)
TAU = Param("tau", "s", "time in which the pressure recovers", 0.002, 30.0, start=0.1, grid=(0.01, 0.04, 0.15, 0.6))
VENTING = Param("w", "1", "time constant of venting over that of filling", 0.1, 10.0, start=1.5, grid=(0.6, 1.7))
N = Param("n", "1", "exponent of the flow", 0.4, 2.5, start=1.5, grid=(0.6, 1.5, 2.0))


def _widening(inputs: Inputs) -> Array:
    """V̇/V of the braid's cylinder in 1/s, shape (n,); where the pressure is driven, gas flows for ṗ/p_abs, too."""
    assert inputs.velocity is not None
    stroke_rate = inputs.velocity / inputs.specimen.initial_length_mm
    if inputs.locked and inputs.pressure_rate is not None:
        return inputs.pressure_rate / _absolute(inputs)
    widening = inputs.specimen.log_volume_slope(inputs.contraction) * stroke_rate
    return widening if inputs.pressure_rate is None else widening + inputs.pressure_rate / _absolute(inputs)


def _absolute(inputs: Inputs) -> Array:
    """Absolute pressure in MPa, shape (n,)."""
    return inputs.pressure + ATMOSPHERE_MPA


def _log_gas(inputs: Inputs) -> Array:
    """ln V/V0 of the gas that flows, shape (n,): times the absolute pressure where that is driven."""
    xp = inputs.xp
    volume = xp.log(_volume(inputs))
    return volume if inputs.pressure_rate is None else volume + xp.log(_absolute(inputs))


def _rate(inputs: Inputs) -> Array:
    """p_abs V̇/V in MPa/s, shape (n,)."""
    return _absolute(inputs) * _widening(inputs)


def _volume(inputs: Inputs) -> Array:
    """V/V0 of the braid's cylinder, shape (n,)."""
    return inputs.specimen.radius_ratio(inputs.contraction) ** 2 * (1.0 - inputs.contraction)


def _quasi_steady(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(-_rate(inputs))


def _mass_flow(inputs: Inputs, values: Values, force: Array) -> Array:
    """A line of fixed conductance loses pressure in proportion to the mass that flows, whatever the volume is."""
    return one(-_rate(inputs) * _volume(inputs))


def _volume_flow(inputs: Inputs, values: Values, force: Array) -> Array:
    """A line in which the gas is taken as incompressible loses pressure in proportion to the volume that flows."""
    # 0.3 MPa, a usual pressure, keeps T_p a time of the size that it has in the other forms.
    return one(-_widening(inputs) * _volume(inputs) * 0.3)


def _parts(inputs: Inputs, drive: Array) -> Array:
    """A drive (n,) per gauge pressure and per 0.1 MPa, shape (n, 2): what the gas is reckoned from is left open."""
    return inputs.xp.stack([inputs.pressure * drive, BARE_MPA * drive]).T


def _affine(inputs: Inputs, values: Values, force: Array) -> Array:
    return -_parts(inputs, _widening(inputs))


def _two_ways(inputs: Inputs, values: Values, force: Array) -> Array:
    """A valve has one conductance from the supply and another to the exhaust."""
    rate, xp = _widening(inputs), inputs.xp
    return -xp.hstack([_parts(inputs, xp.maximum(rate, 0.0)), _parts(inputs, xp.minimum(rate, 0.0))])


def _lagging(inputs: Inputs, values: Values, force: Array) -> Array:
    """Driven by ln V itself, which is known at every sample, not by its rate, which jumps between them."""
    tau, bare = values["tau"], BARE_MPA * relax(inputs, _log_gas(inputs), values["tau"])
    return -inputs.xp.stack([_lost(inputs, inputs.pressure, tau), bare]).T


def _filling(inputs: Inputs, values: Values, force: Array) -> Array:
    """The same by the rate, where it changes smoothly and samples are far between."""
    rate = _widening(inputs)
    return -_parts(inputs, rate - relax(inputs, rate, values["tau"]))


def _lost(inputs: Inputs, pressure: Array, tau: Array | float) -> Array:
    """What is lost of a pressure p (n,) in MPa between sensor and muscle, q̇ = p V̇/V + ṗ − q/τ, shape (n,); τ in s."""
    log_volume = inputs.xp.log(_volume(inputs))
    if inputs.pressure_rate is None:
        return pressure * relax(inputs, log_volume, tau)
    pumped = 0.0 if inputs.locked else integral(inputs, pressure, log_volume)
    return relax(inputs, pressure + pumped, tau)


def _through_valve(inputs: Inputs, tau: float, ways: Array | float = 1.0) -> Array:
    """A valve of fixed conductance fills a larger volume more slowly: τ grows with V."""
    return one(-_lost(inputs, _absolute(inputs), tau * _volume(inputs) * ways))


def _conductance(inputs: Inputs, values: Values, force: Array) -> Array:
    return _through_valve(inputs, values["tau"])


def _valve(inputs: Inputs, values: Values, force: Array) -> Array:
    """The same with one conductance from the supply and another to the exhaust."""
    return _through_valve(inputs, values["tau"], inputs.xp.where(inputs.direction > 0.0, 1.0, values["w"]))


def _choking(inputs: Inputs, values: Values, force: Array) -> Array:
    """An orifice lets the less through per difference of pressure, the more that is: τ grows with it, and the next
    course follows from the last, from a hose's on."""
    tau, xp = values["tau"], inputs.xp
    times, pressure = tau * _volume(inputs), _absolute(inputs)
    lost = _lost(inputs, pressure, times)
    for _ in range(2):
        size = xp.maximum(xp.abs(lost) / (0.3 * tau * pressure), 1e-3)
        lost = _lost(inputs, pressure, times * size ** (1.0 - 1.0 / values["n"]))
    return one(-lost)


def _to_the_power(inputs: Inputs, rate: Array, n: float, unit: float) -> Array:
    """A rate (n,) whose size, in units of `unit`, is raised to the n-th power."""
    xp = inputs.xp
    return xp.sign(rate) * unit * (xp.abs(rate) / unit) ** n


def _orifice(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(-_to_the_power(inputs, _rate(inputs), values["n"], 0.1))


def _two_rates(inputs: Inputs, values: Values, force: Array) -> Array:
    """What the volume and what the driven pressure let flow, which a hose between valve and sensor tells apart."""
    xp, rate = inputs.xp, _rate(inputs)
    driven = xp.zeros_like(rate) if inputs.pressure_rate is None else inputs.pressure_rate
    return -xp.stack([rate - driven, driven]).T


def _throttled(inputs: Inputs, values: Values, force: Array) -> Array:
    """A loss in proportion to the gas's density, and to a power of its speed."""
    return -_parts(inputs, _to_the_power(inputs, _widening(inputs), values["n"], 0.3))


EFFECT = Effect(
    name="pressure_lag",
    title="pressure lag of the muscle behind the sensor",
    source="energy balance of a variable volume, ṗ = κ R T q/V − κ p V̇/V, with a resistance between sensor and muscle; "
    "V̇/V is V̇/V + ṗ/p_abs where the pressure is driven, and p q is q then, with q̇ = p V̇/V + ṗ − q/τ",
    forms=(
        TransformsPressure("textbook", "p → p − T_p p_abs V̇/V", (LAG,), _quasi_steady),
        TransformsPressure("mass_flow", "p → p − T_p p_abs V̇/V0", (LAG,), _mass_flow),
        TransformsPressure("volume_flow", "p → p − T_p · 0.3 MPa · V̇/V0", (LAG,), _volume_flow),
        TransformsPressure("affine", "p → p − (T_p p + T_0 · 0.1 MPa) V̇/V", PARTS, _affine),
        TransformsPressure(
            "two_ways",
            "the same, T_p_fill and T_0_fill where V̇ > 0, else …_vent",
            FILLS + VENTS,
            _two_ways,
        ),
        TransformsPressure(
            "lagging",
            "p → p − (κ_p p + κ_0 · 0.1 MPa) q, q̇ = V̇/V − q/τ",
            (KAPPA_P, KAPPA_0),
            _lagging,
            (TAU,),
            remembers=True,
        ),
        TransformsPressure(
            "filling",
            "p → p − (T_p p + T_0 · 0.1 MPa) w, ẇ = (V̇/V − w)/τ",
            PARTS,
            _filling,
            (TAU,),
            remembers=True,
        ),
        TransformsPressure(
            "conductance", "p → p − κ p_abs q, τ V/V0 for τ", (KAPPA,), _conductance, (TAU,), remembers=True
        ),
        TransformsPressure(
            "valve",
            "p → p − κ p_abs q, τ V/V0 for τ, w τ V/V0 where V̇ < 0",
            (KAPPA,),
            _valve,
            (TAU, VENTING),
            remembers=True,
        ),
        TransformsPressure(
            "choking",
            "p → p − κ p_abs q, τ V/V0 |q/(0.3 τ)|^(1−1/n) for τ",
            (KAPPA,),
            _choking,
            (TAU, N),
            remembers=True,
        ),
        TransformsPressure("orifice", "p → p − T_p |p_abs V̇/V|^n sgn(V̇)", (LAG,), _orifice, (N,)),
        TransformsPressure("throttled", "p → p − (T_p p + T_0 · 0.1 MPa) |V̇/V|^n sgn(V̇)", PARTS, _throttled, (N,)),
        free_form("p → p − |p_abs V̇/V|^n sgn(V̇)", _orifice, nonlinear=(N,), role=TransformsPressure, unit=("s", 0.1)),
        free_form(
            "p → p − p_abs q, τ V/V0 for τ, w τ V/V0 where V̇ < 0",
            _valve,
            nonlinear=(TAU, VENTING),
            role=TransformsPressure,
            unit=("1", 0.1),
            remembers=True,
            name="free_lagging",
        ),
        free_form(
            "p → p − p_abs V̇/V and −ṗ",
            _two_rates,
            2,
            role=TransformsPressure,
            unit=("s", 0.1),
            name="free_rates",
            needs=("driven pressure",),
        ),
    ),
    follows=("speed", "pressure_rate"),
    test="a pressure sensor at the muscle, at several speeds",
    needs=("branch", "motion", "time"),
    levers=("speed", "pressure"),
)
