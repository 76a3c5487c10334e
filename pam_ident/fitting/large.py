"""Fits of very many samples at the price of a few readings of them.

A fit to some thousand samples says where the minimum lies, and many more say it more closely. From there a step along
their Gram matrix leads so near that one of Gauss and Newton over all samples, and a last one along the same matrix, are
nearly always enough. They are read in chunks that stay in the processor's cache.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from ..core import Inputs, Param
from ..model import Model
from ..records import Record
from .covariance import Sums, clusters
from .readings import reached, with_memory
from .solve import solve

Array = np.ndarray
FROM = 50_000
"""Number of samples from which this pays."""
FIRST, SECOND = 1_500, 20_000
CHUNK = 10_240
MOST = 30
STEP = 1e-6
"""Step of central differences, relative: so small that the mean of both ends is the middle, to 1e-12."""


def is_large(model: Model, record: Record, rows: Array) -> bool:
    """Whether this way pays and is open: all of very many `rows` (n,), a separable model without memory."""
    if len(record) < FROM or not model.separable or not model.params or not rows.all():
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
    some = _Reading(model, record.inputs.take(second), record.force[second], params)
    near = _newton(some, np.array([values[p.name] for p in params]))
    if near is None:
        return None
    cluster = clusters(record, slice(None)) if clustered else None
    every = _Reading(model, record.inputs, record.force, params, cluster)
    across = near.found.step(every.score(near.x) * (len(some) / len(every)))
    end = None if across is None or not every.inside(near.x + across) else _newton(every, near.x + across)
    return None if end is None else (every.named(end.x), end.found.after(end.way))


def _some(record: Record, most: int) -> slice:
    """About `most` rows, the first among them, by a stride that is odd, to alternate with pairs."""
    return slice(None, None, len(record) // most | 1)


def _newton(reading: "_Reading", x: Array) -> "_End | None":
    """From x (k,) to the minimum: steps of Gauss and Newton, along one Gram matrix for as long as they shorten."""
    typical = np.array([p.typical(v) for p, v in zip(reading.params, x, strict=True)])
    for _ in range(MOST):
        found, way, before = reading.sums(x), np.zeros(len(x)), 0.0
        score = found.score
        for _ in range(MOST):
            step = found.step(score)
            if step is None or not reading.inside(x + way + step):
                return None
            way, size = way + step, float(np.max(np.abs(step) / typical))
            rate = size / before if before else 1.0
            if reached(size, rate, found.moved(step)):
                return _End(x + way, way, found)
            if before and rate > 0.5:
                break
            before, score = size, reading.score(x + way)
        x = x + way
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

    def moved(self, step: Array) -> float:
        """Square of a step over all samples, as a share of the residual's."""
        return float(step @ self.gram @ step) / max(self.squares, 1e-300)

    def after(self, step: Array) -> Sums:
        """The sums where a step has led, to first order."""
        scale = np.sqrt(np.diag(self.gram))
        weight, axes = np.linalg.eigh(self.gram / np.outer(scale, scale))
        triangle = np.sqrt(weight)[:, None] * axes.T * scale
        squares = self.squares - 2.0 * float(step @ self.score) + float(step @ self.gram @ step)
        return Sums(self.n, triangle, squares, self.grams, self.scores - self.grams @ step)


@dataclass(frozen=True)
class _End:
    """Parameters x (k,), and the way (k,) that led there from where the sums were `found`."""

    x: Array
    way: Array
    found: _Found


@dataclass(frozen=True, eq=False)
class _Reading:
    """A model and samples to fit it to; `cluster` (n,) where sums are kept by it."""

    model: Model
    inputs: Inputs
    force: Array
    params: tuple[Param, ...]
    cluster: Array | None = None

    def __len__(self) -> int:
        return len(self.force)

    def named(self, x: Array) -> dict[str, float]:
        """Parameters by name."""
        return dict(zip([p.name for p in self.params], x.tolist(), strict=True))

    def inside(self, x: Array) -> bool:
        """Whether all parameters are off their bounds."""
        return all(p.lower < v < p.upper for p, v in zip(self.params, x, strict=True))

    def sums(self, x: Array) -> _Found:
        """Sums over all chunks."""
        n, k = len(self), len(self.params)
        linear = len(self.model.linear)
        runs = 0 if self.cluster is None else int(self.cluster.max()) + 1
        whole, tables = np.zeros((k + 1, k + 1)), np.zeros((runs, k + 1, k + 1))
        table = np.empty((k + 1, CHUNK))
        for begin, (columns, _, slopes, left) in self._chunks(x):
            table = table[:, : len(left)]
            table[:linear] = columns.T
            table[linear:k] = slopes
            table[k] = left
            if self.cluster is None:
                whole += table @ table.T
                continue
            run = self.cluster[begin : begin + CHUNK]
            edges = np.flatnonzero(np.diff(run)) + 1
            for i, piece in zip([0, *edges], np.split(table, edges, axis=1), strict=True):
                tables[run[i]] += piece @ piece.T
        whole += tables.sum(axis=0)
        tables = tables[tables[:, k, k] > 0.0]
        return _Found(n, whole[:k, :k], whole[:k, k], float(whole[k, k]), tables[:, :k, :k], tables[:, :k, k])

    def score(self, x: Array) -> Array:
        """Product of the Jacobian with the residual, (k,), closer than in the sums, and at less than their price."""
        linear = len(self.model.linear)
        found = np.zeros(len(x))
        for _, (columns, others, slopes, left) in self._chunks(x):
            found[:linear] += 0.5 * (columns.T @ left + others.T @ left)
            found[linear:] += slopes @ left
        return found

    def _chunks(self, x: Array) -> Iterator[tuple[int, tuple[Array, Array, Array, Array]]]:
        """Where each chunk begins, and its `_slopes`."""
        values = self.named(x)
        for begin in range(0, len(self), CHUNK):
            yield begin, self._slopes(slice(begin, min(begin + CHUNK, len(self))), values)

    def _slopes(self, part: slice, values: Mapping[str, float]) -> tuple[Array, Array, Array, Array]:
        """Linear columns (m, ·) twice, derivatives by curved parameters (·, m), and the residual (m,), of some samples.

        The columns are those at both ends of a central difference, which with their mean spares what is between. The
        first sample of all is read with these where there are effects, which may count from it.
        """
        first = int(bool(self.model.terms))
        rows = np.r_[0, part] if first else part
        inputs, force = self.inputs.take(rows), self.force[rows]
        sizes = np.array([values[p.name] for p in self.model.linear])
        curved = self.params[len(sizes) :]

        def at(**moved: float) -> tuple[Array, Array]:
            columns, fixed = self.model.design(inputs, {**values, **moved}, force)
            return columns, fixed + columns @ sizes

        slopes = np.empty((len(curved), len(force)))
        (columns, low), (others, high) = [at()] * 2 if not curved else [(force, force)] * 2
        for row, p in zip(slopes, curved, strict=True):
            way = STEP * max(abs(values[p.name]), 0.01 * p.scale)
            begin, end = values[p.name] - way, values[p.name] + way
            (columns, low), (others, high) = at(**{p.name: begin}), at(**{p.name: end})
            np.subtract(high, low, out=row)
            row /= end - begin
        left = force - 0.5 * (low + high)
        return columns[first:], others[first:], slopes[:, first:], left[first:]
