"""Fit a model to a record."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..core import DataError, FitError
from ..model import Model
from ..records import Record
from .solve import curved_within_bounds, jacobian, solve

Array = np.ndarray


@dataclass(frozen=True)
class Estimate:
    """One fitted parameter. `stderr` is NaN where the record does not determine it."""

    name: str
    unit: str
    doc: str
    value: float
    stderr: float
    at_bound: bool
    identified: bool


@dataclass(frozen=True)
class Fit:
    """A model fitted to the rows `rows` (mask, shape (n,)) of a record; force and residual cover all n rows.

    `valid` needs convergence and every parameter identified; `problems` says in words what is wrong.
    """

    model: Model
    record: Record
    rows: Array
    estimates: tuple[Estimate, ...]
    converged: bool
    message: str

    @cached_property
    def values(self) -> dict[str, float]:
        """Parameter values by name."""
        return {e.name: e.value for e in self.estimates}

    @cached_property
    def force(self) -> Array:
        """The model's force in N at every sample of the record, shape (n,)."""
        return self.model.force(self.record.inputs, self.values)

    @cached_property
    def residual(self) -> Array:
        """Measured minus modelled force in N, shape (n,)."""
        return self.record.force - self.force

    @property
    def rmse(self) -> float:
        """Root mean square of the residual over the fitted rows, N."""
        return float(np.sqrt(np.mean(self.residual[self.rows] ** 2)))

    @property
    def max_error(self) -> float:
        """Largest absolute residual over the fitted rows, N."""
        return float(np.max(np.abs(self.residual[self.rows])))

    @property
    def r2(self) -> float:
        """Coefficient of determination over the fitted rows."""
        force = self.record.force[self.rows]
        spread = float(np.sum((force - force.mean()) ** 2))
        return 1.0 - float(np.sum(self.residual[self.rows] ** 2)) / spread if spread > 0 else math.nan

    @property
    def problems(self) -> list[str]:
        """Why the fit is not valid; empty when it is."""
        found = [] if self.converged else [f"the search did not converge ({self.message})"]
        loose = [e.name for e in self.estimates if not e.identified]
        if loose:
            found.append(f"the record does not determine {', '.join(loose)}; drop an effect, or vary more on the rig")
        return found

    @property
    def valid(self) -> bool:
        """Converged, and every parameter identified."""
        return not self.problems


def fit(
    model: Model,
    record: Record,
    rows: Array | None = None,
    start: Mapping[str, float] | None = None,
    detail: bool = True,
) -> Fit:
    """Least-squares fit over `rows` (mask, default all), errors of the parameters included unless not `detail`.

    Raises FitError when the record cannot identify the law at all, DataError when an effect lacks a column.
    """
    rows = np.ones(len(record), bool) if rows is None else rows
    _check(model, record, rows)
    solution = solve(model, record.inputs, record.force, lambda m: m[rows], start)
    estimates = _estimates(model, record, rows, solution.values, detail)
    return Fit(model, record, rows, estimates, solution.converged, solution.message)


def fit_branches(model: Model, record: Record, branch: str) -> dict[str, Fit]:
    """Fits by branch: `separate` gives contraction and extension, any other word that branch alone."""
    names = ("contraction", "extension") if branch == "separate" else (branch,)
    return {name: fit(model, record, record.branch_rows(name)) for name in names}


def _check(model: Model, record: Record, rows: Array) -> None:
    where = record.source or record.name
    levels = len(np.unique(record.level[rows]))
    if levels < model.law.min_levels:
        raise FitError(
            f"{where}: {levels} pressure level ({record.level[rows][0]:g} MPa), but {model.law.name} needs at least "
            f"{model.law.min_levels} to tell its parameters apart; add isobars or choose another law"
        )
    if rows.sum() <= len(model.params):
        raise FitError(
            f"{where}: {int(rows.sum())} samples for {len(model.params)} parameters of {model.law.name}; "
            "measure more samples or choose a law with fewer parameters"
        )
    for term in model.terms:
        lacking = term.effect.missing(record.inputs)
        if lacking:
            raise DataError(
                f"{where}: {term.effect.name} needs {', '.join(lacking)}, which the record does not hold; "
                "log it on the rig, or leave the effect out"
            )


def _estimates(
    model: Model, record: Record, rows: Array, values: Mapping[str, float], detail: bool
) -> tuple[Estimate, ...]:
    params = (*model.linear, *curved_within_bounds(model, record.inputs))
    stderr, identified = np.full(len(params), math.nan), np.ones(len(params), bool)
    if detail and params:
        matrix = jacobian(model, record.inputs, values, record.force)[rows]
        residual = (record.force - model.force(record.inputs, values))[rows]
        stderr, identified = _uncertainty(matrix, residual)
    return tuple(
        Estimate(p.name, p.unit, p.doc, values[p.name], float(s), _at_bound(p.lower, p.upper, values[p.name]), bool(ok))
        for p, s, ok in zip(params, stderr, identified, strict=True)
    )


def _uncertainty(matrix: Array, residual: Array) -> tuple[Array, Array]:
    """Standard errors from the linearised model, NaN along directions that the data leave flat."""
    n, k = matrix.shape
    scale = np.linalg.norm(matrix, axis=0)
    dead = scale < 1e-300
    scale[dead] = 1.0
    _, sigma, vt = np.linalg.svd(np.linalg.qr(matrix / scale, mode="r"))
    flat = sigma < 1e-8 * max(float(sigma[0]), 1e-300)
    identified = ~dead & (np.sum(vt[flat] ** 2, axis=0) < 1e-3)
    inverse = np.where(flat, 0.0, 1.0 / np.where(flat, 1.0, sigma))
    variance = float(residual @ residual) / max(n - k, 1)
    stderr = np.sqrt(np.sum((vt.T * inverse) ** 2, axis=1) * variance) / scale
    return np.where(identified, stderr, math.nan), identified


def _at_bound(lower: float, upper: float, value: float) -> bool:
    span = upper - lower if math.isfinite(upper - lower) else max(abs(value), 1.0)
    return min(value - lower, upper - value) <= 1e-7 * span
