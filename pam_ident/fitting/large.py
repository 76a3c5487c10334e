"""Fits of very many samples at the price of a few readings of them.

A fit to some thousand samples says where the minimum lies, and many more say it more closely. From there one step of
Gauss and Newton over all samples is nearly always enough. They are read in chunks that stay in the processor's cache.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..core import Inputs, Param
from ..model import Model
from ..records import Record
from .covariance import Sums, clusters
from .pieces import with_memory
from .solve import solve

Array = np.ndarray
FROM = 50_000
"""Number of samples from which this pays."""
FIRST, SECOND = 1_500, 20_000
CHUNK = 10_240
SHORT, CLOSE = 0.1, 0.1
"""Standard errors that a last step over some samples, and over all, may be long: a thousandth of it is left to go."""
MOST = 8


def is_large(model: Model, record: Record, rows: Array) -> bool:
    """Whether this way pays and is open: all of very many `rows` (n,), a separable model without memory."""
    if len(record) < FROM or not model.separable or not rows.all():
        return False
    some = _some(record, SECOND)
    return not with_memory(model, record.inputs.take(some), record.force[some])


def solve_large(
    model: Model, record: Record, start: Mapping[str, float], clustered: bool = False
) -> tuple[dict[str, float], Sums] | None:
    """Least squares over all samples: parameters and sums for their errors, by cluster if so wished.

    None where a parameter meets a bound, a direction is flat, or steps do not shorten: the solver must go the long way.
    """
    params = model.bounded(record.inputs)
    if any(not np.isfinite(value) for value in start.values()):
        return None
    first, second = _some(record, FIRST), _some(record, SECOND)
    values = solve(model, record.inputs.take(first), record.force[first], lambda m: m, start, quick=True).values
    near = _newton(_Reading(model, record.inputs.take(second), record.force[second], params), values)
    if near is None:
        return None
    cluster = clusters(record, slice(None)) if clustered else None
    return _end(_Reading(model, record.inputs, record.force, params, cluster), near)


def _some(record: Record, most: int) -> slice:
    """About `most` rows, the first among them, by a stride that is odd, to alternate with pairs."""
    return slice(None, None, len(record) // most | 1)


def _newton(reading: "_Reading", values: Mapping[str, float]) -> Array | None:
    """Steps until one is short: the parameters (k,)."""
    x = np.array([values[p.name] for p in reading.params])
    for _ in range(MOST):
        found = reading.sums(x)
        step = found.step(found.score)
        if step is None or not reading.inside(x + step):
            return None
        x = x + step
        if found.length(step) <= SHORT:
            return x
    return None


def _end(whole: "_Reading", x: Array) -> tuple[dict[str, float], Sums] | None:
    """A step over all samples, and a short one along the same Gram matrix for what the first has left."""
    for _ in range(MOST):
        found = whole.sums(x)
        step = found.step(found.score)
        if step is None or not whole.inside(x + step):
            return None
        rest = found.step(whole.score(x + step))
        if rest is None or not whole.inside(x + step + rest):
            return None
        x, step = x + step + rest, step + rest
        if found.length(rest) <= CLOSE:
            return whole.named(x), found.after(step)
    return None


@dataclass(frozen=True)
class _Found:
    """Gram matrix of a Jacobian, its product with the residual, and the residual's squares; by cluster, too."""

    n: int
    gram: Array
    score: Array
    squares: float
    grams: Array
    scores: Array

    def step(self, score: Array) -> Array | None:
        """Where a gradient leads, (k,) → (k,); None along flat directions."""
        scale = np.sqrt(np.diag(self.gram))
        if not np.all(scale > 0.0):
            return None
        weight, axes = np.linalg.eigh(self.gram / np.outer(scale, scale))
        return axes @ (axes.T @ (score / scale) / weight) / scale if weight[0] > 1e-13 * weight[-1] else None

    def length(self, step: Array) -> float:
        """Length of a step in standard errors."""
        return float(np.sqrt(step @ self.gram @ step / self.squares * max(self.n - len(step), 1)))

    def after(self, step: Array) -> Sums:
        """The sums where a step has led, to first order."""
        scale = np.sqrt(np.diag(self.gram))
        weight, axes = np.linalg.eigh(self.gram / np.outer(scale, scale))
        triangle = np.sqrt(weight)[:, None] * axes.T * scale
        squares = self.squares - 2.0 * float(step @ self.score) + float(step @ self.gram @ step)
        return Sums(self.n, triangle, squares, self.grams, self.scores - self.grams @ step)


