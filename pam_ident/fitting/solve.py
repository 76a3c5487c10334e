"""A model and a force record as a least-squares problem, and its solution."""

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache

import numpy as np

from ..core import Array, Inputs
from ..effects import Form
from ..model import Model
from .descent import GIVEN_UP
from .problem import Problem, Solution, Whiten, all_rows
from .solvers import QUICK, Solver, VariableProjection

ACTING = 1.03
"""How much larger the sum of squares may be before the force acts back as the model's own, not as measured."""

NUDGE_N = 1e-3
"""Step of the force itself in central differences."""


def solve(
    model: Model,
    inputs: Inputs,
    force: Array,
    whiten: Whiten,
    start: Mapping[str, float] | None = None,
    quick: bool = False,
    held: Mapping[str, float] | None = None,
    solver: Solver | None = None,
    enough: float = math.inf,
) -> Solution:
    """Least squares of whiten(model − force), force (n,) in N, over the model's parameters, within their bounds.

    Curved parameters start from `start` where it names them, else from every combination of their grids, the two best
    of which are followed down. `quick` follows one and stops at 1e-8, or before that, not converged, where there is no
    hope of a sum of squares below `enough`. Parameters in `held` stay at their values. `solver` takes the place of
    variable projection. Raises UsageError where `held` names no parameter of the model.
    """
    held = dict(held or {})
    if solver is None:
        hope = enough if model.separable else ACTING * enough
        solver = replace(QUICK, enough=hope) if quick else VariableProjection()

    def search(problem: Problem, by: Solver) -> Solution:
        found = by.solve(problem.holding(**held))
        return replace(found, values=found.values | held)

    problem = separated(model, inputs, force, start or {}, whiten)
    if model.separable:
        return search(problem, solver)
    model = _remembering(model, inputs)
    near = replace(solver, polish=False) if isinstance(solver, VariableProjection) else solver
    found = search(problem, near)
    if found.message == GIVEN_UP:
        return found
    for _ in range(2):
        acting = np.clip(model.force(inputs, found.values), -1e6, 1e6)
        found = search(separated(model, inputs, force, found.values, whiten, acting), near)
    return found if quick else search(whole(model, inputs, force, found.values, whiten), solver)


def separated(
    model: Model,
    inputs: Inputs,
    force: Array,
    start: Mapping[str, float],
    whiten: Whiten = all_rows,
    acting: Array | None = None,
) -> Problem:
    """The separable problem while the force that effects are given stays `acting` (n,) in N, default the measured."""
    acting = force if acting is None else acting
    model = _remembering(model, inputs, acting)
    guess = model.neutral(inputs)
    nonlinear = [replace(p, start=p.clip(guess[p.name])) for p in model.bounded(inputs)[len(model.linear) :]]

    def design(values: Mapping[str, float]) -> tuple[Array, Array]:
        return model.design(inputs, values, acting)

    return Problem(model.linear, tuple(nonlinear), design, force, start, whiten)


def _remembering(model: Model, inputs: Inputs, acting: Array | None = None) -> Model:
    """The same model, whose effects keep their columns at these inputs while only other parameters move; those that
    are given the force only where it is `acting` (n,) in N."""
    force = np.zeros(len(inputs)) if acting is None else acting

    def remembering(form: Form) -> Form:
        names = [p.name for p in form.nonlinear]

        @lru_cache(maxsize=4)
        def at(*shape: float) -> Array:
            return form.columns(inputs, dict(zip(names, shape, strict=True)), force)

        def columns(given: Inputs, shape: Mapping[str, float], now: Array) -> Array:
            if given is inputs and (now is force or not form.uses_force):
                return at(*(shape[name] for name in names))
            return form.columns(given, shape, now)

        return replace(form, columns=columns)

    return replace(model, terms=tuple(replace(term, form=remembering(term.form)) for term in model.terms))


def whole(model: Model, inputs: Inputs, force: Array, start: Mapping[str, float], whiten: Whiten = all_rows) -> Problem:
    """All parameters as nonlinear ones, for models in which the force, (n,) in N, acts back on itself.

    Where it does so at once, G(F, θ) = F, its slopes are ∂G/∂θ / (1 − ∂G/∂F).
    """
    model, near = _remembering(model, inputs), force

    def solved(values: Mapping[str, float]) -> Array:
        nonlocal near
        found = model.force(inputs, values, near)
        if np.all(np.isfinite(found)):
            near = found
        return found

    def design(values: Mapping[str, float]) -> tuple[Array, Array]:
        return np.empty((len(inputs), 0)), solved(values)

    def slopes(values: Mapping[str, float]) -> Array:
        acting, linear = solved(values), np.array([values[p.name] for p in model.linear])

        def given(force: Array) -> Array:
            columns, fixed = model.design(inputs, values, force)
            return fixed + columns @ linear

        back = 1.0 - (given(acting + NUDGE_N) - given(acting - NUDGE_N)) / (2.0 * NUDGE_N)
        alone = separated(model, inputs, force, {}, acting=acting).jacobian(values)
        return np.where(back[:, None] > 0.0, alone / np.where(back > 0.0, back, 1.0)[:, None], 0.0)

    at_once = not any(term.form.uses_force and term.form.remembers for term in model.terms)
    return Problem((), model.bounded(inputs), design, force, start, whiten, slopes=slopes if at_once else None)


def table(model: Model, inputs: Inputs, values: Mapping[str, float], force: Array, whiten: Whiten = all_rows) -> Array:
    """dF/dparameter in N per unit at `values`, nonlinear ones by central differences, and as last column what the model
    says beyond `force` (n,) in N, all whitened: shape (m, len(params) + 1)."""
    make = separated if model.separable else whole
    return make(model, inputs, force, {}, whiten).table(values)


def jacobian(model: Model, inputs: Inputs, values: Mapping[str, float], force: Array) -> Array:
    """The slopes of that alone, at all samples, shape (n, len(params))."""
    return table(model, inputs, values, force)[:, :-1]
