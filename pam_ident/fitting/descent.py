"""The way down from a projection to the nearest least sum of squares, in a trust region, within bounds."""

import math
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from ..core import Array
from .problem import FLAT, Projection, bounds

if TYPE_CHECKING:
    from .readings import Reading

FIRST_STEP = 0.3
"""First radius of a trust region in units of typical sizes: a longer first step may cross a pole of the model."""
ROUGH = 1e-12
"""Share of the sum of squares that is rounding: of two that differ by less neither is known to be the smaller."""
HOPE = 4.0
"""How many times the fall that the slopes predict a search may still bring."""
GIVEN_UP = "given up"
MOST = 30
"""Steps of the last way, on which the sum of squares is rounding."""
CLOSE = 1e-11
"""Way that may be left to the minimum, in typical sizes of the parameters."""
ROUNDING = 1e-18
"""Square of a step, as a share of that of the residual, below which steps that shrink no more are rounding."""


P = TypeVar("P", Projection, "Reading")
"""Where a descent may stand: a problem's linear parameters are eliminated there, or it is read in chunks."""


def descend(start: P, ftol: float, xtol: float, evaluations: int, enough: float = math.inf) -> tuple[P, int, str]:
    """Follow a projection down in a trust region: where it ended, status (positive when it converged) and message.

    It ends when the sum of squares changes by less than `ftol` or the parameters by less than `xtol`, both relative;
    and with status −1 where there is no hope of a sum of squares below `enough`.
    """
    if len(start.q) == 1:
        return _descend_line(start, ftol, xtol, evaluations, enough)
    unit = FIRST_STEP * np.array([p.typical(x) for p, x in zip(start.problem.nonlinear, start.q, strict=True)])
    lower, upper = bounds(start.problem.nonlinear)
    here, radius = start, 1.0
    for _ in range(evaluations):
        slopes = here.jacobian * unit
        triangle: Array = np.linalg.qr(slopes, mode="r")  # pyright: ignore
        gradient = slopes.T @ here.residual
        if here.cost - HOPE * _fall(triangle, gradient) > enough:
            return here, -1, GIVEN_UP
        step = _trusted_step(triangle, gradient, (lower - here.q) / unit, (upper - here.q) / unit, radius)
        length = float(np.linalg.norm(step))
        if length <= xtol:
            return here, 1, "the step is small"
        trial = start.problem.at(np.clip(here.q + step * unit, lower, upper))
        fall = here.cost - trial.cost
        promised = -float(2.0 * gradient @ step + np.sum((triangle @ step) ** 2))
        if fall < 0.25 * promised:
            radius = 0.25 * length
        elif fall > 0.75 * promised and length > 0.95 * radius:
            radius *= 2.0
        if not fall > 0.0:
            continue
        here = trial
        if fall <= ftol * here.cost and fall >= 0.25 * promised:
            return here, 1, "the sum of squares falls no more"
    return here, 0, "the maximum number of evaluations was reached"


def settle(here: P) -> tuple[P, Array, bool]:
    """Follow the gradient on to the minimum, where the sum of squares falls by no more than its rounding: where it
    stands, the step (k,) from there to the end, which is left to take, and whether that is the minimum.

    Near it each step is shorter than the one before by a rate, which with the step's size tells what is left.
    """
    nothing = np.zeros(len(here.q))
    lower, upper = bounds(here.problem.nonlinear)
    typical = np.array([p.typical(x) for p, x in zip(here.problem.nonlinear, here.q, strict=True)])
    before = math.inf
    for _ in range(MOST):
        triangle: Array = np.linalg.qr(here.jacobian * typical, mode="r")  # pyright: ignore
        gradient = typical * (here.jacobian.T @ here.residual)
        if not gradient.any():
            return here, nothing, True
        step = _trusted_step(triangle, gradient, (lower - here.q) / typical, (upper - here.q) / typical, before)
        size = float(np.max(np.abs(step)))
        rate = size / before if math.isfinite(before) else 1.0
        end = np.clip(here.q + step * typical, lower, upper)
        rounding = rate > 0.8 and float(np.sum((triangle @ step) ** 2)) <= ROUNDING * here.cost
        if rounding or (size * rate / (1.0 - rate) if rate < 1.0 else size) <= CLOSE:
            return here, end - here.q, True
        trial = here.problem.at(end)
        if not (rate <= 1.0 and trial.cost <= here.cost * (1.0 + ROUGH)):
            return here, nothing, False
        here, before = trial, size
    return here, nothing, False


