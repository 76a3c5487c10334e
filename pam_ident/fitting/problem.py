"""Separable least squares with bounds, as a noun that knows no muscle: what a solver is given and what it answers.

Golub & Pereyra 1973, SIAM J. Numer. Anal. 10, 413–432 (variable projection).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import islice, product

import numpy as np

from ..core import Array, Param, UsageError

Design = Callable[[Mapping[str, float]], tuple[Array, Array]]
Whiten = Callable[[Array], Array]
"""Selects rows and decorrelates noise: (n,) or (n, k) → (m,) or (m, k), linear."""
HUGE = 1e60
"""Residual beyond which a trial point is simply bad: its square must stay a number."""
FLAT = 1e-9
"""Share of a slope that the linear parameters must leave: the rest is rounding, and a step along it chance."""
STEP = 1e-5
"""Step of central differences in units of a parameter's typical size."""


@dataclass(frozen=True)
class Solution:
    """Where a search ended: values by name, and whether it converged with what message."""

    values: dict[str, float]
    converged: bool
    message: str


def all_rows(rows: Array) -> Array:
    """Rows, shape (n, …), as they are: a problem in which none is left out and the noise is white."""
    return rows


@dataclass(frozen=True, eq=False)
class Problem:
    """Minimise |whiten(fixed + columns · linear − target)|² over `linear` and `nonlinear`, within their bounds.

    `design(values)` gives columns (n, len(linear)) and fixed part (n,) at the nonlinear parameters in `values`;
    `target` has shape (n,), and `whiten`, which is linear, makes m rows of n. A nonlinear parameter named in `start`
    begins there, another at each value of its grid, or at its own start where it has none. `rough` asks projections for
    slopes by one-sided differences, at half the price. `slopes(values)`, (n, len(nonlinear)), are those of a design
    without linear parameters where they are known.
    """

    linear: tuple[Param, ...]
    nonlinear: tuple[Param, ...]
    design: Design
    target: Array
    start: Mapping[str, float] = field(default_factory=dict)
    whiten: Whiten = all_rows
    rough: bool = False
    slopes: Callable[[Mapping[str, float]], Array] | None = None

    @property
    def params(self) -> tuple[Param, ...]:
        """All parameters: linear, then nonlinear; the order of the Jacobian's columns."""
        return self.linear + self.nonlinear

    def at(self, q: Array) -> "Projection":
        """The projection at nonlinear parameters (k,); a residual of HUGE where the design is not finite."""
        point = dict(zip([p.name for p in self.nonlinear], map(float, q), strict=True))
        columns, fixed = self.design(point)
        packed = np.empty((len(self.target), len(self.linear) + 1), order="F")  # as LAPACK reads it
        packed[:, :-1], packed[:, -1] = columns, self.target - fixed
        packed = self.whiten(packed)
        triangle: Array = np.linalg.qr(packed, mode="r")  # pyright: ignore
        known = bool(np.all(np.abs(triangle) < HUGE))
        coefficients = within_bounds(triangle, *bounds(self.linear)) if known else np.empty(0)
        if not (known and np.all(np.isfinite(coefficients))):
            coefficients = np.array([p.start for p in self.linear])
            return Projection(self, q, point, np.zeros_like(packed[:, :-1]), coefficients, np.full(len(packed), HUGE))
        columns, goal = packed[:, :-1], packed[:, -1]
        return Projection(self, q, point, columns, coefficients, np.clip(columns @ coefficients - goal, -HUGE, HUGE))

    def residual(self, values: Mapping[str, float]) -> Array:
        """whiten(model − target), shape (m,); entries that are no number, or beyond it, are HUGE."""
        columns, fixed = self.design(values)
        coefficients = self._coefficients(values)
        with np.errstate(over="ignore", invalid="ignore"):
            found = self.whiten(fixed + columns @ coefficients - self.target)
            return np.nan_to_num(np.clip(found, -HUGE, HUGE), nan=HUGE)

    def jacobian(self, values: Mapping[str, float]) -> Array:
        """Derivative of the residual (m, len(params)): linear columns are exact, nonlinear ones central differences."""
        return self.table(values)[:, :-1]

    def table(self, values: Mapping[str, float]) -> Array:
        """The Jacobian and the residual as they are, side by side, shape (m, len(params) + 1)."""
        columns, fixed = self.design(values)
        coefficients = self._coefficients(values)
        k = len(coefficients)
        found = np.empty((len(self.target), len(self.params) + 1))
        with np.errstate(over="ignore", invalid="ignore"):
            found[:, :k], found[:, k:-1] = columns, self._slopes(values, coefficients)
            found[:, -1] = fixed + columns @ coefficients - self.target
        return self.whiten(found)

    def _slopes(self, values: Mapping[str, float], coefficients: Array) -> Array:
        """d(fixed + columns · coefficients)/d(nonlinear), shape (n, k), by second-order differences in the bounds."""
        if self.slopes is not None:
            return self.slopes(values)
        found = np.empty((len(self.target), len(self.nonlinear)))
        for k, p in enumerate(self.nonlinear):
            at = values[p.name]
            step = _step(p, at)
            low, high = at - step, at + step
            if p.lower <= low and high <= p.upper:
                points, span = (low, high), high - low
            else:  # at a bound: from its inner side, as exact
                span = 2.0 * (step if high <= p.upper else -step)
                points = (at, at + 0.5 * span, at + span)
            with np.errstate(over="ignore", invalid="ignore"):
                taken = zip(*(self.design({**values, p.name: point}) for point in points), strict=True)
                columns, fixed = (b - a if not c else 4.0 * b - 3.0 * a - c[0] for a, b, *c in taken)
                found[:, k] = (fixed + columns @ coefficients) / span
        return found

    def curved(self) -> "Problem":
        """The same problem with all its parameters among the nonlinear ones, and their slopes."""

        def force(values: Mapping[str, float]) -> tuple[Array, Array]:
            columns, fixed = self.design(values)
            return np.empty((len(fixed), 0)), fixed + columns @ self._coefficients(values)

        def slopes(values: Mapping[str, float]) -> Array:
            return np.column_stack([self.design(values)[0], self._slopes(values, self._coefficients(values))])

        return replace(self, linear=(), nonlinear=self.params, design=force, slopes=slopes)

    def _coefficients(self, values: Mapping[str, float]) -> Array:
        return np.array([values[p.name] for p in self.linear])

    def holding(self, **values: float) -> "Problem":
        """The same problem with parameters held at values, which no longer count among its own.

        Raises UsageError for a name that is no parameter of the problem.
        """
        unknown = set(values) - {p.name for p in self.params}
        if unknown:
            known = ", ".join(p.name for p in self.params)
            raise UsageError(f"cannot hold {', '.join(sorted(unknown))}; the free parameters are {known}")
        if not values:
            return self
        moved = [k for k, p in enumerate(self.linear) if p.name in values]
        kept = [k for k, p in enumerate(self.linear) if p.name not in values]
        coefficients = np.array([values[self.linear[k].name] for k in moved])
        free = [k for k, p in enumerate(self.nonlinear) if p.name not in values]
        known = self.slopes

        def design(free: Mapping[str, float]) -> tuple[Array, Array]:
            columns, fixed = self.design({**free, **values})
            return columns[:, kept], fixed + columns[:, moved] @ coefficients

        return replace(
            self,
            linear=tuple(self.linear[k] for k in kept),
            nonlinear=tuple(p for p in self.nonlinear if p.name not in values),
            design=design,
            slopes=None if known is None else lambda rest: known({**rest, **values})[:, free],
            start={name: value for name, value in self.start.items() if name not in values},
        )

    def starts(self, most: int) -> "list[Projection]":
        """Projections at no more than `most` starts of the nonlinear parameters, that of the smallest error first."""
        lower, upper = bounds(self.nonlinear)
        grids = [(self.start[p.name],) if p.name in self.start else p.grid or (p.start,) for p in self.nonlinear]
        found = [self.at(np.clip(np.array(q), lower, upper)) for q in islice(product(*grids), most)]
        return sorted(found, key=lambda trial: trial.cost)

    def begin(self, most: int) -> dict[str, float]:
        """A start of all parameters by name, off their bounds: as `start` has it, else the best of `starts`."""
        values = self.starts(most)[0].values | dict(self.start)
        return {p.name: p.inside(values[p.name]) for p in self.params}


