"""Solvers: objects that take a Problem to its Solution, and lmfit's answers beside ours; `Model.to_lmfit` leads there.

What is heavy is imported when a solver is asked to solve.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from ..core import Array, Param, UsageError
from ..core.lmfit_names import from_lmfit_names, to_lmfit_name, to_parameters
from .descent import descend, settle
from .problem import Problem, Solution

if TYPE_CHECKING:
    import jax
    import lmfit
    from lmfit.minimizer import MinimizerResult
    from lmfit.model import ModelResult

    from .fit import Fit


class Solver(Protocol):
    """Anything that solves a Problem within the bounds of its parameters."""

    def solve(self, problem: Problem) -> Solution:
        """The best parameters found, and whether the search converged."""
        ...


@dataclass(frozen=True)
class VariableProjection:
    """Linear parameters are eliminated at each trial of the nonlinear ones, which a trust region searches.

    Of all starts, `max_starts` at most, the `keep` best are followed down, and from the lowest the search goes on until
    rounding stops it, unless not `polish`. Then what has no hope of a sum of squares below `enough` is given up.
    """

    max_starts: int = 24
    keep: int = 2
    polish: bool = True
    enough: float = math.inf

    def solve(self, problem: Problem) -> Solution:
        """The best of the descents; exact at once where nothing is nonlinear."""
        if not problem.nonlinear:
            return Solution(problem.at(np.empty(0)).values, True, "linear")
        starts = replace(problem, rough=True).starts(self.max_starts)[: self.keep]
        found = [descend(trial, 2e-6, 1e-5, 25, self.enough) for trial in starts]
        best, status, message = min(found, key=lambda one: one[0].cost)
        if self.polish:
            best, status, message = descend(problem.at(best.q), 1e-15, 1e-9, 200)
            if status > 0:
                best, step, _ = settle(best)
                best = problem.at(best.q + step) if step.any() else best
        return Solution(best.values, status > 0, message)


QUICK = VariableProjection(keep=1, polish=False)
"""One descent to about 1e-8, for the many refits of a diagnosis."""


@dataclass(frozen=True)
class LevenbergMarquardt:
    """All parameters at once by optimistix in double precision, to which it sets JAX; bounds by a smooth transform.

    Begins where `start` says, else at the best of `max_starts` starts; ends after `steps`, or when the parameters in
    units of their typical sizes and the sum of squares in units of the first change by less than `tolerance`.
    """

    max_starts: int = 24
    tolerance: float = 1e-12
    steps: int = 2000

    def solve(self, problem: Problem) -> Solution:
        """Where the search ended, and optimistix's own word on how.

        What ended on a bound is held there while the others are searched again: where the transform is flat, damped
        steps come near, but no nearer.
        """
        if not problem.params:
            return Solution({}, True, "all at bounds")
        import jax
        import optimistix

        jax.config.update("jax_enable_x64", True)
        begin = problem.begin(self.max_starts)
        free = _Unbounded(problem, begin)
        found = optimistix.least_squares(
            free.traceable(),
            optimistix.LevenbergMarquardt(rtol=self.tolerance, atol=self.tolerance),
            jax.numpy.asarray(free.outer(begin)),
            max_steps=self.steps,
            throw=False,
        )
        done = bool(found.result == optimistix.RESULTS.successful)
        message = "converged" if done else str(optimistix.RESULTS[found.result])
        values = free.inner(np.asarray(found.value))
        held = free.at_bounds(values)
        if not held:
            return Solution(values, done, message)
        rest = self.solve(replace(problem, start=values).holding(**held))
        return replace(rest, values=rest.values | held)


class _Unbounded:
    """A problem in variables u (k,) that know neither bounds nor units, its residual in units of that at `begin`.

    A sine between two bounds, a root above or below one: James & Roos 1975, Comput. Phys. Commun. 10, 343–367.
    """

    def __init__(self, problem: Problem, begin: Mapping[str, float]) -> None:
        self.problem = problem
        self.unit = {p.name: p.typical(begin[p.name]) for p in problem.params}
        self.norm = float(np.linalg.norm(problem.residual(begin))) or 1.0

    def outer(self, values: Mapping[str, float]) -> Array:
        """u of values strictly within their bounds."""
        return np.array([self._outer(p, values[p.name]) for p in self.problem.params])

    def inner(self, u: Array) -> dict[str, float]:
        """Values within their bounds of any u."""
        return {p.name: p.clip(self._inner(p, x)[0]) for p, x in zip(self.problem.params, map(float, u), strict=True)}

    def at_bounds(self, values: Mapping[str, float]) -> dict[str, float]:
        """Bounds that values have reached, by name."""
        nearest = {p.name: min((p.lower, p.upper), key=lambda b: abs(b - values[p.name])) for p in self.problem.params}
        return {name: b for name, b in nearest.items() if abs(b - values[name]) < 1e-6 * self.unit[name]}

    def residual(self, u: Array) -> Array:
        """Residual (m,) at u."""
        return self.problem.residual(self.inner(u)) / self.norm

    def jacobian(self, u: Array) -> Array:
        """Its derivative by u, shape (m, k); 0 where it is no number."""
        slopes = [self._inner(p, x)[1] for p, x in zip(self.problem.params, map(float, u), strict=True)]
        with np.errstate(over="ignore", invalid="ignore"):
            found = self.problem.jacobian(self.inner(u)) * slopes / self.norm
        return np.nan_to_num(found, posinf=0.0, neginf=0.0)

    def traceable(self) -> "Callable[[jax.Array, object], jax.Array]":
        """The residual as JAX may trace it: it calls back to NumPy, for the derivative as well."""
        import jax

        m, k = len(self.problem.whiten(self.problem.target)), len(self.problem.params)
        value, slope = (jax.ShapeDtypeStruct(shape, np.float64) for shape in ((m,), (m, k)))

        @jax.custom_jvp
        def residual(u):
            return jax.pure_callback(lambda x: self.residual(np.asarray(x)), value, u)

        @residual.defjvp
        def derivative(primals, tangents):
            matrix = jax.pure_callback(lambda x: self.jacobian(np.asarray(x)), slope, *primals)
            return residual(*primals), matrix @ tangents[0]

        return lambda u, _: residual(u)

    def _outer(self, p: Param, x: float) -> float:
        unit, half = self.unit[p.name], 0.5 * (p.upper - p.lower)
        if math.isfinite(half):
            return math.asin((x - p.lower) / half - 1.0) * half / unit
        away = x - p.lower if math.isfinite(p.lower) else p.upper - x
        return math.sqrt((away / unit + 1.0) ** 2 - 1.0) if math.isfinite(away) else x / unit

    def _inner(self, p: Param, u: float) -> tuple[float, float]:
        """Value and its derivative by u."""
        unit, half = self.unit[p.name], 0.5 * (p.upper - p.lower)
        if math.isfinite(half):
            return p.lower + half * (1.0 + math.sin(u * unit / half)), unit * math.cos(u * unit / half)
        root = math.hypot(u, 1.0)
        if math.isfinite(p.lower):
            return p.lower + unit * (root - 1.0), unit * u / root
        if math.isfinite(p.upper):
            return p.upper - unit * (root - 1.0), -unit * u / root
        return u * unit, unit


@dataclass(frozen=True)
class Lmfit:
    """All parameters at once by lmfit's Minimizer and one of its methods; bounds are lmfit's own.

    Raises UsageError for a method that lmfit does not have: by itself it would take Nelder–Mead without a word.
    """

    method: str = "leastsq"
    max_starts: int = 24

    def __post_init__(self) -> None:
        from lmfit.minimizer import SCALAR_METHODS

        own = {"leastsq", "least_squares", "ampgo", "basinhopping", "brute", "dual_annealing", "shgo"}
        known = own.union(SCALAR_METHODS)
        if self.method not in known:
            raise UsageError(f"lmfit has no method {self.method!r}; it has {', '.join(sorted(known))}")

    def solve(self, problem: Problem) -> Solution:
        """Where the search ended, and lmfit's own word on how."""
        import lmfit

        def values(parameters: "lmfit.Parameters") -> dict[str, float]:
            return from_lmfit_names(parameters.valuesdict())

        begin = problem.begin(self.max_starts)
        parameters = to_parameters((p, begin[p.name]) for p in problem.params)
        search = lmfit.Minimizer(lambda at: problem.residual(values(at)), parameters, calc_covar=False)
        slopes = {"Dfun": lambda at: problem.jacobian(values(at))} if self.method == "leastsq" else {}
        found: Any = search.minimize(method=self.method, **slopes)
        return Solution(values(found.params), bool(found.success), str(found.message))


def from_lmfit(result: "ModelResult | MinimizerResult") -> dict[str, float]:
    """Parameter values of an lmfit result by our names."""
    return from_lmfit_names(result.params.valuesdict())  # pyright: ignore[reportAttributeAccessIssue]


def lmfit_result(fit: "Fit") -> "ModelResult":
    """A Fit as lmfit's ModelResult, for `fit_report()` and `conf_interval()`.

    lmfit fits the same rows again, with their weights, from the Fit's own values, so its errors and correlations are
    its own work; it takes the noise as white. What is held, stands at a bound, or is not identified, stays fixed: lmfit
    could give no error of the others beside it.
    """
    model, parameters = fit.model.to_lmfit(fit.record.inputs, fit.rows)
    for one in fit.estimates:
        parameters[to_lmfit_name(one.name)].set(value=one.value, vary=one.name in fit.free and one.identified)
    weights = None if fit.weights is None else fit.weights[fit.rows]
    return model.fit(fit.record.force[fit.rows], parameters, weights=weights, inputs=fit.record.inputs)
