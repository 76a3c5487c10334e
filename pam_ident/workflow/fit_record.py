"""Fit a law, with or without effects, to a record."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..core import UsageError
from ..fitting import Fit, IsobarTable, fit_branches, fit_isobars
from ..fitting.fit import Estimate
from ..records import Record
from .energy import energy_warning, model_loops, passive
from .setup import Setup

BRANCHES = ("together", "separate", "contraction", "extension")
METHODS = ("global", "two-stage")


@dataclass(frozen=True)
class FitAnswer:
    """Fits by branch; for the two-stage method also the table of the isobars. `loops` are the modelled loops in J.

    `two_stage` names the branches whose parameters come from straight lines through the isobars; where a law has no
    such lines, or effects are fitted too, its fit is the global one.
    """

    record: Record
    fits: Mapping[str, Fit]
    method: str
    isobars: IsobarTable | None
    two_stage: tuple[str, ...]
    loops: Mapping[float, float]
    warnings: tuple[str, ...]

    @property
    def passive(self) -> bool | None:
        """Whether the modelled loop takes up energy at every pressure; None without two modelled branches."""
        return passive(self.loops)

    @property
    def problems(self) -> list[str]:
        """Why a fit is not valid, branch by branch; empty when all are."""
        return [f"{branch}: {problem}" for branch, one in self.fits.items() for problem in one.problems]


def fit_record(record: Record, setup: Setup, branch: str = "together", method: str = "global") -> FitAnswer:
    """Fit `setup.model` to the branches asked for, all pressures at once, or isobar by isobar and then over pressure.

    Raises UsageError for an unknown branch or method, FitError when the record cannot identify the law at all,
    DataError when it lacks the branch.
    """
    check_choice(branch, method)
    fits = fit_branches(setup.model, record, branch)
    isobars, straight = None, ()
    if method == "two-stage":
        isobars = fit_isobars(setup.model, record, tuple(fits))
        lines = {name: one for name, one in fits.items() if _covers(isobars, name, one)}
        fits = fits | {name: _from_lines(one, isobars, name) for name, one in lines.items()}
        straight = tuple(lines)
    loops = model_loops(fits)
    warnings = [f"{term.effect.name}: {term.effect.warning}" for term in setup.model.terms if term.effect.warning]
    energy = energy_warning(loops)
    return FitAnswer(
        record, fits, method, isobars, straight, loops, tuple([*warnings, energy] if energy is not None else warnings)
    )


def check_choice(branch: str, method: str) -> None:
    """Raises UsageError for an unknown branch or method."""
    for what, given, known in (("--branch", branch, BRANCHES), ("--method", method, METHODS)):
        if given not in known:
            raise UsageError(f"{what} {given!r}: expected one of {', '.join(known)}")


def _covers(table: IsobarTable, branch: str, one: Fit) -> bool:
    return {p.name for p in one.model.params} == set(table.two_stage.get(branch, ()))


def _from_lines(one: Fit, table: IsobarTable, branch: str) -> Fit:
    """The fit with its parameters from straight lines through the isobars, standard errors from their scatter."""
    values = table.two_stage[branch]
    errors = _line_errors(table, branch)
    estimates: list[Estimate] = [
        replace(e, value=values[e.name], stderr=errors.get(e.name, e.stderr), at_bound=e.at_bound)
        for e in one.estimates
    ]
    return Fit(one.model, one.record, one.rows, tuple(estimates), one.converged, "two-stage")


def _line_errors(table: IsobarTable, branch: str) -> dict[str, float]:
    """Standard errors of intercept and slope over pressure of each isobar coefficient; NaN from two isobars."""
    rows = [row for row in table.rows if row.branch == branch]
    p = np.array([row.pressure_MPa for row in rows])
    n, spread = len(p), float(np.sum((p - p.mean()) ** 2))
    errors: dict[str, float] = {}
    for k, name in enumerate(e.name for e in rows[0].estimates):
        y = np.array([row.estimates[k].value for row in rows])
        off = y - np.polyval(np.polyfit(p, y, 1), p)
        variance = float(off @ off) / (n - 2) if n > 2 else math.nan
        errors[f"{name}1"] = math.sqrt(variance / spread)
        errors[f"{name}0"] = math.sqrt(variance * (1.0 / n + p.mean() ** 2 / spread))
    return errors
