"""The catalogue of what the rig can hide, and the sizing of an effect by what the base law, fitted anew, leaves."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from . import friction, memory, statics, unknowns
from .friction import Force, Form, Settings
from .muscle import Array, RigMuscle
from .protocol import RigRun

EFFECTS: dict[str, dict[str, Form]] = {**friction.FORMS, **memory.FORMS, **statics.FORMS}
UNKNOWNS: dict[str, dict[str, Form]] = unknowns.FORMS

# The largest size that is still physics; where none is given 150 N at any one row is the limit.
LARGEST = {
    "pressure_lag": 0.1,
    "pressure_lag/orifice": 1.0,
    "threshold_pressure": 0.08,
    "series_compliance": 20.0,
    "end_taper": 0.5,
    "length_offset": 0.05,
    "wall_thickness": 3.0,
    "braid_extensibility": 1e3,
    "bladder_elasticity": 10.0,
    "mount_slip/textbook": 5.0,
    "wandering_sensor/length": 5.0,
    "thermal_softening/elastic_part": 12.0,
}
LARGEST_FORCE_N = 150.0


class TooSmall(ValueError):
    """The effect cannot leave as much as was asked for."""


@dataclass(frozen=True)
class Hidden:
    """One hidden effect: catalogue name, form, the constants drawn and its size.

    `force` (m,) is what it adds on the fine grid (N); `left_N` the rms of what is left of it at the logged
    rows after the law was refitted.
    """

    name: str
    form: str
    settings: Settings
    size: float
    force: Array
    left_N: float


def draw_hidden(
    name: str, form: str, course: RigRun, muscle: RigMuscle, rng: np.random.Generator, left_N: float
) -> Hidden:
    """Draws the form's constants and sets its size so that it leaves `left_N` after the law is refitted."""
    known = {**EFFECTS, **UNKNOWNS}
    if name not in known:
        raise ValueError(f"effect {name!r}: the rig can hide {', '.join(known)}")
    if form not in known[name]:
        raise ValueError(f"form {form!r} of {name}: the rig has {', '.join(known[name])}")
    if not left_N > 0:
        raise ValueError(f"left_N = {left_N}: ask for something above zero")
    settings, force = known[name][form](course, muscle, rng)
    size, left = _fit_size(force, course, muscle, left_N, LARGEST.get(f"{name}/{form}", LARGEST.get(name)))
    return Hidden(name, form, settings, size, force(size), left)


def carry_over(hidden: Hidden, course: RigRun, muscle: RigMuscle, rng: np.random.Generator) -> Hidden:
    """The same effect of the same size on another course; `rng` as it was when the effect was drawn."""
    _, force = {**EFFECTS, **UNKNOWNS}[hidden.name][hidden.form](course, muscle, rng)
    added = force(hidden.size)
    return replace(hidden, force=added, left_N=left_after_refit(added, course, muscle))


def left_after_refit(force: Array, course: RigRun, muscle: RigMuscle) -> float:
    """rms (N) at the rows of what the refitted law cannot take up of an added force (m,)."""
    p, eps = course.pressure[course.rows], course.eps[course.rows]
    return rms(law_residual(muscle, p, eps, muscle.force(p, eps) + force[course.rows]))


def _fit_size(
    force: Force, course: RigRun, muscle: RigMuscle, target: float, largest: float | None
) -> tuple[float, float]:
    """Finds the size by a secant on logarithms: what is left grows about as a power of the size."""
    size, last, power = (1e-3 if largest is None else largest / 100), None, 1.0
    for _ in range(16):
        now = force(size)
        left = left_after_refit(now, course, muscle)
        top = float(np.max(np.abs(now[course.rows])))
        if not np.isfinite(left) or left < 1e-9:
            break
        if abs(left / target - 1) < 0.01:
            return size, left
        if last is not None and last[0] != size:
            power = float(np.clip(np.log(left / last[1]) / np.log(size / last[0]), 0.4, 4.0))
        ceiling = size * LARGEST_FORCE_N / top if largest is None else largest
        if size >= 0.999 * ceiling and left < target:
            if left > 0.7 * target:
                return size, left
            break
        last = (size, left)
        size = min(size * float(np.clip((target / left) ** (1 / power), 0.02, 500.0)), ceiling)
    raise TooSmall(
        f"the effect does not leave {target:.2f} N: taken up by the law, not shown by this motion, or too weak"
    )


def _columns(muscle: RigMuscle, p: Array, eps: Array, bend: float) -> Array:
    """Columns (n, k) of the law's linear part, `bend` its one nonlinear parameter (mu, or k1)."""
    if muscle.law.name == "exponential_law":
        decay = np.exp(-bend * eps)
        return np.column_stack([np.ones_like(p), p, eps, p * eps, decay, p * decay])
    theta0 = np.radians(muscle.specimen.braid_angle_deg)
    shape = 3 / np.tan(theta0) ** 2 * (1 - bend * eps) ** 2 - 1 / np.sin(theta0) ** 2
    return np.column_stack([p * shape, np.ones_like(p)])


def _residual(columns: Array, force: Array) -> Array:
    scale = np.linalg.norm(columns, axis=0)
    answer = np.linalg.lstsq(columns / scale, force, rcond=None)[0]
    return force - columns / scale @ answer


def law_residual(muscle: RigMuscle, p: Array, eps: Array, force: Array) -> Array:
    """Residual (N, (n,)) of the muscle's kind of law, all parameters refitted by separable least squares."""
    low, high = (5.0, 200.0) if muscle.law.name == "exponential_law" else (0.3, 3.0)

    def loss(log_bend: float) -> float:
        return float(np.sum(_residual(_columns(muscle, p, eps, float(np.exp(log_bend))), force) ** 2))

    grid = np.linspace(np.log(low), np.log(high), 9)
    values = [loss(g) for g in grid]
    best = int(np.argmin(values))
    around = (grid[max(best - 1, 0)], grid[min(best + 1, 8)])
    found = minimize_scalar(loss, bounds=around, method="bounded", options={"xatol": 1e-7})
    return _residual(_columns(muscle, p, eps, float(np.exp(found.x))), force)  # type: ignore[attr-defined]


def rms(values: Array) -> float:
    """Root of the mean square of values of any shape."""
    return float(np.sqrt(np.mean(values**2)))
