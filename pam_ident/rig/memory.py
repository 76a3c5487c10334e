"""Effects that remember: pressure lag, load drift, creep, stress softening, warming.

Same signature as in friction.py: (course, muscle, rng) -> (settings, force(size) in N on the fine grid).
"""

import numpy as np

from .friction import Force, Forms, Settings, elsewhere, form_of, scaled
from .integrate import follow, stiff_path
from .muscle import AMBIENT_MPA, Array, RigMuscle
from .protocol import RigRun

KAPPA = 1.4  # adiabatic exponent of air
FORMS: Forms = {}


def _growth(c: RigRun, m: RigMuscle) -> list[float]:
    """V'/V (1/s) over the step that ends at each grid point, from the volumes themselves."""
    steps = np.diff(np.log(m.specimen.volume(c.eps))) / np.diff(c.time)
    return [0.0, *steps.tolist()]


@form_of(FORMS, "pressure_lag")
def lag_quasi_steady(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """p_m = p - T [p' + p_abs (V'/V) eps'] at the rates of pressure and contraction; size T in s."""
    fall = np.gradient(c.pressure, c.time + 1e-9 * np.arange(len(c.time)))
    fall += (c.pressure + AMBIENT_MPA) * m.specimen.log_volume_slope(c.eps) * c.rate
    fall = np.where(c.moving != 0, fall, 0.0)
    return {}, lambda size: elsewhere(c, m, c.pressure - size * fall)


def _through_valve(c: RigRun, m: RigMuscle, n: float, venting: float = 1.0) -> Force:
    """Gas balance (9) with a linear valve: p' = (V0/V)(p_v - p)/T - n p_abs V'/V, times `venting` where p > p_v."""
    volume = m.specimen.volume(c.eps)
    opening = (volume[0] / volume).tolist()
    growth = _growth(c, m)
    valve = c.pressure.tolist()

    def force(size: float) -> Array:
        def slope(i: int, p: float) -> tuple[float, float]:
            way = opening[i] * (1.0 if valve[i] > p else venting) / size
            return way * (valve[i] - p) - n * (p + AMBIENT_MPA) * growth[i], -way - n * growth[i]

        return elsewhere(c, m, stiff_path(c.time, valve[0], slope))

    return force


@form_of(FORMS, "pressure_lag", "first_order")
def lag_first_order(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """A linear valve; size T in s, n 1..1.4."""
    n = rng.uniform(1.0, KAPPA)
    return {"polytropic": n}, _through_valve(c, m, n)


@form_of(FORMS, "pressure_lag", "two_ways")
def lag_two_ways(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """A valve that vents more slowly than it fills."""
    n, slower = rng.uniform(1.0, KAPPA), rng.uniform(0.4, 0.8)
    return {"polytropic": n, "venting": slower}, _through_valve(c, m, n, slower)


@form_of(FORMS, "pressure_lag", "orifice")
def lag_orifice(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Gas balance (9) with the orifice (10), (11), b' = 0.3..0.5, and a laminar part near equal pressures.

    Size in s: volume at the start over sonic conductance, so that a choked orifice fills at p_up/size.
    """
    critical, laminar = rng.uniform(0.3, 0.5), 0.995
    volume = m.specimen.volume(c.eps)
    opening = (volume[0] / volume).tolist()
    growth = _growth(c, m)
    valve = (c.pressure + AMBIENT_MPA).tolist()
    at_laminar = float(np.sqrt(1 - ((laminar - critical) / (1 - critical)) ** 2)) / (1 - laminar)

    def conductance(up: float, down: float) -> float:
        ratio = down / up
        if ratio > laminar:
            return at_laminar
        choked = ratio <= critical
        omega = 1.0 if choked else (1 - ((ratio - critical) / (1 - critical)) ** 2) ** 0.5
        return omega / (1 - ratio)

    def force(size: float) -> Array:
        # Flow written as conductance times difference: a step then never runs past the valve's pressure.
        def slope(i: int, p: float) -> tuple[float, float]:
            v = valve[i]
            g = opening[i] * conductance(max(v, p), min(v, p)) / size
            return g * (v - p) - KAPPA * p * growth[i], -g - KAPPA * growth[i]

        return elsewhere(c, m, stiff_path(c.time, valve[0], slope) - AMBIENT_MPA)

    return {"critical_ratio": critical}, force


def _elapsed(c: RigRun) -> Array:
    return c.time - c.time[c.rows[0]]


@form_of(FORMS, "force_drift")
def drift_linear(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Straight in time; size in N over the whole record, either sign."""
    sign = float(rng.choice([-1.0, 1.0]))
    t = _elapsed(c)
    return {"sign": sign}, scaled(sign * t / t[-1])


@form_of(FORMS, "force_drift", "settling")
def drift_settling(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """1 - exp(-t/tau): an amplifier warming up."""
    sign, tau = float(rng.choice([-1.0, 1.0])), rng.uniform(80.0, 400.0)
    return {"sign": sign, "tau_s": tau}, scaled(-sign * np.expm1(-_elapsed(c) / tau))


@form_of(FORMS, "force_drift", "log")
def drift_log(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """log(1 + t/t0): creep of the load cell's glue."""
    sign, t0 = float(rng.choice([-1.0, 1.0])), rng.uniform(10.0, 60.0)
    return {"sign": sign, "t0_s": t0}, scaled(sign * np.log1p(np.maximum(_elapsed(c), 0.0) / t0))


def maxwell_arms(c: RigRun, drive: Array, taus: Array, weights: Array) -> Array:
    """Sum of w (u - q), q' = (u - q)/tau: what relaxing arms, rested at first, still carry of u (m,)."""
    out = np.zeros_like(drive)
    for tau, weight in zip(taus, weights, strict=True):
        out += weight * (drive - follow(c.time, drive, float(tau)))
    return out


@form_of(FORMS, "creep")
def creep_solid(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Standard linear solid on the contraction: -G (eps - q), q' = (eps - q)/tau; size G in N."""
    tau = float(np.exp(rng.uniform(np.log(2.0), np.log(12.0))))
    return {"tau_s": tau}, scaled(-maxwell_arms(c, c.slide, np.array([tau]), np.ones(1)))


def _prony(taus: Array, rng: np.random.Generator, c: RigRun) -> tuple[Settings, Force]:
    weight = rng.uniform(0.5, 1.5, len(taus))
    settings = {f"tau{i}_s": float(t) for i, t in enumerate(taus)}
    return settings, scaled(-maxwell_arms(c, c.slide, taus, weight / weight.sum()))


@form_of(FORMS, "creep", "prony_2")
def creep_prony2(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Two Prony terms."""
    return _prony(np.array([rng.uniform(0.8, 2.5), rng.uniform(8.0, 30.0)]), rng, c)


@form_of(FORMS, "creep", "prony_3")
def creep_prony3(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Three Prony terms over two decades."""
    return _prony(np.array([rng.uniform(0.5, 1.0), rng.uniform(4.0, 8.0), rng.uniform(30.0, 60.0)]), rng, c)


@form_of(FORMS, "creep", "log_time")
def creep_log_time(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Relaxation straight in log time from 0.3 to 300 s: a flat spectrum of arms."""
    taus = np.geomspace(0.3, 300.0, 10)
    return {"fastest_s": 0.3, "slowest_s": 300.0}, scaled(-maxwell_arms(c, c.slide, taus, np.full(10, 0.1)))


@form_of(FORMS, "creep", "power_law")
def creep_power(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Power-law kernel t^-beta (springpot), its spectrum tau^-beta cut at 0.3 and 300 s."""
    beta = rng.uniform(0.15, 0.5)
    taus = np.geomspace(0.3, 300.0, 12)
    weight = taus**-beta
    return {"beta": beta}, scaled(-maxwell_arms(c, c.slide, taus, weight / weight.sum()))


@form_of(FORMS, "creep", "by_force")
def creep_by_force(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Driven by the load in place of the contraction: g (F - q), q following F; size a share of the force."""
    tau = float(np.exp(rng.uniform(np.log(2.0), np.log(12.0))))
    drive = m.force(c.pressure, c.eps)
    return {"tau_s": tau}, scaled(maxwell_arms(c, drive, np.array([tau]), np.ones(1)))


@form_of(FORMS, "mullins_softening")
def mullins_exponential(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """A exp(-(n - 1)/n0), n the cycle within the isobar; size A in N."""
    n0 = rng.uniform(0.8, 2.5)
    return {"n0": n0}, scaled(np.exp(-(c.cycle - 1) / n0))


@form_of(FORMS, "mullins_softening", "power")
def mullins_power(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """A n^-k."""
    k = rng.uniform(0.7, 1.5)
    return {"k": k}, scaled(c.cycle**-k)


@form_of(FORMS, "mullins_softening", "force_share")
def mullins_force(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """First cycles stiffer by a share of the force; size that share."""
    n0 = rng.uniform(0.8, 2.5)
    return {"n0": n0}, scaled(m.force(c.pressure, c.eps) * np.exp(-(c.cycle - 1) / n0))


def _bladder(c: RigRun, m: RigMuscle) -> Array:
    """Elastic shape of the bladder (hoop energy), dimensionless."""
    return (1 - c.eps) * (1 - m.specimen.initial_radius_mm / m.specimen.radius(c.eps))


@form_of(FORMS, "mullins_softening", "elastic_share")
def mullins_elastic(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """A virgin bladder resists more: -A exp(-(n - 1)/n0) times the hoop stress, zero at rest."""
    n0 = rng.uniform(0.8, 2.5)
    return {"n0": n0}, scaled(-_bladder(c, m) * np.exp(-(c.cycle - 1) / n0))


@form_of(FORMS, "mullins_softening", "rested")
def mullins_rested(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Between isobars the rubber recovers only a share of what the first one took."""
    n0, share = rng.uniform(0.8, 2.5), rng.uniform(0.3, 0.8)
    left = np.where(c.isobar == c.isobar[c.rows[0]], 1.0, share)
    return {"n0": n0, "recovered": share}, scaled(left * np.exp(-(c.cycle - 1) / n0))


@form_of(FORMS, "mullins_softening", "travel")
def mullins_travel(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Damage by the way travelled within the isobar, no step between cycles."""
    n0 = rng.uniform(0.8, 2.0)
    way = np.cumsum(np.abs(np.diff(c.slide, prepend=c.slide[0])) * (c.moving != 0))
    out = np.empty_like(way)
    for number in np.unique(c.isobar):
        here = c.isobar == number
        done = way[here] - way[here][0]
        out[here] = np.exp(-done / (2 * n0 * np.ptp(c.slide[here & (c.moving != 0)])))
    return {"n0": n0}, scaled(out)


@form_of(FORMS, "mullins_softening", "whole_test")
def mullins_whole_test(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """The damage stays from one isobar to the next: n counted from the start of the test."""
    n0 = rng.uniform(2.0, 6.0)
    return {"n0": n0}, scaled(np.exp(-(np.maximum(c.count, 1) - 1) / n0))


def _warming(c: RigRun) -> Array:
    return c.temperature - c.temperature[c.rows[0]]


@form_of(FORMS, "thermal_softening")
def thermal_force(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """F (1 - alpha dT); size alpha in 1/K."""
    return {}, scaled(-m.force(c.pressure, c.eps) * _warming(c))


@form_of(FORMS, "thermal_softening", "elastic_part")
def thermal_elastic(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Only the bladder softens: it takes less off the pull; size in N/K at full shape."""
    return {}, scaled(_bladder(c, m) * _warming(c))


@form_of(FORMS, "thermal_softening", "core")
def thermal_core(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """The rubber runs behind the logged skin temperature by a first-order lag."""
    tau = rng.uniform(20.0, 60.0)
    core = follow(c.time, _warming(c), tau)
    return {"tau_s": tau}, scaled(-m.force(c.pressure, c.eps) * core)


@form_of(FORMS, "thermal_softening", "saturating")
def thermal_saturating(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Softening that levels off: dT/(1 + dT/T1), T1 20..60 K."""
    t1 = rng.uniform(20.0, 60.0)
    warm = _warming(c)
    return {"T1_K": t1}, scaled(-m.force(c.pressure, c.eps) * warm / (1 + np.abs(warm) / t1))
