"""Two ways to fit the exponential law side by side: all isobars at once, and isobar by isobar as in the paper."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..core import FitError, UsageError
from ..model import Model
from ..records import Record
from .fit import branch_names, fit
from .isobars import FOLDED, fit_isobars

PAPER_MU = 45.0


@dataclass(frozen=True)
class MethodRow:
    """One method on one branch: parameters, error in N over all rows, and error of each isobar when it is predicted
    from the others. `mu` is the value at which μ was held, None where it was fitted; `heldout` is NaN for fewer than
    four isobars."""

    method: str
    mu: float | None
    branch: str
    values: Mapping[str, float]
    rmse: float
    heldout: float


def compare_methods(record: Record, model: Model, branch: str = "together") -> tuple[MethodRow, ...]:
    """Two-stage and global, μ = 45 and μ free, for each branch asked for (together, separate, or one of them).

    Raises UsageError for another law or with effects, which have no lines through isobars; FitError and DataError as
    a fit does.
    """
    if model.law.name not in FOLDED or model.terms:
        raise UsageError(f"two-stage and global side by side: expected {' or '.join(FOLDED)} without effects")
    return tuple(
        _row(record, model, method, mu, name)
        for name in branch_names(branch)
        for method in ("two-stage", "global")
        for mu in (PAPER_MU, None)
    )


def _row(record: Record, model: Model, method: str, mu: float | None, branch: str) -> MethodRow:
    rows = record.branch_rows(branch)
    values = _values(record, model, method, mu, branch, rows)
    squares = 0.0
    levels = np.unique(record.level[rows])
    for level in levels if len(levels) > 3 else []:
        here = rows & (record.level == level)
        others = _values(record, model, method, mu, branch, rows & ~here)
        squares += _square(record, model, others, here)
    heldout = math.sqrt(squares / rows.sum()) if len(levels) > 3 else math.nan
    return MethodRow(method, mu, branch, values, math.sqrt(_square(record, model, values, rows) / rows.sum()), heldout)


def _values(
    record: Record, model: Model, method: str, mu: float | None, branch: str, rows: np.ndarray
) -> Mapping[str, float]:
    held = {} if mu is None else {"mu": mu}
    if method == "global":
        return fit(model, record, rows, detail=False, held=held).values
    lines = fit_isobars(model, record, (branch,), held, rows).two_stage
    if branch not in lines:
        raise FitError(f"{record.source or record.name}: a line over pressure needs two isobars, and {branch} has one")
    return lines[branch]


def _square(record: Record, model: Model, values: Mapping[str, float], rows: np.ndarray) -> float:
    return float(np.sum((record.force - model.force(record.inputs, values))[rows] ** 2))
