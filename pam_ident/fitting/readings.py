"""Readings of a record's rows, some at a time, in memory or on disk: what they say of a model at given parameters.

A search must look at many points, and looks at a sample of very many rows. Near the minimum one step of Gauss and
Newton does what a search does, so that a few readings of all rows lead into it, of which only sums are kept.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..core import Array, Inputs, Param
from ..core.progress import tell
from ..model import Model, Term
from ..records import Record
from .covariance import Sums, clusters, grams, joined, sums
from .descent import descend, settle
from .solve import solve, table

if TYPE_CHECKING:
    from ..records.long import LongRecord

FROM = 50_000
"""Rows in memory from which readings of all cost less than a search in them."""
SAMPLES = (1_500, 20_000)
"""Rows in which the minimum is searched, and in which that is led on before all rows are."""
CHUNK = 10_240
"""Rows in memory of a chunk: as many as the processor's cache holds."""
STEP = 1e-6
"""Step of central differences, relative: so small that the mean of both ends is the middle, to 1e-12."""
MOST = 40
"""Readings of a search where steps alone do not lead to the minimum."""
MOST_CLUSTERS = 20_000
"""Turns or strokes on disk by which sums are kept apart; of more, neighbours are put together."""


@dataclass(frozen=True)
class Errors:
    """Of n rows: squares and largest magnitude of the residual in N, mean and squared deviations of the force."""

    n: int
    squares: float
    largest: float
    mean: float
    spread: float

    @classmethod
    def of(cls, residual: Array, force: Array) -> "Errors":
        """Of residual and force of some rows, (n,) each, in N."""
        mean = float(force.mean())
        spread = float(np.sum((force - mean) ** 2))
        return cls(len(force), float(np.sum(residual**2)), float(np.max(np.abs(residual))), mean, spread)

    def __add__(self, more: "Errors") -> "Errors":
        """Of both sets of rows (Chan, Golub & LeVeque 1983, Am. Statistician 37, 242)."""
        n, off = self.n + more.n, more.mean - self.mean
        spread = self.spread + more.spread + off**2 * self.n * more.n / n
        largest = max(self.largest, more.largest)
        return Errors(n, self.squares + more.squares, largest, self.mean + off * more.n / n, spread)

    @property
    def rmse(self) -> float:
        """Root mean square of the residual, N."""
        return math.sqrt(self.squares / self.n)

    @property
    def r2(self) -> float:
        """Coefficient of determination."""
        return 1.0 - self.squares / self.spread if self.spread > 0.0 else math.nan


@dataclass(frozen=True, eq=False)
class Chunk:
    """Some rows: force (n,) in N, and the number of the run (n − before,) along which a residual may be correlated,
    where it is asked for. The first `before` rows are of the record's first sample, from which effects may count."""

    inputs: Inputs
    force: Array
    run: Array | None
    before: int

    def whiten(self, rows: Array) -> Array:
        """Less what is before, (n, …) → (n − before, …)."""
        return rows[self.before :]


Chunks = Callable[[], Iterator[Chunk]]
"""Reads all rows once."""


def in_memory(record: Record, rows: Array, first: bool, clustered: bool = False) -> Chunks:
    """Some `rows` of a record (indices, ascending), each time with the `first` sample or without it."""
    run = clusters(record, rows) if clustered else None

    def chunks() -> Iterator[Chunk]:
        for begin in range(0, len(rows), CHUNK):
            part = rows[begin : begin + CHUNK]
            even = part[-1] - part[0] + 1 == len(part)
            taken = np.r_[0, part] if first else slice(part[0], part[-1] + 1) if even else part
            own = None if run is None else run[begin : begin + CHUNK]
            yield Chunk(record.inputs.take(taken), record.force[taken], own, int(first))

    return chunks


