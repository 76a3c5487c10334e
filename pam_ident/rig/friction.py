"""Rate and direction dependent effects: friction of several kinds, damping, hysteresis before sliding.

Every function draws the form's own constants and returns (settings, force), where force(size) is the
change of the muscle force (N) on the fine grid, shape (m,).  Friction resists the motion: it lowers the
pull while the muscle contracts and raises it while it is stretched.  Sizes in N unless said otherwise.
"""

from collections.abc import Callable

import numpy as np

from .integrate import travel_path
from .muscle import Array, RigMuscle
from .protocol import RigRun

Settings = dict[str, float]
Force = Callable[[float], Array]
Form = Callable[[RigRun, RigMuscle, np.random.Generator], tuple[Settings, Force]]
Forms = dict[str, dict[str, Form]]
"""Forms by effect and by their names."""
FORMS: Forms = {}


def form_of(known: Forms, effect: str, name: str = "textbook") -> Callable[[Form], Form]:
    """Enters the function below into the forms `known` of an effect."""

    def enter(form: Form) -> Form:
        known.setdefault(effect, {})[name] = form
        return form

    return enter


def scaled(shape: Array) -> Force:
    """A force (m,) in N that grows in proportion to its size."""
    return lambda size: size * shape


def elsewhere(c: RigRun, m: RigMuscle, pressure: Array | None = None, eps: Array | None = None) -> Array:
    """Change of force (N), shape (m,), where the muscle has another pressure (MPa) or contraction than is read."""
    there = m.force(c.pressure if pressure is None else pressure, c.eps if eps is None else eps)
    return there - m.force(c.pressure, c.eps)


def direction(c: RigRun, hold_share: float) -> Array:
    """sgn(eps'), shape (m,), while moving; in a hold the share of the friction that stays locked in."""
    return np.where(c.moving != 0, c.moving, hold_share * c.heading)


def speed_mm_s(c: RigRun) -> Array:
    """|v| (mm/s), shape (m,)."""
    return np.abs(c.rate) * c.length_mm