@dataclass(frozen=True, eq=False)
class _Reading:
    """A model and samples to fit it to; `cluster` (n,) where sums are kept by it."""

    model: Model
    inputs: Inputs
    force: Array
    params: tuple[Param, ...]
    cluster: Array | None = None

    def named(self, x: Array) -> dict[str, float]:
        """Parameters by name."""
        return dict(zip([p.name for p in self.params], x.tolist(), strict=True))

    def inside(self, x: Array) -> bool:
        """Whether all parameters are off their bounds."""
        return all(p.lower < v < p.upper for p, v in zip(self.params, x, strict=True))

    def sums(self, x: Array) -> _Found:
        """Sums over all chunks."""
        values = self.named(x)
        n, k = len(self.force), len(self.params)
        runs = 0 if self.cluster is None else int(self.cluster.max()) + 1
        whole, tables = np.zeros((k + 1, k + 1)), np.zeros((runs, k + 1, k + 1))
        table = np.empty((k + 1, CHUNK))
        for begin in range(0, n, CHUNK):
            part = slice(begin, min(begin + CHUNK, n))
            columns, slopes, left = self._slopes(part, values)
            table = table[:, : len(left)]
            table[: columns.shape[1]] = columns.T
            table[columns.shape[1] : k] = slopes
            table[k] = left
            if self.cluster is None:
                whole += table @ table.T
                continue
            run = self.cluster[part]
            edges = np.flatnonzero(np.diff(run)) + 1
            for i, piece in zip([0, *edges], np.split(table, edges, axis=1), strict=True):
                tables[run[i]] += piece @ piece.T
        whole += tables.sum(axis=0)
        tables = tables[tables[:, k, k] > 0.0]
        return _Found(n, whole[:k, :k], whole[:k, k], float(whole[k, k]), tables[:, :k, :k], tables[:, :k, k])

    def score(self, x: Array) -> Array:
        """Product of the Jacobian with the residual, (k,), at half the price of all sums."""
        found = np.zeros(len(self.params))
        n = len(self.force)
        for begin in range(0, n, CHUNK):
            columns, slopes, left = self._slopes(slice(begin, min(begin + CHUNK, n)), self.named(x))
            found += np.r_[columns.T @ left, slopes @ left]
        return found

    def _slopes(self, part: slice, values: Mapping[str, float]) -> tuple[Array, Array, Array]:
        """Linear columns (m, ·), derivatives by curved parameters (·, m), and the residual (m,), of some samples.

        The first sample of all is read with them where there are effects, which may count from it.
        """
        first = int(bool(self.model.terms))
        rows = np.r_[0, part] if first else part
        inputs, force = self.inputs.take(rows), self.force[rows]
        sizes = np.array([values[p.name] for p in self.model.linear])
        columns, fixed = self.model.design(inputs, values, force)
        modelled = fixed + columns @ sizes
        curved = self.params[len(sizes) :]
        slopes = np.empty((len(curved), len(force)))
        for row, p in zip(slopes, curved, strict=True):
            near = values[p.name] + 1e-6 * max(abs(values[p.name]), 1e-3 * p.scale)
            other, moved = self.model.design(inputs, {**values, p.name: near}, force)
            np.subtract(moved + other @ sizes, modelled, out=row)
            row /= near - values[p.name]
        return columns[first:], slopes[:, first:], (force - modelled)[first:]