def _fall(triangle: Array, gradient: Array) -> float:
    """By how much the sum of squares would fall if the residual were linear, without bounds."""
    along = np.linalg.lstsq(triangle.T, gradient, rcond=FLAT)[0]
    return float(along @ along)


def _trusted_step(triangle: Array, gradient: Array, low: Array, high: Array, radius: float) -> Array:
    """s (k,) within `low` … `high` and no longer than `radius` for which gradient · s + |triangle · s|²/2 is least.

    What would leave its bounds is put on them, one after the other; what stands there and is driven out stays.
    """
    step = np.zeros(len(gradient))
    free = ~(((low >= 0.0) & (gradient > 0.0)) | ((high <= 0.0) & (gradient < 0.0)))
    while free.any():
        rest = math.sqrt(max(radius**2 - float(step @ step), 1e-12 * radius**2))
        pull = gradient + triangle.T @ (triangle @ step)
        wish = _step_within(triangle[:, free], pull[free], rest)
        held = np.clip(wish, low[free], high[free])
        out = held != wish
        if not out.any():
            step[free] = wish
            break
        places = np.flatnonzero(free)[out]
        step[places] = held[out]
        free[places] = False
    return step


def _step_within(triangle: Array, gradient: Array, radius: float) -> Array:
    """The same without bounds: Moré & Sorensen 1983, SIAM J. Sci. Stat. Comput. 4, 553–572, in singular directions."""
    _, sigma, axes = np.linalg.svd(triangle, full_matrices=False)
    along = axes @ gradient
    along[sigma <= FLAT * sigma[0]] = 0.0
    square = np.maximum(sigma**2, max(float(sigma[0]) ** 2 * FLAT**2, 1e-300))
    damping, step = 0.0, along / square
    length = float(np.linalg.norm(step))
    for _ in range(50):
        if length <= (1.01 if damping > 0.0 else 1.0) * radius:
            break
        bend = float(np.sum(step**2 / (square + damping)))
        damping += (length / max(radius, 1e-300) - 1.0) * length**2 / bend
        step = along / (square + damping)
        length = float(np.linalg.norm(step))
    return -(axes.T @ step) * min(1.0, radius / max(length, 1e-300))


def _descend_line(start: P, ftol: float, xtol: float, evaluations: int, enough: float) -> tuple[P, int, str]:
    """As `descend` for one nonlinear parameter: Newton's steps on the exact gradient, bend by secants, in a radius.

    Most laws have just one.
    """
    p, here = start.problem.nonlinear[0], start
    slopes = here.jacobian[:, 0]
    gradient, bend = float(slopes @ here.residual), float(slopes @ slopes)
    radius = FIRST_STEP * p.typical(float(start.q[0]))
    for _ in range(evaluations):
        q = float(here.q[0])
        if bend > 0.0 and here.cost - HOPE * gradient**2 / bend > enough:
            return here, -1, GIVEN_UP
        wish = -gradient / bend if bend > 0.0 else 0.0
        step = p.clip(q + min(max(wish, -radius), radius)) - q
        if abs(step) <= xtol * p.typical(q):
            return here, 1, "the step is small"
        trial = start.problem.at(np.array([q + step]))
        fall = here.cost - trial.cost
        if not fall > 0.0:
            radius = 0.25 * abs(step)
            continue
        slopes = trial.jacobian[:, 0]
        slope, bend = float(slopes @ trial.residual), float(slopes @ slopes)
        secant = (slope - gradient) / step
        bend = secant if 0.1 * bend < secant < 10.0 * bend else bend
        radius = max(radius, 2.0 * abs(step))
        here, gradient = trial, slope
        if fall <= ftol * here.cost:
            return here, 1, "the sum of squares falls no more"
    return here, 0, "the maximum number of evaluations was reached"
