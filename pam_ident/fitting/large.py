"""Fits of very many samples at the price of a few readings of them.

With the linear parameters eliminated the cost is a smooth function of the one curved parameter. A fit to a thousand
samples says where its minimum lies, some ten thousand say it more closely, and four Chebyshev nodes around that give
the minimum over all samples. These are read in chunks that stay in the processor's cache, on all its cores.
"""

import os
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from ..core import Inputs
from ..model import Model
from .batch import Nodes, coordinates, costs, from_sums, gram, packed
from .covariance import covariance
from .solve import Solution, curved_within_bounds, jacobian, solve

Array = np.ndarray
FROM = 50_000
"""Number of samples from which this pays."""
STEPS = ((80_000, 6), (0, 4))
"""Samples of each step after the first, 0 for all, and nodes."""
FIRST = 1_500
MANY = 10
"""Nodes where those of the steps would leave the minimum in doubt."""
CLOSE = 1e-4
"""Largest doubt, in standard errors."""
CHUNK = 8192
REACH = 5.0
"""Half the interval of the next step, in standard errors of the last."""


def solve_large(model: Model, inputs: Inputs, force: Array, start: Mapping[str, float]) -> Solution | None:
    """Least squares over all samples, or None where this way is not open and the solver must go the long one.

    Open to separable models without memory, with at most one curved parameter, whose answer keeps off all bounds.
    """
    curved = curved_within_bounds(model, inputs)
    if len(force) < FROM or len(curved) > 1 or not model.separable or any(t.effect.stateful for t in model.terms):
        return None
    reading = _Reading(model, inputs, force, [p.name for p in curved])
    rng = np.random.default_rng(0)
    rows = np.unique(rng.integers(0, len(force), FIRST))
    values = solve(model, inputs.take(rows), force[rows], lambda m: m, start, quick=True).values
    error = reading.error(rows, values)
    params = [*model.linear, *curved]
    for count, nodes in STEPS:
        middle = reading.curved(values)
        low, high = (curved[0].clip(middle + side * REACH * error) if curved else 0.0 for side in (-1.0, 1.0))
        back = coordinates(reading.take(rows, middle)[0])
        begin = np.array([values[p.name] for p in model.linear])
        more = np.unique(rng.integers(0, len(force), count)) if count else None
        error *= np.sqrt(len(rows) / (len(force) if more is None else len(more)))
        for grid in (Nodes(low, high, nodes), Nodes(low, high, MANY)):
            sums = reading.sums(grid, more, back, begin)[:, :, None]
            if grid.doubt(costs(sums, len(begin)))[0] <= CLOSE * error:
                break
        refit = from_sums(sums, back, begin, grid)
        values = reading.values(refit.linear[0], float(refit.curved[0]))
        if not refit.inside[0] or not all(p.lower < values[p.name] < p.upper for p in params):
            return None
        rows = rows if more is None else more
    return Solution(values, True, "found on ever more samples")


@dataclass(frozen=True, eq=False)
class _Reading:
    """A model and its samples, read in part or whole."""

    model: Model
    inputs: Inputs
    force: Array
    names: list[str]

    def curved(self, values: Mapping[str, float]) -> float:
        """The one curved parameter, 0 where there is none."""
        return sum(values[name] for name in self.names)

    def values(self, linear: Array, curved: float) -> dict[str, float]:
        """Parameters by name."""
        found = {p.name: float(x) for p, x in zip(self.model.linear, linear, strict=True)}
        return found | dict.fromkeys(self.names, curved)

    def take(self, rows: Array | slice, curved: float) -> tuple[Array, Array]:
        """Columns and what they are fitted to at some rows."""
        columns, fixed = self.model.design(self.inputs.take(rows), dict.fromkeys(self.names, curved), self.force[rows])
        return columns, self.force[rows] - fixed

    def error(self, rows: Array, values: Mapping[str, float]) -> float:
        """Standard error of the curved parameter from some rows, 0 where there is none."""
        if not self.names:
            return 0.0
        matrix = jacobian(self.model, self.inputs.take(rows), values, self.force[rows])
        left = self.force[rows] - self.model.force(self.inputs.take(rows), values)
        return float(np.sqrt(covariance(matrix, left).matrix[-1, -1]))

    def sums(self, grid: Nodes, rows: Array | None, back: Array, start: Array) -> Array:
        """Packed Gram matrices at the nodes, over some rows or all, shape (nodes, entries)."""
        n = len(self.force) if rows is None else len(rows)
        parts = [slice(i, i + CHUNK) if rows is None else rows[i : i + CHUNK] for i in range(0, n, CHUNK)]
        points = [float(q) for q in grid.at(grid.points)]

        def one(part: Array | slice) -> Array:
            return np.array([gram(*self.take(part, q), start) for q in points])

        with ThreadPoolExecutor(min(len(parts), os.cpu_count() or 1)) as pool:
            return packed(np.sum(list(pool.map(one, parts)), axis=0), back)
