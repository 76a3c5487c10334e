"""A fit done again many times, with other forces or other weights: all at once where the model allows, else singly.

All at once, thousands cost what a few do. With the linear parameters eliminated (Golub & Pereyra 1973, SIAM J. Numer.
Anal. 10, 413–432) the cost is a smooth function of the one nonlinear parameter that is left. It is taken at Chebyshev
nodes around the fit, for all refits at once, and its minimum is found on the interpolating polynomials.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev

from ..core import Array, Param
from ..core.progress import steps
from .fit import Fit, picker
from .problem import bounds, norms
from .solve import solve

REACH = 10.0
"""Half the interval in which the nonlinear parameter is sought at first, in standard errors."""
Design = Callable[[float], tuple[Array, Array]]
"""Columns (n, k) and fixed part (n,) of a model at a value of its nonlinear parameter."""
_Refits = tuple[Array, Array]
"""B refits: linear parameters and the nonlinear one (B, k + 1), and which of them ended inside the interval (B,)."""
COUNT = 16
"""Nodes that carry the cost over ten standard errors to both sides to rounding."""


@dataclass(frozen=True)
class _Nodes:
    """Values of the nonlinear parameter at COUNT Chebyshev nodes of low … high; where these are equal it is given."""

    low: float
    high: float

    @property
    def points(self) -> Array:
        """The nodes in −1 … 1, shape (COUNT,)."""
        return np.cos(np.pi * (np.arange(COUNT) + 0.5) / COUNT)

    def at(self, x: Array) -> Array:
        """Curved parameter at x in −1 … 1, of the shape of x."""
        return 0.5 * (self.low + self.high) + 0.5 * (self.high - self.low) * x

    def series(self, values: Array) -> Array:
        """Chebyshev coefficients (COUNT, B) of values (COUNT, B) at the nodes."""
        halves = np.r_[0.5, np.ones(COUNT - 1)][:, None]
        return 2.0 / COUNT * halves * (chebyshev.chebvander(self.points, COUNT - 1).T @ values)

    def weights(self, x: Array) -> Array:
        """Weights (COUNT, B) that interpolate values at the nodes at x (B,)."""
        return self.series(np.eye(COUNT)).T @ chebyshev.chebvander(x, COUNT - 1).T

    def minimum(self, cost: Array) -> tuple[Array, Array]:
        """Where in −1 … 1 each interpolated column of `cost` (COUNT, B) is least, and whether that is to be trusted:
        a minimum, inside, of a series that has died away."""
        if self.low == self.high:
            return np.zeros(cost.shape[1]), np.ones(cost.shape[1], bool)
        poly = self.series(cost)
        slope, bend = chebyshev.chebder(poly), chebyshev.chebder(poly, 2)
        x = self.points[np.argmin(cost, axis=0)]
        step = np.zeros_like(x)
        for _ in range(30):
            curvature = chebyshev.chebval(x, bend, tensor=False)
            step = chebyshev.chebval(x, slope, tensor=False) / np.where(curvature > 0, curvature, np.inf)
            x = np.clip(x - np.clip(step, -0.2, 0.2), -1.0, 1.0)
            if np.max(np.abs(step)) < 1e-13:
                break
        inside = (chebyshev.chebval(x, bend, tensor=False) > 0) & (np.abs(x) < 0.999) & (np.abs(step) < 1e-6)
        faded = np.abs(poly[-1]) < 10.0 ** (-0.5 * COUNT - 1.0) * np.max(np.abs(poly), axis=0)
        return x, inside & faded


def _coordinates(columns: Array) -> Array:
    """Matrix (k, k) that makes columns (n, k) orthonormal: linear parameters = matrix · coordinates."""
    scale = norms(columns)
    return np.linalg.inv(np.linalg.qr(columns / scale, mode="r")) / scale[:, None]


def _all_forces(design: Design, forces: Array, nodes: _Nodes) -> _Refits:
    """Least squares of the model to each column of `forces` (n, B) in N."""
    back = _coordinates(design(float(nodes.at(np.zeros(1))[0]))[0])
    taken = [design(float(q)) for q in nodes.at(nodes.points)]
    frames, fixed = [c @ back for c, _ in taken], np.array([f for _, f in taken])
    basis = _span(np.hstack([*frames, fixed.T]))
    k, seen, shift = len(back), basis.T @ forces, fixed @ basis
    cost, answer = np.empty((COUNT, seen.shape[1])), np.empty((COUNT, k, seen.shape[1]))
    for i, frame in enumerate(frames):
        q, r = np.linalg.qr(basis.T @ frame, mode="complete")
        target = seen - shift[i][:, None]
        cost[i] = np.sum((q[:, k:].T @ target) ** 2, axis=0)
        answer[i] = np.linalg.solve(r[:k], q[:, :k].T) @ target
    x, inside = nodes.minimum(cost)
    linear = np.einsum("ib,ikb->kb", nodes.weights(x), answer)
    return np.column_stack([(back @ linear).T, nodes.at(x)]), inside


def _span(stack: Array) -> Array:
    """Orthonormal basis (n, r) of the columns of a stack (n, m), to rounding."""
    u, sigma, _ = np.linalg.svd(stack / norms(stack), full_matrices=False)
    return np.ascontiguousarray(u[:, sigma > 1e-13 * sigma[0]])


def _all_weights(
    design: Design, force: Array, blocks: Sequence[Array], counts: Array, start: Array, nodes: _Nodes
) -> _Refits:
    """Least squares with each block of rows (indices) taken `counts` (B, blocks) times.

    `start` (k,) are linear parameters of a fit nearby, from which changes are counted so that no digits are lost.
    """
    back = _coordinates(design(float(nodes.at(np.zeros(1))[0]))[0])
    sums = []
    for columns, fixed in (design(float(q)) for q in nodes.at(nodes.points)):
        target = force - fixed
        grams = np.array([_gram(columns[rows], target[rows], start) for rows in blocks])
        sums.append(_packed(grams, back))
    weighted = np.ascontiguousarray((counts @ np.array(sums)).transpose(0, 2, 1))
    cost = np.array([one[-1] - _normal_equations(one, len(back))[1] for one in weighted])
    x, inside = nodes.minimum(cost)
    here = np.einsum("ib,ijb->jb", nodes.weights(x), weighted)
    change = _normal_equations(here, len(back))[0]
    return np.column_stack([(start[:, None] + back @ change).T, nodes.at(x)]), inside


def _gram(columns: Array, target: Array, start: Array) -> Array:
    """Gram matrix (k + 1, k + 1) of columns (n, k) and of what the start (k,) leaves of the target (n,)."""
    k = len(start)
    left = target - columns @ start
    found = np.empty((k + 1, k + 1))
    found[:k, :k] = columns.T @ columns
    found[k, :k] = found[:k, k] = columns.T @ left
    found[k, k] = left @ left
    return found


def _packed(grams: Array, back: Array) -> Array:
    """Gram matrices (m, k + 1, k + 1) in coordinates, a row each: upper triangle of the first k, last column."""
    k = len(back)
    turn = np.eye(k + 1)
    turn[:k, :k] = back
    turned = turn.T @ grams @ turn
    rows, columns = np.triu_indices(k)
    return np.hstack([turned[:, rows, columns], turned[:, :, k]])


def _normal_equations(rows: Array, k: int) -> tuple[Array, Array]:
    """Solutions (k, B) of B small systems A x = b, and bᵀA⁻¹b (B,), from packed Gram matrices (entries, B).

    Cholesky's scheme written over whole rows, because a call per system would cost more than the system.
    """
    factor: dict[tuple[int, int], Array] = {}
    entry = {(i, j): rows[m] for m, (i, j) in enumerate(zip(*(x.tolist() for x in np.triu_indices(k)), strict=True))}
    first = len(entry)
    none, half = np.zeros(1), []
    for j in range(k):
        for i in range(j, k):
            rest = entry[j, i] - sum((factor[i, m] * factor[j, m] for m in range(j)), none)
            factor[i, j] = np.sqrt(np.maximum(rest, 1e-300)) if i == j else rest / factor[j, j]
        rest = rows[first + j] - sum((factor[j, m] * half[m] for m in range(j)), none)
        half.append(rest / factor[j, j])
    x = np.empty((k, rows.shape[1]))
    for j in reversed(range(k)):
        rest = half[j] - sum((factor[i, j] * x[i] for i in range(j + 1, k)), none)
        x[j] = rest / factor[j, j]
    return x, np.sum(np.square(half), axis=0)


def refit_forces(fit: Fit, forces: Array) -> tuple[Array, int]:
    """Fits to each column of `forces` (m, B) in N over the fit's rows: values (B, k) and how many took a solver each.

    Values are of the parameters that were not held, in the model's order; starts, weights and bounds are the fit's.
    """
    weighted = forces if fit.weights is None else forces * fit.weights[fit.rows, None]
    interval = _interval(fit)
    found = None if interval is None else _all_forces(_design(fit), weighted, interval)

    def alone(b: int) -> Mapping[str, float]:
        force = fit.record.force.copy()
        force[fit.rows] = forces[:, b]
        return _solve(fit, force, picker(fit.rows, fit.weights))

    return _complete(fit, found, forces.shape[1], alone)


def refit_weights(fit: Fit, block: Array, counts: Array) -> tuple[Array, int]:
    """Fits with each block of rows taken `counts` (B, blocks) times; `block` (m,) numbers those of the fit's rows.

    Returns what `refit_forces` does.
    """
    found, interval = None, _interval(fit)
    if interval is not None:
        pick = picker(fit.rows, fit.weights)
        start = np.array([fit.values[p.name] for p in _free(fit, fit.model.linear)])
        blocks = [np.flatnonzero(block == k) for k in range(counts.shape[1])]
        found = _all_weights(_design(fit), pick(fit.record.force), blocks, counts, start, interval)

    def alone(b: int) -> Mapping[str, float]:
        weights = np.ones(len(fit.record)) if fit.weights is None else fit.weights.copy()
        weights[fit.rows] *= np.sqrt(counts[b])[block]
        return _solve(fit, fit.record.force, picker(fit.rows, weights))

    return _complete(fit, found, len(counts), alone)


def _free(fit: Fit, params: Iterable[Param]) -> list[Param]:
    return [p for p in params if p.name not in fit.held]


def _nonlinear(fit: Fit) -> list[Param]:
    return _free(fit, fit.model.bounded(fit.record.inputs)[len(fit.model.linear) :])


def _interval(fit: Fit) -> _Nodes | None:
    """Where the one nonlinear parameter is sought; None where the model has more, or is not separable."""
    nonlinear = _nonlinear(fit)
    if not fit.model.separable or len(nonlinear) > 1:
        return None
    if not nonlinear:
        return _Nodes(0.0, 0.0)
    p = nonlinear[0]
    estimate = next(e for e in fit.estimates if e.name == p.name)
    if estimate.at_bound or not np.isfinite(estimate.stderr):
        return None
    reach = REACH * estimate.stderr
    return _Nodes(p.clip(estimate.value - reach), p.clip(estimate.value + reach))


def _design(fit: Fit) -> Design:
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


def _complete(
    fit: Fit, found: _Refits | None, n: int, alone: Callable[[int], Mapping[str, float]]
) -> tuple[Array, int]:
    """Values (n, k) in the model's order; those that left the interval or a bound are solved singly."""
    params = _free(fit, fit.model.bounded(fit.record.inputs))
    if found is None:
        values, bad = np.empty((n, len(params))), np.ones(n, bool)
    else:
        values, inside = found[0][:, : len(params)], found[1]
        lower, upper = bounds(params)
        bad = ~inside | np.any((values <= lower) | (values >= upper), axis=1) | ~np.isfinite(values).all(axis=1)
    for b in steps(np.flatnonzero(bad), "refitting one by one"):
        one = alone(int(b))
        values[b] = [one[p.name] for p in params]
    return values, int(bad.sum())
