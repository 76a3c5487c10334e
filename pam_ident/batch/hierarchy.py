"""One fit over several muscles: parameters that all share, and parameters of each that scatter about a mean.

Own parameters are taken from a normal distribution whose mean and standard deviation are fitted too (restricted maximum
likelihood by expectation and maximisation; Dempster, Laird & Rubin 1977, J. R. Stat. Soc. B 39, 1–38): a muscle whose
record says little is drawn to the others, and one that was not measured is predicted by the mean.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ..core import Array, Inputs, UsageError
from ..fitting import Problem, VariableProjection
from ..fitting.together import stacked
from ..model import Model
from ..records import Record

ROUNDS = 200
SETTLED = 1e-5
WIDEST = 1e6
"""Prior standard deviation at the start, in typical sizes of a parameter: muscles do not know of each other yet."""

NARROWEST = 1e-6
"""Below this, in the same unit, muscles are taken to be alike."""


@dataclass(frozen=True)
class Muscles:
    """A model fitted to several muscles. `values` are those that all share and the means of the own ones, `stderr`
    their standard errors (residuals taken as white), `scatter` the own ones' standard deviation from muscle to muscle.

    `own` are values by muscle, `rmse` the error in N of each; `noise` the standard deviation in N over all.
    """

    model: Model
    values: Mapping[str, float]
    stderr: Mapping[str, float]
    scatter: Mapping[str, float]
    own: tuple[Mapping[str, float], ...]
    rmse: tuple[float, ...]
    noise: float
    converged: bool

    def force(self, inputs: Inputs) -> Array:
        """Force in N, shape (n,), of a muscle that was not measured: its own parameters are the means."""
        return self.model.force(inputs, self.values)


def fit_muscles(model: Model, records: Sequence[Record], own: Sequence[str] = ()) -> Muscles:
    """Fit `model` to all records at once; parameters named in `own` are each muscle's.

    Raises UsageError for an unknown name, own parameters with one record, or an effect that acts on the force itself.
    """
    _check(model, records, own)
    params = {p.name: p for p in model.bounded(records[0].inputs)}
    at = _Stage({}, np.array([WIDEST * params[name].scale for name in own]), 1.0, {}, False)
    for _ in range(ROUNDS):
        before, at = at, _improve(model, records, own, at)
        if np.allclose(at.tau, before.tau, rtol=SETTLED) and (not own or np.isclose(at.noise, before.noise)):
            break
    else:
        at = replace(at, converged=False)
    each = tuple({name: at.values[_of(name, k)] for name in own} for k in range(len(records)))
    values = {name: at.values[name] for name in params}
    rmse = tuple(
        float(np.sqrt(np.mean((model.force(r.inputs, values | mine) - r.force) ** 2)))
        for r, mine in zip(records, each, strict=True)
    )
    stderr = {name: at.stderr[name] for name in params}
    scatter = dict(zip(own, map(float, at.tau), strict=True))
    return Muscles(model, values, stderr, scatter, each, rmse, at.noise, at.converged)


@dataclass(frozen=True)
class _Stage:
    """A round of the search: all values and standard errors by name, scatter of the own parameters, noise."""

    values: Mapping[str, float]
    tau: Array
    noise: float
    stderr: Mapping[str, float]
    converged: bool


def _improve(model: Model, records: Sequence[Record], own: Sequence[str], at: _Stage) -> _Stage:
    """The values that a scatter leads to, and the scatter and noise that these lead to."""
    rows = sum(map(len, records))
    problem = _problem(model, records, own, at.noise / at.tau, at.values)
    found = VariableProjection().solve(problem)
    jacobian, residual = problem.jacobian(found.values), problem.residual(found.values)
    sizes = np.maximum(np.linalg.norm(jacobian, axis=0), 1e-300)
    root = np.linalg.pinv(jacobian / sizes) / sizes[:, None]
    spent = float(np.sum((jacobian[:rows] @ root) ** 2))
    noise = float(np.sqrt(np.sum(residual[:rows] ** 2) / max(rows - spent, 1.0)))
    tau = _scatter(problem, own, len(records), found.values, noise * root)
    errors = map(float, noise * np.linalg.norm(root, axis=1))
    stderr = dict(zip((p.name for p in problem.params), errors, strict=True))
    return _Stage(found.values, tau, noise, stderr, found.converged)


def _check(model: Model, records: Sequence[Record], own: Sequence[str]) -> None:
    unknown = sorted(set(own) - set(model.names))
    if unknown:
        raise UsageError(f"no parameter {unknown[0]!r} in {model.law.name}; it has {', '.join(model.names)}")
    if own and len(records) < 2:
        raise UsageError("own parameters need two muscles or more; give more records, or share all parameters")
    if not model.separable:
        raise UsageError("an effect of the model depends on the force itself; muscles are fitted together without it")


def _of(name: str, muscle: int) -> str:
    return f"{name}[{muscle}]"


def _problem(
    model: Model, records: Sequence[Record], own: Sequence[str], weight: Array, start: Mapping[str, float]
) -> Problem:
    """All samples, then a row for each muscle and own parameter: weight · (its value − the mean)."""
    params, linear = model.bounded(records[0].inputs), len(model.linear)
    parts = [
        Problem(params[:linear], params[linear:], partial(model.design, one.inputs, force=one.force), one.force)
        for one in records
    ]
    samples = stacked(parts, set(model.names) - set(own))
    means = tuple(p for p in params if p.name in own)
    columns_of = samples.linear + means
    where = {p.name: k for k, p in enumerate(columns_of)}
    priors = [(name, _of(name, k), float(w)) for k in range(len(records)) for name, w in zip(own, weight, strict=True)]

    def design(values: Mapping[str, float]) -> tuple[Array, Array]:
        columns, fixed = samples.design(values)
        prior, offset = np.zeros((len(priors), len(columns_of))), np.zeros(len(priors))
        for row, (mean, mine, w) in enumerate(priors):
            prior[row, where[mean]] = -w
            if mine in where:
                prior[row, where[mine]] = w
            else:
                offset[row] = w * values[mine]
        wider = np.pad(columns, ((0, 0), (0, len(means))))
        return np.vstack([wider, prior]), np.concatenate([fixed, offset])

    target = np.concatenate([samples.target, np.zeros(len(priors))])
    return Problem(columns_of, samples.nonlinear, design, target, start)


def _scatter(problem: Problem, own: Sequence[str], count: int, values: Mapping[str, float], root: Array) -> Array:
    """Standard deviations (own,) that the muscles' deviations from the mean, and what is not known of them, expect.

    `root` times its transpose is the covariance of the parameters.
    """
    params = {p.name: p for p in problem.params}
    where = {name: k for k, name in enumerate(params)}
    found = []
    for name in own:
        square = 0.0
        for k in range(count):
            unknown = root[where[_of(name, k)]] - root[where[name]]
            square += (values[_of(name, k)] - values[name]) ** 2 + float(unknown @ unknown)
        found.append(max(float(np.sqrt(square / count)), NARROWEST * params[name].scale))
    return np.array(found)
