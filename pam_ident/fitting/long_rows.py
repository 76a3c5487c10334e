"""What readings of a record on disk say of a model: chunk by chunk, for several branches at once."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from ..core import Inputs
from ..core.progress import tell
from ..model import Model
from ..records.long import LongRecord
from .covariance import Sums
from .problem import Problem
from .solve import jacobian, separated, whole

Array = np.ndarray
Values = Mapping[str, float]
MOST_CLUSTERS = 20_000
"""Turns or strokes by which sums are kept apart; of more, neighbours are put together."""
SIGNS = {"contraction": 1.0, "extension": -1.0}


@dataclass(frozen=True)
class Summary:
    """What all fitted rows say of a fit: how many, their errors in N, and the coefficient of determination."""

    n: int
    rmse: float
    max_error: float
    r2: float


UNREAD = Summary(0, math.nan, math.nan, math.nan)


@dataclass(frozen=True, eq=False)
class _Part:
    """A branch's rows of a chunk, the record's first sample before them; force (n,) in N and their `run` (n,)."""

    inputs: Inputs
    force: Array
    run: Array

    def problem(self, model: Model, held: Values) -> Problem:
        """The least squares of these rows, without the sample before them."""
        make = separated if model.separable else whole
        return make(model, self.inputs, self.force, {}, _without_first).holding(**held)


def _without_first(rows: Array) -> Array:
    return rows[1:]


@dataclass(frozen=True, eq=False)
class Rows:
    """A record on disk, read for a model with `held` parameters. `both` names the branches that hold both directions,
    whose residuals are taken as correlated within a turn and not within a stroke."""

    model: Model
    record: LongRecord
    held: Values
    both: frozenset[str]

    def triangles(self, points: Mapping[str, Values]) -> dict[str, Array]:
        """R, shape (k + 1, k + 1), of the QR decomposition of Jacobian and residual over all rows of a branch.

        Joined chunk by chunk (Demmel et al. 2012, SIAM J. Sci. Comput. 34, A206–A239), which unlike sums of squares
        loses no digits. The columns are the parameters that are not held.
        """
        found: dict[str, Array] = {}
        for name, part in self._parts(tuple(points)):
            problem = part.problem(self.model, self.held)
            with np.errstate(over="ignore", invalid="ignore"):
                table = np.column_stack([problem.jacobian(points[name]), problem.residual(points[name])])
            both = (found[name], _triangle(table)) if name in found else (table,)
            found[name] = _triangle(np.concatenate(both))
        return found

    def sums(self, points: Mapping[str, Values]) -> dict[str, tuple[Sums, Summary]]:
        """For errors of all parameters: sums over the rows of each branch at a point, by turn or stroke; and errors."""
        runs = self.record.last_run + 1 if self.record.timed else 0
        tallies = {name: _Tally(len(self.model.params), -(-runs // MOST_CLUSTERS)) for name in points}
        for name, part in self._parts(tuple(points)):
            left = part.force - self.model.force(part.inputs, points[name])
            slopes = jacobian(self.model, part.inputs, points[name], part.force)
            tallies[name].add(slopes[1:], left[1:], part.force[1:], part.run[1:])
        return {name: one.result() for name, one in tallies.items()}

    def _parts(self, branches: tuple[str, ...]) -> Iterator[tuple[str, _Part]]:
        done = 0
        for chunk, turn in self.record.chunks(full=bool(self.model.terms)):
            tell("fitting", done, self.record.n)
            done += len(chunk)
            for name in branches:
                run = turn if name in self.both else chunk.stroke
                if name == "together":
                    yield name, _Part(chunk.inputs, chunk.force, run)
                    continue
                mine = chunk.inputs.direction == SIGNS[name]
                mine[0] = True
                if mine[1:].any():
                    yield name, _Part(chunk.inputs.take(mine), chunk.force[mine], run[mine])


def _triangle(table: Array) -> Array:
    return np.linalg.qr(table, mode="r")  # pyright: ignore


@dataclass
class _Tally:
    """Sums over the rows that come: `each` neighbouring runs are a cluster, none is one where it is 0."""

    k: int
    each: int
    n: int = 0
    triangle: Array | None = None
    squares: float = 0.0
    largest: float = 0.0
    mean: float = 0.0
    spread: float = 0.0
    clusters: list[int] = field(default_factory=list)
    tables: list[Array] = field(default_factory=list)

    def add(self, slopes: Array, left: Array, force: Array, run: Array) -> None:
        """Jacobian (m, k), residual (m,) and force (m,) in N, and run (m,) of some rows."""
        table = np.column_stack([slopes, left])
        parts = [_triangle(slopes)] if self.triangle is None else [self.triangle, _triangle(slopes)]
        self.triangle = _triangle(np.concatenate(parts))
        self.squares += float(left @ left)
        self.largest = max(self.largest, float(np.max(np.abs(left))))
        self._spread(force)
        if not self.each:
            return
        cluster = run // self.each
        edges = np.flatnonzero(np.diff(cluster)) + 1
        for begin, piece in zip([0, *edges], np.split(table, edges), strict=True):
            if not self.clusters or cluster[begin] != self.clusters[-1]:
                self.clusters.append(int(cluster[begin]))
                self.tables.append(np.zeros((self.k + 1, self.k + 1)))
            self.tables[-1] += piece.T @ piece

    def _spread(self, force: Array) -> None:
        """Mean and sum of squared deviations of more forces (Chan, Golub & LeVeque 1983, Am. Statistician 37, 242)."""
        m, mean = len(force), float(force.mean())
        off = mean - self.mean
        self.n += m
        self.spread += float(np.sum((force - mean) ** 2)) + off**2 * m * (self.n - m) / self.n
        self.mean += off * m / self.n

    def result(self) -> tuple[Sums, Summary]:
        """The sums, with a Gram matrix for each cluster, and the errors."""
        assert self.triangle is not None
        k = self.k
        tables = np.array(self.tables).reshape(-1, k + 1, k + 1)
        sums = Sums(self.n, self.triangle, self.squares, tables[:, :k, :k], tables[:, :k, k])
        r2 = 1.0 - self.squares / self.spread if self.spread > 0.0 else math.nan
        return sums, Summary(self.n, math.sqrt(self.squares / self.n), self.largest, r2)
