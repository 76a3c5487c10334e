"""A fit done again many times, with other forces or other weights: all at once where the model allows, else singly."""

from collections.abc import Callable, Iterable, Mapping

import numpy as np

from ..core import Array, Param
from ..core.progress import steps
from . import batch
from .batch import Nodes, Refits
from .fit import Fit, picker
from .solve import nonlinear_within_bounds, solve

REACH = 10.0
"""Half the interval in which the nonlinear parameter is sought at first, in standard errors."""


def refit_forces(fit: Fit, forces: Array) -> tuple[Array, int]:
    """Fits to each column of `forces` (m, B) in N over the fit's rows: values (B, k) and how many took a solver each.

    Values are of the parameters that were not held, in the model's order; starts, weights and bounds are the fit's.
    """
    weighted = forces if fit.weights is None else forces * fit.weights[fit.rows, None]
    found = None
    interval = _interval(fit)
    if interval is not None:
        found = batch.refit_forces(_design(fit), weighted, interval)

    def alone(b: int) -> Mapping[str, float]:
        force = fit.record.force.copy()
        force[fit.rows] = forces[:, b]
        return _solve(fit, force, picker(fit.rows, fit.weights))

    return _complete(fit, found, forces.shape[1], alone)


def refit_weights(fit: Fit, block: Array, counts: Array) -> tuple[Array, int]:
    """Fits with each block of rows taken `counts` (B, blocks) times; `block` (m,) numbers those of the fit's rows.

    Returns what `refit_forces` does.
    """
    found = None
    interval = _interval(fit)
    if interval is not None:
        pick = picker(fit.rows, fit.weights)
        start = np.array([fit.values[p.name] for p in _free(fit, fit.model.linear)])
        blocks = [np.flatnonzero(block == k) for k in range(counts.shape[1])]
        found = batch.refit_weights(_design(fit), pick(fit.record.force), blocks, counts, start, interval)

    def alone(b: int) -> Mapping[str, float]:
        weights = np.ones(len(fit.record)) if fit.weights is None else fit.weights.copy()
        weights[fit.rows] *= np.sqrt(counts[b])[block]
        return _solve(fit, fit.record.force, picker(fit.rows, weights))

    return _complete(fit, found, len(counts), alone)


def _free(fit: Fit, params: Iterable[Param]) -> list[Param]:
    return [p for p in params if p.name not in fit.held]


def _nonlinear(fit: Fit) -> list[Param]:
    return _free(fit, nonlinear_within_bounds(fit.model, fit.record.inputs))


def _interval(fit: Fit) -> Nodes | None:
    """Where the one nonlinear parameter is sought; None where the model has more, or is not separable."""
    nonlinear = _nonlinear(fit)
    if not fit.model.separable or len(nonlinear) > 1:
        return None
    if not nonlinear:
        return Nodes(0.0, 0.0)
    p = nonlinear[0]
    estimate = next(e for e in fit.estimates if e.name == p.name)
    if estimate.at_bound or not np.isfinite(estimate.stderr):
        return None
    reach = REACH * estimate.stderr
    return Nodes(p.clip(estimate.value - reach), p.clip(estimate.value + reach))


def _design(fit: Fit) -> batch.Design:
    """Weighed columns of the free linear parameters and weighed fixed part at a value of the nonlinear parameter."""
    model, inputs, pick = fit.model, fit.record.inputs, picker(fit.rows, fit.weights)
    free = np.array([p.name not in fit.held for p in model.linear], bool)
    given = np.array([fit.held.get(p.name, 0.0) for p in model.linear])
    names = [p.name for p in _nonlinear(fit)]

    def design(q: float) -> tuple[Array, Array]:
        columns, fixed = model.design(inputs, {**fit.values, **dict.fromkeys(names, q)}, fit.record.force)
        return pick(columns[:, free]), pick(fixed + columns @ given)

    return design


def _solve(fit: Fit, force: Array, pick: Callable[[Array], Array]) -> Mapping[str, float]:
    return solve(fit.model, fit.record.inputs, force, pick, fit.values, held=fit.held).values


def _complete(fit: Fit, found: Refits | None, n: int, alone: Callable[[int], Mapping[str, float]]) -> tuple[Array, int]:
    """Values (n, k) in the model's order; those that left the interval or a bound are solved singly."""
    params = _free(fit, fit.model.bounded(fit.record.inputs))
    if found is None:
        values, bad = np.empty((n, len(params))), np.ones(n, bool)
    else:
        values = np.column_stack([found.linear, found.nonlinear])[:, : len(params)]
        lower, upper = (np.array([getattr(p, side) for p in params]) for side in ("lower", "upper"))
        bad = ~found.inside | np.any((values <= lower) | (values >= upper), axis=1) | ~np.isfinite(values).all(axis=1)
    for b in steps(np.flatnonzero(bad), "refitting one by one"):
        one = alone(int(b))
        values[b] = [one[p.name] for p in params]
    return values, int(bad.sum())
