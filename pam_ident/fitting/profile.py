"""Profile likelihood: how much worse the best fit gets as one parameter is moved, all others following."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..core import Array, UsageError
from .covariance import student
from .estimate import at_bound
from .fit import Fit, picker
from .solve import solve

MOST_STEPS = 40


@dataclass(frozen=True)
class Profile:
    """Deviance of a parameter at m values, in squared standard errors, with the 95 % interval it gives.

    `values`, `deviance` (m,) ascend in the value; `others` holds the other parameters there, (m,) each, and `bounded`
    for each point those that stand at a bound, from where on the curve is another model's. `low` and `high` are the
    interval; an end is NaN, and `open_` names it, where the deviance stays below the limit up to the parameter's own
    bound or for as far as was looked.
    """

    name: str
    unit: str
    values: Array
    deviance: Array
    others: Mapping[str, Array]
    bounded: tuple[tuple[str, ...], ...]
    low: float
    high: float
    limit: float
    open_: tuple[str, ...]


def profile(fit: Fit, name: str) -> Profile:
    """Profile of one fitted parameter (Bates & Watts 1988, Nonlinear Regression Analysis, ch. 6).

    The deviance is scaled so that its curvature at the fit is that of the standard error, correlation of the
    residuals included. Raises UsageError when the parameter is not one that was fitted.
    """
    fitted = [e.name for e in fit.estimates if e.name not in fit.held]
    if name not in fitted:
        raise UsageError(f"no fitted parameter {name!r} to profile; fitted are {', '.join(fitted)}")
    estimate = next(e for e in fit.estimates if e.name == name)
    walk = _Walk(fit, name)
    limit = float(student(np.array(estimate.dof))) ** 2 if math.isfinite(estimate.dof) else 4.0
    sides = [walk.outward(sign, limit) for sign in (-1.0, 1.0)]
    points = [*reversed(sides[0][0]), walk.centre, *sides[1][0]]
    (low, high), names = (side[1] for side in sides), [p.name for p in walk.params]
    return Profile(
        name,
        estimate.unit,
        np.array([p[name] for p, _ in points]),
        np.array([d for _, d in points]),
        {n: np.array([p[n] for p, _ in points]) for n in names if n != name},
        tuple(walk.stuck(p) for p, _ in points),
        low,
        high,
        limit,
        tuple(side for side, end in (("low", low), ("high", high)) if math.isnan(end)),
    )


Point = tuple[dict[str, float], float]
"""Values of all parameters, and the deviance there."""


class _Walk:
    """Steps away from a fit along one parameter, each from where the last one ended."""

    def __init__(self, fit: Fit, name: str) -> None:
        self.fit, self.name = fit, name
        self.params = fit.model.bounded(fit.record.inputs)
        self.param = next(p for p in self.params if p.name == name)
        self.pick = picker(fit.rows, fit.weights)
        self.centre: Point = (fit.values, 0.0)
        self.least = self._squares(fit.values)
        stderr = next(e.stderr for e in fit.estimates if e.name == name)
        cov = fit.covariance
        if cov is not None and name in fit.free and math.isfinite(stderr):
            self.scale = stderr**2 / float(np.sum(cov.basis[fit.free.index(name)] ** 2))
            self.step = 0.5 * stderr
        else:
            self.scale = max(self.least / max(int(fit.rows.sum()) - len(self.params), 1), 1e-300)
            self.step = 0.02 * max(abs(fit.values[name]), self.param.scale)

    def outward(self, sign: float, limit: float) -> tuple[list[Point], float]:
        """Points away from the fit until the deviance passes the limit, and where it does; NaN where it never does."""
        points, last, step = [], self.centre, self.step
        for _ in range(MOST_STEPS):
            value = self.param.clip(last[0][self.name] + sign * step)
            if value == last[0][self.name]:
                return points, math.nan
            now = self._point(value, last[0])
            if now[1] > 4.0 * limit and step > 1e-3 * self.step:
                step *= 0.5
                continue
            points.append(now)
            if now[1] > limit:
                return points, self._crossing(last, now, limit)
            if now[1] - last[1] < 0.1 * limit:
                step *= 1.7
            last = now
        return points, math.nan

    def _crossing(self, inside: Point, outside: Point, limit: float) -> float:
        from scipy.optimize import root_scalar

        a, b = inside[0][self.name], outside[0][self.name]
        passes = root_scalar(
            lambda v: self._point(v, inside[0])[1] - limit, bracket=(a, b), xtol=1e-6 * abs(b - a), maxiter=30
        )
        return float(passes.root)

    def _point(self, value: float, start: Mapping[str, float]) -> Point:
        fit = self.fit
        held = {**fit.held, self.name: value}
        values = solve(fit.model, fit.record.inputs, fit.record.force, self.pick, start, held=held).values
        return values, max(self._squares(values) - self.least, 0.0) / self.scale

    def _squares(self, values: Mapping[str, float]) -> float:
        left = self.pick(self.fit.record.force - self.fit.model.force(self.fit.record.inputs, values))
        return float(left @ left)

    def stuck(self, values: Mapping[str, float]) -> tuple[str, ...]:
        """The other parameters that stand at a bound."""
        fixed = {self.name, *self.fit.held}
        return tuple(p.name for p in self.params if p.name not in fixed and at_bound(p, values[p.name]))