@dataclass(frozen=True, eq=False)
class Projection:
    """A problem at `q`, by name `point`: whitened columns (m, k), best coefficients (k,), residual (m,)."""

    problem: Problem
    q: Array
    point: dict[str, float]
    columns: Array
    coefficients: Array
    residual: Array

    @property
    def values(self) -> dict[str, float]:
        """All parameters by name, nonlinear and linear."""
        return self.point | {p.name: float(x) for p, x in zip(self.problem.linear, self.coefficients, strict=True)}

    @property
    def cost(self) -> float:
        """Sum of squares of the residual."""
        return float(self.residual @ self.residual)

    @cached_property
    def jacobian(self) -> Array:
        """Derivative of the projected residual by the nonlinear parameters, shape (m, len(nonlinear)).

        The slopes at fixed coefficients, less what the linear ones that are not at a bound follow: Kaufman 1975, BIT
        15, 49–57. The gradient Jᵀr is exact, because the residual is normal to those columns.
        """
        slopes = self._rough() if self.problem.rough and self.problem.slopes is None else self._slopes()
        slopes = np.nan_to_num(slopes, posinf=0.0, neginf=0.0)
        lower, upper = bounds(self.problem.linear)
        free = (self.coefficients > lower) & (self.coefficients < upper)
        columns = self.columns if np.all(free) else self.columns[:, free]
        triangle: Array = np.linalg.qr(np.column_stack([columns, slopes]), mode="r")  # pyright: ignore
        left = slopes - columns @ _lstsq(triangle, columns.shape[1])
        return left * (norms(left) > FLAT * np.linalg.norm(slopes, axis=0))

    def _slopes(self) -> Array:
        return self.problem.whiten(self.problem._slopes(self.point, self.coefficients))

    def _rough(self) -> Array:
        """The same by one difference each, inward at an upper bound."""
        problem, found = self.problem, np.empty((len(self.residual), len(self.problem.nonlinear)))
        for k, p in enumerate(problem.nonlinear):
            at = self.point[p.name]
            step = _step(p, at)
            step = step if at + step <= p.upper else -step
            columns, fixed = problem.design({**self.point, p.name: at + step})
            with np.errstate(over="ignore", invalid="ignore"):
                there = problem.whiten(fixed + columns @ self.coefficients - problem.target)
                found[:, k] = (there - self.residual) / step
        return found


