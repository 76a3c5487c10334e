"""Rate and direction dependent effects: friction of several kinds, damping, hysteresis before sliding.

Every function draws the form's own constants and returns (settings, force), where force(size) is the
change of the muscle force (N) on the fine grid, shape (m,).  Friction resists the motion: it lowers the
pull while the muscle contracts and raises it while it is stretched.  Sizes in N unless said otherwise.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .integrate import travel_path
from .muscle import Array, RigMuscle
from .protocol import RigRun

Settings = dict[str, float]
Force = Callable[[float], Array]
Form = Callable[[RigRun, RigMuscle, np.random.Generator], tuple[Settings, Force]]


def scaled(shape: Array) -> Force:
    """A force (m,) in N that grows in proportion to its size."""
    return lambda size: size * shape


def direction(c: RigRun, hold_share: float) -> Array:
    """sgn(eps'), shape (m,), while moving; in a hold the share of the friction that stays locked in."""
    return np.where(c.moving != 0, c.moving, hold_share * c.heading)


def speed_mm_s(c: RigRun) -> Array:
    """|v| (mm/s), shape (m,)."""
    return np.abs(c.rate) * c.length_mm


def coulomb_sign(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """-F_c sgn(eps'), half of it left in the holds."""
    return {"hold_share": 0.5}, scaled(-direction(c, 0.5))


def coulomb_tanh(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """-F_c tanh(v/v0): smooth through zero, nothing left in a hold."""
    v0 = rng.uniform(0.2, 0.8)
    return {"v0_mm_s": v0}, scaled(-np.tanh(c.rate * c.length_mm / v0))


def coulomb_two_levels(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Different level in the two directions."""
    skew, share = rng.uniform(0.1, 0.3), rng.uniform(0.3, 1.0)
    s = direction(c, share)
    return {"skew": skew, "hold_share": share}, scaled(-s * (1 + skew * np.sign(s)))


def coulomb_relaxing(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Locked in a hold, and partly let go with time."""
    tau, loss = rng.uniform(0.5, 3.0), rng.uniform(0.2, 0.5)
    left = 1 - loss * -np.expm1(-c.since_stop() / tau)
    return {"tau_s": tau, "loss": loss}, scaled(-direction(c, 1.0) * left)


def _stribeck(
    c: RigRun, rng: np.random.Generator, fall: Callable[[Array], Array], share: float
) -> tuple[Settings, Force]:
    peak, vs = rng.uniform(1.7, 2.6), float(np.exp(rng.uniform(np.log(3.0), np.log(15.0))))
    level = 1 + (peak - 1) * fall(speed_mm_s(c) / vs)
    level = np.where(c.moving != 0, level, 1.0)
    return {"peak": peak, "vs_mm_s": vs, "hold_share": share}, scaled(-level * direction(c, share))


def stribeck_gauss(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """-[F_c + (F_s - F_c) exp(-(v/v_s)^2)] sgn."""
    return _stribeck(c, rng, lambda u: np.exp(-(u**2)), 0.5)


def stribeck_exponential(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """exp(-v/v_s) in place of the bell (Bo and Pavelescu 1982)."""
    return _stribeck(c, rng, lambda u: np.exp(-u), rng.uniform(0.3, 1.0))


def stribeck_lorentz(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """1/(1 + (v/v_s)^2) in place of the bell (Hess and Soom 1990)."""
    return _stribeck(c, rng, lambda u: 1 / (1 + u**2), rng.uniform(0.3, 1.0))


def pressure_plain(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """-mu_f p S sgn, S constant; size in N at 0.5 MPa."""
    return {"hold_share": 0.5}, scaled(-c.pressure / 0.5 * direction(c, 0.5))


def pressure_contact_area(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """S = lateral surface of the braid, growing with contraction."""
    share = rng.uniform(0.3, 1.0)
    return {"hold_share": share}, scaled(-c.pressure / 0.5 * m.specimen.lateral_area(c.eps) * direction(c, share))


def pressure_radius(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Thread tension sets the pressing at the crossings: it goes with p r."""
    share = rng.uniform(0.3, 1.0)
    grow = m.specimen.radius(c.eps) / m.specimen.initial_radius_mm
    return {"hold_share": share}, scaled(-c.pressure / 0.5 * grow * direction(c, share))


def pressure_offset(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """The threads press a little before there is any pressure: p + p0."""
    p0, share = rng.uniform(0.02, 0.06), rng.uniform(0.3, 1.0)
    return {"p0_MPa": p0, "hold_share": share}, scaled(-(c.pressure + p0) / 0.5 * direction(c, share))


def viscous_linear(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """-B eps'; size in N at 10 mm/s."""
    return {}, scaled(-c.rate * c.length_mm / 10.0)


def viscous_power(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """-B |eps'|^n sgn, n below 1."""
    n = rng.uniform(0.5, 0.8)
    return {"n": n}, scaled(-np.sign(c.rate) * (speed_mm_s(c) / 10.0) ** n)


def viscous_pressure(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """B grows with the pressure that presses the threads together."""
    gain = rng.uniform(0.3, 1.2)
    return {"gain": gain}, scaled(-c.rate * c.length_mm / 10.0 * (1 + gain * c.pressure / 0.5))


def viscous_thinning(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Shear thinning: B v/(1 + v/v1)."""
    v1 = rng.uniform(20.0, 80.0)
    return {"v1_mm_s": v1}, scaled(-c.rate * c.length_mm / 10.0 / (1 + speed_mm_s(c) / v1))


def maxwell_slip(x: Array, reach: Array, weight: Array) -> Array:
    """Sum (m,) of spring-slider elements along x (m,), each sliding at its reach in units of x; weights add to 1."""
    out = np.zeros_like(x)
    for r, w in zip(reach, weight, strict=True):
        z = np.empty_like(x)
        now = 0.0
        for i, dx in enumerate(np.diff(x, prepend=x[0]).tolist()):
            now = min(max(now + dx, -r), r)
            z[i] = now
        out += w * z / r
    return out


def _slip(count: int) -> Form:
    def form(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
        longest = rng.uniform(0.012, 0.035)
        reach = longest * (np.arange(count) + 1) / count
        weight = rng.uniform(0.5, 1.5, count)
        shape = maxwell_slip(c.slide, reach, weight / weight.sum())
        return {"reach": longest, "elements": count}, scaled(-shape)

    form.__doc__ = f"Maxwell slip with {count} elements."
    return form


maxwell_one, maxwell_three, maxwell_eight = _slip(1), _slip(3), _slip(8)


def bouc_wen(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """dz/dx = (1 - |z|^n [gamma + beta sgn(z dx)])/reach, gamma + beta = 1."""
    reach, n, gamma = rng.uniform(0.006, 0.02), rng.uniform(1.0, 2.0), rng.uniform(0.5, 0.8)

    def slope(way: float, z: float) -> float:
        towards = way if z >= 0 else -way
        return (1 - abs(z) ** n * ((1 - gamma) + gamma * towards)) / reach

    return {"reach": reach, "n": n, "beta": gamma}, scaled(-travel_path(c.slide, 0.0, slope))


def dahl(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Dahl 1968: dz/dx = |1 - z sgn(dx)|^i / reach."""
    reach, power = rng.uniform(0.006, 0.015), rng.uniform(1.0, 1.6)
    shape = travel_path(c.slide, 0.0, lambda way, z: max(1 - z * way, 0.0) ** power / reach)
    return {"reach": reach, "power": power}, scaled(-shape)


def lugre(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Canudas de Wit 1995: z' = v - |v| z/(reach g(v)), force z/reach, g falling a little with speed."""
    reach, peak, vs = rng.uniform(0.006, 0.015), rng.uniform(1.1, 1.3), rng.uniform(3.0, 12.0)
    level = 1 + (peak - 1) * np.exp(-((speed_mm_s(c) / vs) ** 2))
    z, shape = 0.0, np.zeros_like(c.slide)
    for i, dx in enumerate(np.diff(c.slide).tolist()):
        if dx != 0.0:
            end = level[i + 1] * (1.0 if dx > 0 else -1.0)
            z = end + (z - end) * float(np.exp(-abs(dx) / (reach * level[i + 1])))
        shape[i + 1] = z
    return {"reach": reach, "peak": peak, "vs_mm_s": vs}, scaled(-shape)


def _sticking(level: Callable[[RigRun], Array]) -> Form:
    def form(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
        load, grip = c.load, level(c)
        if load is None:
            return {}, scaled(-direction(c, 1.0) * grip)

        def force(size: float) -> Array:
            ends = (m.contraction(c.pressure, load + sign * size * grip) for sign in (1.0, -1.0))
            stuck, now = np.empty_like(c.eps), 0.0
            for i, (low, high) in enumerate(zip(*(end.tolist() for end in ends), strict=True)):
                stuck[i] = now = min(max(now, low), high)
            return load - m.force(c.pressure, stuck)

        return {}, force

    form.__doc__ = (
        "Dry friction under a weight: the length stays while the pull is off the load by less than its level."
    )
    return form


sticking = _sticking(lambda c: np.ones_like(c.pressure))
sticking_pressed = _sticking(lambda c: c.pressure / np.max(c.pressure))


FORMS: dict[str, dict[str, Form]] = {
    "coulomb_friction": {
        "textbook": coulomb_sign,
        "tanh": coulomb_tanh,
        "two_levels": coulomb_two_levels,
        "relaxing_hold": coulomb_relaxing,
        "sticking": sticking,
    },
    "stribeck_friction": {
        "textbook": stribeck_gauss,
        "exponential": stribeck_exponential,
        "lorentz": stribeck_lorentz,
    },
    "pressure_friction": {
        "textbook": pressure_plain,
        "contact_area": pressure_contact_area,
        "radius": pressure_radius,
        "offset": pressure_offset,
        "sticking": sticking_pressed,
    },
    "viscous_damping": {
        "textbook": viscous_linear,
        "power": viscous_power,
        "pressure": viscous_pressure,
        "thinning": viscous_thinning,
    },
    "presliding_hysteresis": {
        "textbook": maxwell_three,
        "maxwell_1": maxwell_one,
        "maxwell_8": maxwell_eight,
        "bouc_wen": bouc_wen,
        "dahl": dahl,
        "lugre": lugre,
    },
}
