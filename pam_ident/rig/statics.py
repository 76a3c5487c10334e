"""Effects of the static characteristic: bladder, braid, ends, fixture, threshold, offsets.

Same signature as in friction.py.  They act at a given pressure and contraction whatever came before.
"""

from collections.abc import Callable

import numpy as np

from .friction import Force, Forms, Settings, elsewhere, form_of, scaled
from .muscle import Array, RigMuscle, RigSpecimen
from .protocol import RigRun

FORMS: Forms = {}


def elastic_force(specimen: RigSpecimen, energy: Callable[[Array, Array], Array], eps: Array) -> Array:
    """Virtual work: F_t = (1/L0) dU/d(eps), (m,) in N, taken off the pull, of an energy density W in MPa.

    W is a function of hoop and axial stretch, and U is W times the rubber's volume 2 pi r0 L0 t; the
    derivative is a fourth-order central difference.
    """
    volume = 2 * np.pi * specimen.initial_radius_mm * specimen.initial_length_mm * specimen.wall_thickness_mm

    def stored(e: Array) -> Array:
        return volume * energy(specimen.radius(e) / specimen.initial_radius_mm, 1 - e)

    h = 1e-3
    slope = (8 * (stored(eps + h) - stored(eps - h)) - (stored(eps + 2 * h) - stored(eps - 2 * h))) / (12 * h)
    return slope / specimen.initial_length_mm


