"""Every candidate's signature: how the force would change if a little of the effect were there."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from ..core import Inputs, Param
from ..effects import AddsForce, Effect, Form, ScalesForce, TransformsPressure
from ..model import Model, Term

Array = np.ndarray


@dataclass(frozen=True)
class Regressor:
    """One effect in one form at a `point` of its nonlinear parameters, around a fitted model.

    `columns` (n, k) are in N per unit of the k `linear` parameters.
    """

    effect: str
    term: Term
    point: dict[str, float]
    columns: Array
    linear: tuple[Param, ...]

    @property
    def free(self) -> int:
        """Parameters it adds to a model."""
        return len(self.linear) + len(self.point)


@dataclass(frozen=True)
class Slopes:
    """Force of a fitted model in N and its slopes over contraction ratio and pressure (MPa), shape (n,) each."""

    force: Array
    contraction: Array
    pressure: Array

    def take(self, rows: Array) -> "Slopes":
        """Those at some samples, by index (m,)."""
        return Slopes(self.force[rows], self.contraction[rows], self.pressure[rows])


def slopes(model: Model, inputs: Inputs, values: Mapping[str, float]) -> Slopes:
    """By central differences; histories are left as they are, for the shift is the same at every sample."""
    dc, dp = 1e-5, 1e-5
    force = model.force(inputs, values)

    def moved(**change: Array) -> Array:
        return model.force(replace(inputs, **change), values)

    over_c = moved(contraction=inputs.contraction + dc) - moved(contraction=inputs.contraction - dc)
    over_p = moved(pressure=inputs.pressure + dp) - moved(pressure=inputs.pressure - dp)
    return Slopes(force, over_c / (2 * dc), over_p / (2 * dp))


def regressors_at(
    effect: Effect, form: Form, points: Iterable[Mapping[str, float]], inputs: Inputs, around: Slopes
) -> list[Regressor]:
    """One form at some values of its nonlinear parameters; points where it is not finite are left out."""
    found = []
    for point in points:
        columns = signature(form, inputs, point, around)
        if np.all(np.isfinite(columns)):
            found.append(Regressor(effect.name, Term(effect, form), dict(point), columns, form.linear))
    return found


def closer(regressor: Regressor, inputs: Inputs, points: int = 41) -> list[dict[str, float]]:
    """Points around a regressor's own, one parameter at a time, as far as the neighbours on its grid."""
    found = []
    for p in _within(regressor.term.form, inputs):
        grid = np.unique(np.r_[p.grid, p.lower, p.upper])
        here = regressor.point[p.name]
        below, above = grid[grid < here - 1e-12], grid[grid > here + 1e-12]
        low, high = below[-1] if len(below) else here, above[0] if len(above) else here
        found += [{**regressor.point, p.name: float(v)} for v in np.linspace(low, high, points)]
    return found


def signature(form: Form, inputs: Inputs, point: Mapping[str, float], around: Slopes) -> Array:
    """dF/d(linear parameter) where they are neutral, shape (n, k), in N per unit."""
    columns = form.columns(inputs, point, around.force)
    if isinstance(form, AddsForce):
        return columns
    if isinstance(form, ScalesForce):
        return columns * around.force[:, None]
    if isinstance(form, TransformsPressure):
        return columns * around.pressure[:, None]
    return columns * around.contraction[:, None]


def same_around_any(form: Form) -> bool:
    """Whether a form's signature does not depend on the model that it is taken around."""
    return isinstance(form, AddsForce) and not form.uses_force


def grid(form: Form, inputs: Inputs) -> list[dict[str, float]]:
    """All combinations of the values from which a form's nonlinear parameters are searched in a record."""
    params = _within(form, inputs)
    names = [p.name for p in params]
    return [dict(zip(names, point, strict=True)) for point in product(*(p.grid or (p.start,) for p in params))]


def _within(form: Form, inputs: Inputs) -> list[Param]:
    return [p.within(inputs.seconds, inputs.interval) for p in form.nonlinear]