def on_disk(record: "LongRecord", branch: str, both: bool, first: bool) -> Chunks:
    """A branch of a record on disk; where it has `both` directions, residuals are taken as correlated along a turn."""
    each = -(-(record.last_run + 1) // MOST_CLUSTERS) if record.timed else 0

    def chunks() -> Iterator[Chunk]:
        done = 0
        for chunk, turn in record.chunks(full=first):
            tell("fitting", done, record.n)
            done += len(chunk) - 1
            mine = np.flatnonzero(chunk.on_branch(branch)[1:]) + 1
            if len(mine):
                run = (turn if both else chunk.stroke)[mine] // each if each else None
                rows = np.r_[0, mine] if len(mine) < len(chunk) - 1 else slice(None)
                yield Chunk(chunk.inputs.take(rows), chunk.force[rows], run, 1)

    return chunks


@dataclass(frozen=True, eq=False)
class Reading:
    """What all rows say at `q` (k,), the parameters that are searched."""

    problem: "Readings"
    q: Array
    sums: Sums

    @property
    def residual(self) -> Array:
        """Turned into the space of the sums, with the same products with the slopes, shape (·,)."""
        return self.sums.triangle[:, -1]

    @property
    def jacobian(self) -> Array:
        """Its derivative by q in that space, shape (·, k)."""
        return self.sums.triangle[:, self.problem.free]

    @property
    def cost(self) -> float:
        """Sum of squares of the residual."""
        found = self.sums.squares
        return found if math.isfinite(found) else math.inf


@dataclass(frozen=True, eq=False)
class Readings:
    """A model's least squares over rows that are read in chunks. `held` parameters stay, `nonlinear` are all others.

    `exact` keeps the triangle of each chunk, where Gram matrices would lose too many digits, and takes the slopes that
    a solver does: what is lost otherwise is lost in the scatter of very many rows.
    """

    model: Model
    chunks: Chunks
    held: Mapping[str, float]
    nonlinear: tuple[Param, ...]
    exact: bool = False

    @cached_property
    def free(self) -> list[int]:
        """Which parameters of the model are searched."""
        return [k for k, p in enumerate(self.model.params) if p.name not in self.held]

    def values(self, q: Array) -> dict[str, float]:
        """All parameters by name at the nonlinear ones q, shape (k,)."""
        return {**self.held, **dict(zip([p.name for p in self.nonlinear], q.tolist(), strict=True))}

    def at(self, q: Array) -> Reading:
        """Read all rows at parameters q (k,)."""
        values, n, parts, triangles = self.values(q), 0, [], []
        for chunk in self.chunks():
            found = self._table(chunk, values)
            n += len(found)
            parts.append(grams(found, chunk.run))
            if self.exact:
                triangles.append(sums(found).triangle)
        whole = joined(n, parts, triangles)
        return replace(self, exact=True).at(q) if whole is None else Reading(self, q, whole)

    def errors(self, q: Array) -> Errors:
        """What all rows leave at parameters q (k,)."""
        values, found = self.values(q), None
        for chunk in self.chunks():
            left = chunk.whiten(chunk.force - self.model.force(chunk.inputs, values))
            here = Errors.of(left, chunk.whiten(chunk.force))
            found = here if found is None else found + here
        assert found is not None
        return found

    def lead(self, values: Mapping[str, float]) -> tuple[Array, Sums, bool]:
        """From values near the minimum to it: where it is, (k,), the sums there, and whether it was reached; by steps
        alone where they shorten, else by a descent between them."""
        here = self.at(np.array([p.clip(values[p.name]) for p in self.nonlinear]))
        if not math.isfinite(here.cost):
            return here.q, here.sums, False
        here, step, done = settle(here)
        if not done:
            here, step, done = settle(descend(here, 1e-15, 1e-9, MOST)[0])
        way = np.zeros(len(self.model.params))
        way[self.free] = step
        return here.q + step, here.sums.after(way), done

    def _table(self, chunk: Chunk, values: Mapping[str, float]) -> Array:
        """As `solve.table`; if not `exact`, and where all nonlinear parameters are off their bounds, at less than its
        price: the mean of both ends of a difference spares what is between."""
        inputs, force = chunk.inputs, chunk.force
        linear, nonlinear = self.model.linear, self.model.bounded(inputs)[len(self.model.linear) :]
        steps = [STEP * max(abs(values[p.name]), 0.01 * p.scale) for p in nonlinear]
        inside = all(
            p.lower <= values[p.name] - s <= values[p.name] + s <= p.upper
            for p, s in zip(nonlinear, steps, strict=True)
        )
        if self.exact or not (inside and self.model.separable):
            return table(self.model, inputs, values, force, chunk.whiten)
        coefficients = np.array([values[p.name] for p in linear])

        def at(**moved: float) -> tuple[Array, Array]:
            columns, fixed = self.model.design(inputs, {**values, **moved}, force)
            return columns, fixed + columns @ coefficients

        found = np.empty((len(self.model.params) + 1, len(force)))
        (columns, low), (others, high) = [at()] * 2 if not nonlinear else [(force, force)] * 2
        for row, p, step in zip(found[len(linear) :], nonlinear, steps, strict=False):
            begin, end = values[p.name] - step, values[p.name] + step
            (columns, low), (others, high) = at(**{p.name: begin}), at(**{p.name: end})
            np.subtract(high, low, out=row)
            row /= end - begin
        found[: len(linear)] = (columns + others).T
        found[: len(linear)] *= 0.5
        np.subtract(0.5 * (low + high), force, out=found[-1])
        return chunk.whiten(found.T)


def least(
    model: Model,
    record: Record,
    rows: Array,
    every: Chunks,
    start: Mapping[str, float],
    held: Mapping[str, float],
    exact: bool = False,
) -> tuple[Readings, Array, Sums, bool]:
    """What `lead` says of `every` row, by way of samples of the `rows` (indices, (n,)) of a record, which is all or a
    part of these. `start` and `held` are as `solve` has them."""
    few, more = (rows[:: len(rows) // most | 1] for most in SAMPLES)
    begin = np.r_[0, few]
    inputs, force = record.inputs.take(begin), record.force[begin]
    values = solve(model, inputs, force, lambda m: m[1:], start, quick=True, held=held).values
    nonlinear = tuple(p for p in model.bounded(record.inputs) if p.name not in held)
    near = Readings(model, in_memory(record, more, bool(model.terms)), held, nonlinear, exact)
    whole = replace(near, chunks=every)
    return whole, *whole.lead(near.values(near.lead(values)[0]))


def with_memory(model: Model, inputs: Inputs, force: Array) -> list[Term]:
    """The terms whose columns at a sample hang on what lies between the record's first sample and it.

    So their forms say, or so it shows where stretches of some samples (`inputs`, force (n,) in N) stand alone with the
    first: an effect of one's own may not say it.
    """
    stretches = [np.r_[0, rows] for rows in np.array_split(np.arange(len(inputs)), 7)]

    def remembers(term: Term) -> bool:
        if term.form.remembers:
            return True
        shape = {p.name: p.start for p in term.form.nonlinear}
        whole = term.form.columns(inputs, shape, force)
        apart = (term.form.columns(inputs.take(rows), shape, force[rows]) for rows in stretches)
        return not all(np.allclose(a, whole[rows], 1e-9, 1e-12) for a, rows in zip(apart, stretches, strict=True))

    return [term for term in model.terms if remembers(term)]
