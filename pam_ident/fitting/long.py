"""Fits of records that memory does not hold: to the minimum of the same squares, by a few readings of all rows.

A fit to an even sample of the rows says where the minimum lies, steps of Gauss and Newton over all rows lead into it.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..core import Param, UsageError
from ..model import Model
from ..records import Record
from ..records.long import LongRecord
from .fit import Fit, check
from .long_rows import UNREAD, Rows, Summary
from .problem import bounds, within_bounds
from .readings import reached, with_memory
from .solve import solve

Array = np.ndarray
SAMPLE = 20_000
"""Rows of the sample in which the minimum is looked for, and that stands for the record where a few rows will do."""
MOST_READINGS = 40


@dataclass(frozen=True)
class LongFit(Fit):
    """A fit to all rows of a LongRecord. `record` and `rows` are those of a sample, `summary` is of all."""

    summary: Summary = UNREAD

    @property
    def n(self) -> int:
        """How many rows were fitted."""
        return self.summary.n

    @property
    def rmse(self) -> float:
        """Root mean square of the residual over the fitted rows, N."""
        return self.summary.rmse

    @property
    def max_error(self) -> float:
        """Largest absolute residual over the fitted rows, N."""
        return self.summary.max_error

    @property
    def r2(self) -> float:
        """Coefficient of determination over the fitted rows."""
        return self.summary.r2


def fit_long(
    model: Model, record: LongRecord, branches: tuple[str, ...], held: Mapping[str, float] | None = None
) -> dict[str, LongFit]:
    """Least-squares fits by branch, as `fit` makes them of a record in memory, errors of the parameters included.

    Raises what `fit` does, and UsageError for an effect that remembers what was before a sample.
    """
    held, sample = dict(held or {}), record.sample(SAMPLE)
    masks = {name: sample.branch_rows(name) for name in branches}
    for mask in masks.values():
        check(model, sample, mask, held)
    memory = with_memory(model, sample.inputs, sample.force)
    if memory:
        raise UsageError(
            f"{sample.source}: {memory[0].label} remembers what was before, and the record is read in chunks; leave it "
            "out, or fit a part of the record that fits into memory"
        )
    both = {name for name, mask in masks.items() if np.ptp(np.sign(sample.inputs.direction[mask])) == 2.0}
    rows = Rows(model, record, held, frozenset(both))
    searches = {name: _begin(model, sample.take(np.flatnonzero(mask)), held) for name, mask in masks.items()}
    for _ in range(MOST_READINGS):
        going = {name: one.values | held for name, one in searches.items() if not one.done}
        if not going:
            break
        searches |= {name: searches[name].after(triangle) for name, triangle in rows.triangles(going).items()}
    known = rows.sums({name: one.values | held for name, one in searches.items()})
    found = {}
    for name, (sums, summary) in known.items():
        one, message = searches[name], "by readings of all rows"
        values = one.values | held
        found[name] = LongFit(
            model, sample, masks[name], values, one.done, message, held=held, sums=sums, summary=summary
        )
    return found


@dataclass(frozen=True, eq=False)
class _Search:
    """Where a branch's search stands: the `point` (k,) to be read next, and the `best` one read with the sum of squares
    there and the size of the step that led on from it, in typical sizes of the parameters.

    A step that made things worse is halved, unless it helps once the `linear` first parameters have followed.
    """

    params: tuple[Param, ...]
    linear: int
    point: Array
    best: Array
    squares: float = math.inf
    size: float = math.inf
    done: bool = False

    @property
    def values(self) -> dict[str, float]:
        """The point by name."""
        return dict(zip([p.name for p in self.params], self.point.tolist(), strict=True))

    def after(self, triangle: Array) -> "_Search":
        """The next point, from R (k + 1, k + 1) of Jacobian and residual at this one."""
        lower, upper = (bound - self.point for bound in bounds(self.params))
        matrix, left = triangle[:, :-1], triangle[:, -1:]

        def step(k: int) -> Array:
            return within_bounds(np.hstack([matrix[:, :k], -left]), lower[:k], upper[:k])

        squares = float(np.sum(left**2))
        if not squares <= self.squares * (1.0 + 1e-12):
            follow = step(self.linear)
            if np.sum((matrix[:, : self.linear] @ follow + left[:, 0]) ** 2) < self.squares:
                return replace(self, point=np.r_[self.point[: self.linear] + follow, self.point[self.linear :]])
            return replace(self, point=0.5 * (self.point + self.best))
        whole = step(len(self.params))
        typical = np.array([p.typical(x) for p, x in zip(self.params, self.point, strict=True)])
        size = float(np.max(np.abs(whole) / typical, initial=0.0))
        rate = size / self.size if math.isfinite(self.size) else 1.0
        done = reached(size, rate, float(np.sum((matrix @ whole) ** 2)) / squares if squares else 0.0)
        point = np.array([p.clip(x) for p, x in zip(self.params, self.point + whole, strict=True)])
        return replace(self, point=point, best=self.point, squares=squares, size=size, done=done)


def _begin(model: Model, sample: Record, held: Mapping[str, float]) -> _Search:
    """A search that begins at the fit to the sample."""
    params = tuple(p for p in model.bounded(sample.inputs) if p.name not in held)
    linear = sum(p.name not in held for p in model.linear) if model.separable else 0
    values = solve(model, sample.inputs, sample.force, lambda m: m, held=held).values
    point = np.array([values[p.name] for p in params])
    return _Search(params, linear, point, point)