@form_of(FORMS, "coulomb_friction")
def coulomb_sign(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """-F_c sgn(eps'), half of it left in the holds."""
    return {"hold_share": 0.5}, scaled(-direction(c, 0.5))


@form_of(FORMS, "coulomb_friction", "tanh")
def coulomb_tanh(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """-F_c tanh(v/v0): smooth through zero, nothing left in a hold."""
    v0 = rng.uniform(0.2, 0.8)
    return {"v0_mm_s": v0}, scaled(-np.tanh(c.rate * c.length_mm / v0))


@form_of(FORMS, "coulomb_friction", "two_levels")
def coulomb_two_levels(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Different level in the two directions."""
    skew, share = rng.uniform(0.1, 0.3), rng.uniform(0.3, 1.0)
    s = direction(c, share)
    return {"skew": skew, "hold_share": share}, scaled(-s * (1 + skew * np.sign(s)))


@form_of(FORMS, "coulomb_friction", "relaxing_hold")
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


@form_of(FORMS, "stribeck_friction")
def stribeck_gauss(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """-[F_c + (F_s - F_c) exp(-(v/v_s)^2)] sgn."""
    return _stribeck(c, rng, lambda u: np.exp(-(u**2)), 0.5)


@form_of(FORMS, "stribeck_friction", "exponential")
def stribeck_exponential(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """exp(-v/v_s) in place of the bell (Bo and Pavelescu 1982)."""
    return _stribeck(c, rng, lambda u: np.exp(-u), rng.uniform(0.3, 1.0))


@form_of(FORMS, "stribeck_friction", "lorentz")
def stribeck_lorentz(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """1/(1 + (v/v_s)^2) in place of the bell (Hess and Soom 1990)."""
    return _stribeck(c, rng, lambda u: 1 / (1 + u**2), rng.uniform(0.3, 1.0))


@form_of(FORMS, "pressure_friction")
def pressure_plain(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """-mu_f p S sgn, S constant; size in N at 0.5 MPa."""
    return {"hold_share": 0.5}, scaled(-c.pressure / 0.5 * direction(c, 0.5))


@form_of(FORMS, "pressure_friction", "contact_area")
def pressure_contact_area(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """S = lateral surface of the braid, growing with contraction."""
    share = rng.uniform(0.3, 1.0)
    return {"hold_share": share}, scaled(-c.pressure / 0.5 * m.specimen.lateral_area(c.eps) * direction(c, share))


@form_of(FORMS, "pressure_friction", "radius")
def pressure_radius(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Thread tension sets the pressing at the crossings: it goes with p r."""
    share = rng.uniform(0.3, 1.0)
    grow = m.specimen.radius(c.eps) / m.specimen.initial_radius_mm
    return {"hold_share": share}, scaled(-c.pressure / 0.5 * grow * direction(c, share))


@form_of(FORMS, "pressure_friction", "offset")
def pressure_offset(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """The threads press a little before there is any pressure: p + p0."""
    p0, share = rng.uniform(0.02, 0.06), rng.uniform(0.3, 1.0)
    return {"p0_MPa": p0, "hold_share": share}, scaled(-(c.pressure + p0) / 0.5 * direction(c, share))


@form_of(FORMS, "viscous_damping")
def viscous_linear(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """-B eps'; size in N at 10 mm/s."""
    return {}, scaled(-c.rate * c.length_mm / 10.0)


@form_of(FORMS, "viscous_damping", "power")
def viscous_power(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """-B |eps'|^n sgn, n below 1."""
    n = rng.uniform(0.5, 0.8)
    return {"n": n}, scaled(-np.sign(c.rate) * (speed_mm_s(c) / 10.0) ** n)


@form_of(FORMS, "viscous_damping", "pressure")
def viscous_pressure(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """B grows with the pressure that presses the threads together."""
    gain = rng.uniform(0.3, 1.2)
    return {"gain": gain}, scaled(-c.rate * c.length_mm / 10.0 * (1 + gain * c.pressure / 0.5))


@form_of(FORMS, "viscous_damping", "thinning")
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
    """Maxwell slip with so many elements."""

    def form(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
        longest = rng.uniform(0.012, 0.035)
        reach = longest * (np.arange(count) + 1) / count
        weight = rng.uniform(0.5, 1.5, count)
        shape = maxwell_slip(c.slide, reach, weight / weight.sum())
        return {"reach": longest, "elements": count}, scaled(-shape)

    return form


for _name, _count in (("textbook", 3), ("maxwell_1", 1), ("maxwell_8", 8)):
    form_of(FORMS, "presliding_hysteresis", _name)(_slip(_count))


@form_of(FORMS, "presliding_hysteresis", "bouc_wen")
def bouc_wen(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """dz/dx = (1 - |z|^n [gamma + beta sgn(z dx)])/reach, gamma + beta = 1."""
    reach, n, gamma = rng.uniform(0.006, 0.02), rng.uniform(1.0, 2.0), rng.uniform(0.5, 0.8)

    def slope(way: float, z: float) -> float:
        towards = way if z >= 0 else -way
        return (1 - abs(z) ** n * ((1 - gamma) + gamma * towards)) / reach

    return {"reach": reach, "n": n, "beta": gamma}, scaled(-travel_path(c.slide, 0.0, slope))


@form_of(FORMS, "presliding_hysteresis", "dahl")
def dahl(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Dahl 1968: dz/dx = |1 - z sgn(dx)|^i / reach."""
    reach, power = rng.uniform(0.006, 0.015), rng.uniform(1.0, 1.6)
    shape = travel_path(c.slide, 0.0, lambda way, z: max(1 - z * way, 0.0) ** power / reach)
    return {"reach": reach, "power": power}, scaled(-shape)


@form_of(FORMS, "presliding_hysteresis", "lugre")
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
    """Dry friction under a weight: the length stays while the pull is off the load by less than its level."""

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

    return form


form_of(FORMS, "coulomb_friction", "sticking")(_sticking(lambda c: np.ones_like(c.pressure)))
form_of(FORMS, "pressure_friction", "sticking")(_sticking(lambda c: c.pressure / np.max(c.pressure)))
