"""Fits of very many samples at the price of a few readings of them.

A fit to some thousand samples says where the minimum lies, many more say it more closely, and from there Gauss and
Newton's steps over all samples are so short that two of them end at rounding. Samples are read in chunks that stay in
the processor's cache, on all its cores.
"""

import os
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from ..core import Param
from ..model import Model
from ..records import Record
from .covariance import Sums, clusters
from .solve import curved_within_bounds, jacobian, solve

Array = np.ndarray
FROM = 50_000
"""Number of samples from which this pays."""
FIRST, SECOND = 2_000, 80_000
CHUNK = 8192
SHORT = 0.03
"""Length of a last step in standard errors: what is then left is shorter by a factor of some hundred."""
MOST = 8


def is_large(model: Model, record: Record, rows: Array) -> bool:
    """Whether this way pays and is open: all of very many samples, a separable model without memory."""
    memory = any(term.effect.stateful for term in model.terms)
    return len(record) >= FROM and model.separable and not memory and bool(rows.all())


def solve_large(
    model: Model, record: Record, start: Mapping[str, float], clustered: bool = False
) -> tuple[dict[str, float], Sums] | None:
    """Least squares over all samples: parameters and sums for their errors, by cluster if so wished.

    None where a parameter meets a bound, a direction is flat, or steps do not shorten: the solver must go the long way.
    """
    params = [*model.linear, *curved_within_bounds(model, record.inputs)]
    if any(not np.isfinite(value) for value in start.values()):
        return None
    rng = np.random.default_rng(0)
    first, second = (np.sort(rng.integers(0, len(record), n)) for n in (FIRST, SECOND))
    values = solve(model, record.inputs.take(first), record.force[first], lambda m: m, start, quick=True).values
    near = _newton(_Reading(model, record, params, second), values)
    if near is None:
        return None
    return _newton(_Reading(model, record, params, None, clusters(record, slice(None)) if clustered else None), near[0])


def _newton(reading: "_Reading", values: dict[str, float]) -> tuple[dict[str, float], Sums] | None:
    """Steps until one is short: values and the sums there."""
    x = np.array([values[p.name] for p in reading.params])
    for _ in range(MOST):
        found = reading.sums(dict(zip([p.name for p in reading.params], x.tolist(), strict=True)))
        scale = np.sqrt(np.diag(found.gram))
        if not np.all(scale > 0.0):
            return None
        weight, axes = np.linalg.eigh(found.gram / np.outer(scale, scale))
        if not weight[0] > 1e-13 * weight[-1]:
            return None
        along = (axes.T @ (found.score / scale)) / np.sqrt(weight)
        step = axes @ (along / np.sqrt(weight)) / scale
        x = x + step
        if not all(p.lower < v < p.upper for p, v in zip(reading.params, x, strict=True)):
            return None
        if float(along @ along) <= SHORT**2 * found.squares / max(found.n - len(x), 1):
            triangle = np.sqrt(weight)[:, None] * axes.T * scale
            squares = found.squares - float(along @ along)
            grams, scores = found.grams, found.scores - found.grams @ step
            ended = dict(zip([p.name for p in reading.params], x.tolist(), strict=True))
            return ended, Sums(found.n, triangle, squares, grams, scores)
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


@dataclass(frozen=True, eq=False)
class _Reading:
    """A model and samples of a record, `rows` of them (indices) or all; `cluster` (n,) where sums are kept by it."""

    model: Model
    record: Record
    params: list[Param]
    rows: Array | None
    cluster: Array | None = None

    def sums(self, values: Mapping[str, float]) -> _Found:
        """Sums over all chunks, in their order, so that the number of cores changes nothing."""
        n = len(self.record) if self.rows is None else len(self.rows)
        parts = [slice(i, i + CHUNK) if self.rows is None else self.rows[i : i + CHUNK] for i in range(0, n, CHUNK)]
        with ThreadPoolExecutor(min(len(parts), os.cpu_count() or 1)) as pool:
            found = list(pool.map(lambda part: self._chunk(part, values), parts))
        k = len(self.params)
        whole = np.sum([table for table, _ in found], axis=0)
        runs = 0 if self.cluster is None else int(self.cluster.max()) + 1
        tables = np.zeros((runs, k + 1, k + 1))
        for _, pieces in found:
            for run, table in pieces:
                tables[run] += table
        tables = tables[tables[:, k, k] > 0.0]
        return _Found(n, whole[:k, :k], whole[:k, k], float(whole[k, k]), tables[:, :k, :k], tables[:, :k, k])

    def _chunk(self, part: Array | slice, values: Mapping[str, float]) -> tuple[Array, list[tuple[int, Array]]]:
        """Gram matrix (k + 1, k + 1) of Jacobian and residual over some rows, and of each cluster in them."""
        inputs, force = self.record.inputs.take(part), self.record.force[part]
        matrix = jacobian(self.model, inputs, values, force)
        table = np.column_stack([matrix, force - self.model.force(inputs, values)])
        if self.cluster is None:
            return table.T @ table, []
        run = self.cluster[part]
        edges = np.flatnonzero(np.diff(run)) + 1
        pieces = [(int(run[i]), t.T @ t) for i, t in zip([0, *edges], np.split(table, edges), strict=True)]
        return np.sum([t for _, t in pieces], axis=0), pieces