def _step(p: Param, at: float) -> float:
    return STEP * max(abs(at), 0.01 * p.scale if p.scale != 1.0 else 1e-3)


def bounds(params: Sequence[Param]) -> tuple[Array, Array]:
    """Lower and upper bounds, each of shape (len(params),)."""
    return np.array([p.lower for p in params]), np.array([p.upper for p in params])


def within_bounds(triangle: Array, lower: Array, upper: Array) -> Array:
    """Least squares within bounds (k,), from R (·, k + 1) of the QR decomposition of [columns, target]."""
    if not len(lower):
        return np.empty(0)
    x = _lstsq(triangle, len(lower))[:, 0]
    if np.all((x >= lower) & (x <= upper)):
        return x
    scale = norms(triangle[:, :-1])
    found = _bounded(triangle[:, :-1] / scale, triangle[:, -1], x * scale, lower * scale, upper * scale)
    return np.clip(found / scale, lower, upper)


def _bounded(matrix: Array, goal: Array, x: Array, lower: Array, upper: Array) -> Array:
    """Least |matrix · x − goal| within bounds, from the free solution x (k,).

    Stark & Parker 1995, Computational Statistics 10, 129–141.
    """
    at = np.where(x <= lower, -1.0, np.where(x >= upper, 1.0, 0.0))
    x = np.clip(x, lower, upper)
    for _ in range(10 * len(x)):
        free = at == 0.0
        wish = x.copy()
        wish[free] = np.linalg.lstsq(matrix[:, free], goal - matrix[:, ~free] @ x[~free], rcond=1e-12)[0]
        over = (wish < lower) | (wish > upper)
        if over.any():  # as far as the first bound
            room = np.where(wish < lower, lower, upper) - x
            share = np.divide(room, wish - x, out=np.full(len(x), np.inf), where=over)
            first = int(np.argmin(share))
            x = x + share[first] * (wish - x)
            at[first] = 1.0 if wish[first] > upper[first] else -1.0
            x[first] = upper[first] if at[first] > 0.0 else lower[first]
            continue
        x = wish
        pull = matrix.T @ (goal - matrix @ x) * -at  # positive where letting go would help
        pull[free] = 0.0
        if np.max(pull) <= 1e-12 * np.linalg.norm(goal):
            break
        at[int(np.argmax(pull))] = 0.0
    return x


def _lstsq(triangle: Array, k: int) -> Array:
    """Least squares of each later column of R by its first k, shape (k, columns − k); minimum norm if flat."""
    scale = norms(triangle[:, :k])
    return np.linalg.lstsq(triangle[:, :k] / scale, triangle[:, k:], rcond=1e-12)[0] / scale[:, None]


def norms(columns: Array) -> Array:
    """Norms of columns (m, k), 1 where a column is nothing, shape (k,)."""
    scale = np.linalg.norm(columns, axis=0)
    scale[scale == 0.0] = 1.0
    return scale