@form_of(FORMS, "bladder_elasticity")
def bladder_hoop(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Hoop energy in closed form, F_t = (2a/3) pi r0 t E (1 - eps)(1 - r0/r); size E in MPa."""
    s = m.specimen
    a = 3 / np.tan(np.radians(s.braid_angle_deg)) ** 2
    front = 2 * a / 3 * np.pi * s.initial_radius_mm * s.wall_thickness_mm
    return {}, scaled(-front * (1 - c.eps) * (1 - s.initial_radius_mm / s.radius(c.eps)))


@form_of(FORMS, "bladder_elasticity", "mooney_rivlin")
def bladder_mooney(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Incompressible Mooney-Rivlin tube, thinned as it widens; size 6 (C1 + C2) = E in MPa."""
    share = rng.uniform(0.0, 0.35)

    def energy(hoop: Array, axial: Array) -> Array:
        wall = 1 / (hoop * axial)
        first = hoop**2 + axial**2 + wall**2 - 3
        second = hoop**-2 + axial**-2 + wall**-2 - 3
        return ((1 - share) * first + share * second) / 6

    return {"C2_share": share}, scaled(-elastic_force(m.specimen, energy, c.eps))


@form_of(FORMS, "bladder_elasticity", "gent")
def bladder_gent(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Gent 1996: -(mu/2) Jm log(1 - (I1 - 3)/Jm), chains run out of stretch; size 3 mu = E in MPa."""
    jm = rng.uniform(4.0, 12.0)

    def energy(hoop: Array, axial: Array) -> Array:
        first = hoop**2 + axial**2 + (hoop * axial) ** -2 - 3
        return -jm / 6 * np.log(1 - np.minimum(first / jm, 0.95))

    return {"Jm": jm}, scaled(-elastic_force(m.specimen, energy, c.eps))


@form_of(FORMS, "threshold_pressure")
def threshold_hard(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """p -> max(p - p_th, 0); size p_th in MPa."""
    return {}, lambda size: elsewhere(c, m, np.maximum(c.pressure - size, 0.0))


@form_of(FORMS, "threshold_pressure", "soft")
def threshold_soft(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """p -> w log(1 + exp((p - p_th)/w)): the bladder meets the braid bit by bit."""
    w = rng.uniform(0.01, 0.03)
    return {"width_MPa": w}, lambda size: elsewhere(c, m, w * np.logaddexp(0.0, (c.pressure - size) / w))


@form_of(FORMS, "threshold_pressure", "rational")
def threshold_rational(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """p -> p^2/(p + p_th)."""
    return {}, lambda size: elsewhere(c, m, c.pressure**2 / (c.pressure + size))


@form_of(FORMS, "threshold_pressure", "stretching")
def threshold_stretching(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """The wider the braid, the more the bladder must be stretched to touch it: p_th grows along the stroke."""
    growth = rng.uniform(0.2, 0.6) / float(c.eps.max())
    return {"growth": growth}, lambda size: elsewhere(c, m, np.maximum(c.pressure - size * (1 + growth * c.eps), 0.0))


def _given_way(c: RigRun, m: RigMuscle, give: Callable[[Array], Array]) -> Array:
    """Solves eps_m = eps + give(F(p, eps_m)) and returns the change of force."""
    eps = c.eps.copy()
    for _ in range(60):
        eps = 0.3 * eps + 0.7 * (c.eps + give(m.force(c.pressure, eps)))
    return elsewhere(c, m, eps=eps)


@form_of(FORMS, "series_compliance")
def compliance_linear(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Fixture of stiffness K in series: eps_m = eps + F/(K L0); size 1/K in mm/kN."""
    return {}, lambda size: _given_way(c, m, lambda f: size * 1e-3 * f / c.length_mm)


@form_of(FORMS, "series_compliance", "contact")
def compliance_contact(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Hertzian seat: the give goes with F^(2/3)."""
    return {}, lambda size: _given_way(c, m, lambda f: size * (np.maximum(f, 0.0) / 1e3) ** (2 / 3) / c.length_mm)


@form_of(FORMS, "series_compliance", "stiffening")
def compliance_stiffening(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Clevis play and threads that bed in: F/(1 + F/F1), F1 0.8..2 kN."""
    f1 = rng.uniform(800.0, 2000.0)

    def give(size: float) -> Callable[[Array], Array]:
        return lambda f: size * 1e-3 * f / (1 + np.maximum(f, 0.0) / f1) / c.length_mm

    return {"F1_N": f1}, lambda size: _given_way(c, m, give(size))


@form_of(FORMS, "wall_thickness")
def wall_thick(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Chou and Hannaford's thick wall: pi p [D90 t (2 sin - 1/sin) - t^2]; size t in mm."""
    sine0 = np.sin(np.radians(m.specimen.braid_angle_deg))
    sine = np.sqrt(1 - m.specimen.cosine(c.eps) ** 2)
    d90 = 2 * m.specimen.initial_radius_mm / sine0
    return {}, lambda t: np.pi * c.pressure * (d90 * t * (2 * sine - 1 / sine) - t**2)


@form_of(FORMS, "end_taper")
def taper_scale(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """eps -> (1 + size) eps: the ends do not contract."""
    return {}, lambda size: elsewhere(c, m, eps=(1 + size) * c.eps)


@form_of(FORMS, "end_taper", "saturating")
def taper_saturating(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """The scale fades with contraction: eps (1 + size exp(-eps/eps1))."""
    fade = rng.uniform(0.05, 0.15)
    return {"eps1": fade}, lambda size: elsewhere(c, m, eps=c.eps * (1 + size * np.exp(-c.eps / fade)))


@form_of(FORMS, "length_offset")
def offset_length(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """eps -> eps - size."""
    return {}, lambda size: elsewhere(c, m, eps=c.eps - size)


@form_of(FORMS, "braid_extensibility")
def braid_stretch(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """-4 pi^2 r0^4 p^2 cos/(sin^4 EA), the sine at rest; size 1e6/EA in 1/N."""
    cos = m.specimen.cosine(c.eps)
    shape = cos / (1 - m.specimen.cosine(np.zeros(1)) ** 2) ** 2
    return {}, scaled(-4e-6 * np.pi**2 * m.specimen.initial_radius_mm**4 * c.pressure**2 * shape)


@form_of(FORMS, "force_bias")
def bias_constant(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Load cell off zero; size in N."""
    return {}, scaled(np.ones_like(c.eps))
