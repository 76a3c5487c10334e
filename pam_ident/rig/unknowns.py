"""What no catalogue of muscle effects holds: faults of the rig, in four kinds that a record can show, and more.

`screw_ripple` repeats itself, `rub` sits at one place of the stroke, `mount_slip` happens at one moment,
`wandering_sensor` goes on from the first sample to the last. `dynamics` is the rig's own: masses, sticking, shaking.
Same signature as in friction.py; sizes in N.
"""

import numpy as np

from .friction import Force, Form, Forms, Settings, direction, elsewhere, form_of, scaled
from .muscle import Array, RigMuscle
from .protocol import RigRun

FORMS: Forms = {}


def _phase(rng: np.random.Generator) -> float:
    return rng.uniform(0.0, 2 * np.pi)


@form_of(FORMS, "screw_ripple")
def ripple_sine(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Once a turn of the spindle, pitch 2..10 mm."""
    pitch, at = rng.uniform(2.0, 10.0), _phase(rng)
    return {"pitch_mm": pitch}, scaled(np.sin(2 * np.pi * c.eps * c.length_mm / pitch + at))


@form_of(FORMS, "screw_ripple", "loaded")
def ripple_loaded(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """The same, growing with the load."""
    pitch, at = rng.uniform(2.0, 10.0), _phase(rng)
    load = m.force(c.pressure, c.eps)
    return {"pitch_mm": pitch}, scaled(np.sin(2 * np.pi * c.eps * c.length_mm / pitch + at) * load / np.max(load))


@form_of(FORMS, "screw_ripple", "harmonics")
def ripple_harmonics(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """A worn thread: the pitch and its second harmonic."""
    pitch, at, more = rng.uniform(4.0, 10.0), _phase(rng), rng.uniform(0.3, 0.7)
    turn = 2 * np.pi * c.eps * c.length_mm / pitch + at
    return {"pitch_mm": pitch, "second": more}, scaled(np.sin(turn) + more * np.sin(2 * turn + 1.0))


def _beat(shortest_s: float, longest_s: float) -> Form:
    """A load cell that is shaken, periodic in time, whatever the muscle does."""

    def form(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
        period, at = rng.uniform(shortest_s, longest_s), _phase(rng)
        return {"period_s": period}, scaled(np.sin(2 * np.pi * c.time / period + at))

    return form


# Mains beating against the sampling.
form_of(FORMS, "screw_ripple", "beat_in_time")(_beat(5.0, 40.0))


@form_of(FORMS, "screw_ripple", "pump")
def pump_ripple(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """The compressor starts and stops: a pressure wave in the muscle that the damped gauge hides."""
    period, at = rng.uniform(10.0, 60.0), _phase(rng)
    return {"period_s": period}, scaled(_pull_of_pressure(c, m) * np.sin(2 * np.pi * c.time / period + at))


# A machine next door, faster than slow strokes show.
form_of(FORMS, "screw_ripple", "hum")(_beat(0.8, 5.0))


def _place(c: RigRun, rng: np.random.Generator) -> tuple[float, float]:
    """Centre and half width (contraction) of a bump inside the middle strokes."""
    top = float(np.median([c.eps[c.isobar == i].max() for i in np.unique(c.isobar)]))
    return top * rng.uniform(0.3, 0.7), top * rng.uniform(0.05, 0.12)


def _bump(c: RigRun, centre: float, width: float, shape: str) -> Array:
    u = (c.eps - centre) / width
    if shape == "gaussian":
        return np.exp(-0.5 * u**2)
    inside = np.abs(u) < 1
    return inside * (1.0 if shape == "box" else 0.5 * (1 + np.cos(np.pi * u)))


def _rub(shape: str, odd: bool) -> Form:
    """Something rubs or catches at one place."""

    def form(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
        centre, width = _place(c, rng)
        way = -direction(c, 0.5) if odd else -1.0
        return {"centre": centre, "width": width}, scaled(way * _bump(c, centre, width, shape))

    return form


form_of(FORMS, "rub")(_rub("gaussian", False))
form_of(FORMS, "rub", "gaussian_odd")(_rub("gaussian", True))
form_of(FORMS, "rub", "box")(_rub("box", False))
form_of(FORMS, "rub", "cosine_odd")(_rub("cosine", True))


@form_of(FORMS, "rub", "two_places")
def two_rubs(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """A second place, weaker."""
    first, width = _place(c, rng)
    second, weight = 0.4 * first, rng.uniform(0.4, 0.8)
    shape = _bump(c, first, width, "gaussian") + weight * _bump(c, second, width, "gaussian")
    return {"centre": first, "second": second, "width": width}, scaled(-shape)


@form_of(FORMS, "rub", "end_stop")
def end_stop(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """A soft stop met late in the longest strokes: a kink, then a slope."""
    at = float(c.eps.max()) * rng.uniform(0.7, 0.85)
    return {"from": at}, scaled(-np.maximum(c.eps - at, 0.0) / 0.01)


@form_of(FORMS, "rub", "fold")
def fold_snaps(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """A fold of the bladder opens at one contraction and closes there again: the force jumps, within a thousandth."""
    at = rng.uniform(0.3, 0.6) * float(c.eps.max())
    return {"at": at}, scaled(0.5 * (1 + np.tanh((c.eps - at) / 1e-3)))


@form_of(FORMS, "rub", "leaned_on")
def leaned_on(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Somebody leans on the bench for a while: one place in time."""
    when, long = _moment(c, rng), rng.uniform(0.01, 0.03) * float(c.time[-1])
    return {"time_s": when, "long_s": long}, scaled(np.exp(-0.5 * ((c.time - when) / long) ** 2))


def _moment(c: RigRun, rng: np.random.Generator) -> float:
    return float(c.time[c.rows[int(rng.uniform(0.25, 0.75) * len(c.rows))]])


@form_of(FORMS, "mount_slip")
def slip_length(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """The mount slips: from then on the true contraction differs from the measured; size in mm."""
    when = _moment(c, rng)
    after = c.time >= when
    return {"time_s": when}, lambda size: after * elsewhere(c, m, eps=c.eps - size / c.length_mm)


@form_of(FORMS, "mount_slip", "load")
def slip_load(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """The load cell's zero jumps."""
    when = _moment(c, rng)
    return {"time_s": when}, scaled((c.time >= when) * float(rng.choice([-1.0, 1.0])))


@form_of(FORMS, "mount_slip", "and_back")
def slip_and_back(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """The zero jumps and jumps back after a tenth to a quarter of the record."""
    when = _moment(c, rng)
    until = when + rng.uniform(0.1, 0.25) * float(c.time[-1])
    return {"time_s": when, "until_s": until}, scaled(1.0 * ((c.time >= when) & (c.time < until)))


@form_of(FORMS, "mount_slip", "gauge")
def gauge_jump(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """The pressure gauge's zero jumps, so that the muscle holds another pressure from then on; size in N."""
    when = _moment(c, rng)
    return {"time_s": when}, scaled((c.time >= when) * _pull_of_pressure(c, m))


@form_of(FORMS, "mount_slip", "cell")
def cell_jump(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """The load cell's sensitivity jumps; size its relative change."""
    when = _moment(c, rng)
    return {"time_s": when}, scaled((c.time >= when) * float(rng.choice([-1.0, 1.0])) * m.force(c.pressure, c.eps))


def _pull_of_pressure(c: RigRun, m: RigMuscle) -> Array:
    slope = m.pressure_slope(c.pressure, c.eps)
    return slope / float(np.max(np.abs(slope)))


def _wandering(c: RigRun, rng: np.random.Generator) -> Array:
    """From 0 at the first sample to 1 or −1 at the last, shape (m,)."""
    return float(rng.choice([-1.0, 1.0])) * c.time / c.time[-1]


@form_of(FORMS, "wandering_sensor")
def wandering_zero(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """The pressure gauge's zero wanders, and the true pressure with it."""
    return {}, scaled(_wandering(c, rng) * _pull_of_pressure(c, m))


@form_of(FORMS, "wandering_sensor", "gain")
def wandering_gain(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """The same of the pressure gauge's sensitivity."""
    pull = c.pressure / float(np.max(c.pressure)) * _pull_of_pressure(c, m)
    return {}, scaled(_wandering(c, rng) * pull)


@form_of(FORMS, "wandering_sensor", "length")
def wandering_length(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """The clamp creeps: the true contraction moves away from the measured; size in mm by the end."""
    away = _wandering(c, rng) / c.length_mm
    return {}, lambda size: elsewhere(c, m, eps=c.eps - size * away)


@form_of(FORMS, "wandering_sensor", "cell")
def wandering_cell(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """The load cell's sensitivity wanders; size its relative change by the end."""
    return {}, scaled(_wandering(c, rng) * m.force(c.pressure, c.eps))


@form_of(FORMS, "wandering_sensor", "tiring")
def tiring(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Something beside the muscle softens all the while: a stiffness that grows or falls with time."""
    return {}, scaled(_wandering(c, rng) * c.eps / float(c.eps.max()))


@form_of(FORMS, "dynamics", "moving_mass")
def moving_mass(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """A mass between muscle and load cell: the force of its acceleration."""
    acceleration = np.gradient(c.rate, c.time + 1e-9 * np.arange(len(c.time)))
    acceleration = np.where(c.moving != 0, acceleration, 0.0)
    return {}, scaled(-acceleration / float(np.sqrt(np.mean(acceleration[c.rows] ** 2))))


def _along(c: RigRun) -> Array:
    """Way in mm since the stroke began, shape (m,)."""
    step = np.abs(np.diff(c.slide, prepend=c.slide[0])) * c.length_mm
    whole = np.cumsum(step)
    began = np.r_[True, np.diff(c.heading) != 0]
    return whole - np.maximum.accumulate(np.where(began, whole, 0.0))


@form_of(FORMS, "dynamics", "stick_slip")
def stick_slip(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Sticking and letting go: a sawtooth against the motion, each tooth a few mm long."""
    tooth = rng.uniform(2.0, 6.0)
    saw = _along(c) / tooth % 1.0
    return {"tooth_mm": tooth}, scaled(-np.where(c.moving != 0, c.moving, 0.5 * c.heading) * (0.5 + saw))


@form_of(FORMS, "dynamics", "windage")
def windage(c: RigRun, m: RigMuscle, rng: np.random.Generator) -> tuple[Settings, Force]:
    """Fast strokes shake the bench: a force that follows the square of the speed, whichever way it goes."""
    return {}, scaled((c.rate / float(np.max(np.abs(c.rate)))) ** 2)
