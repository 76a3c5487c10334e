"""Error on data that a fit has not seen: blocks are held out whole."""

import math
from collections.abc import Mapping, Sequence
from itertools import product

import numpy as np

from ..core import FitError
from ..core.progress import steps
from ..fitting import Fit, fit
from ..fitting.problem import all_rows
from ..fitting.solve import jacobian, solve
from ..model import Model, Term
from ..records import Record
from ..records.folds import folds

Array = np.ndarray
SHORT = 500
"""Rows up to which a record is short: every candidate is fitted to the last digit, and held-out data choose the forms
of a table."""
ALIKE = 1.01
"""Ratio of held-out errors up to which forms predict alike."""


def heldout_rmse(
    model: Model,
    record: Record,
    whole: Fit | None = None,
    masks: Sequence[Array] | None = None,
    quick: bool | None = None,
) -> float:
    """Root mean square error in N of each block predicted by the model fitted to the others; of rows that are never
    held out what the `whole` fit leaves. NaN with one block only.

    `whole` is the fit to all rows, from which the refits start, `masks` (n,) the rows to hold out in turn in place of
    the `folds`. Refits are `quick` where that is said, and in a record in time. Raises FitError as `fit` does.
    """
    masks = folds(record) if masks is None else masks
    if len(masks) < 2:
        return math.nan
    whole = whole or fit(model, record, detail=False)
    quick = record.inputs.time is not None if quick is None else quick
    square = float(np.sum(whole.residual[~np.any(masks, axis=0)] ** 2))
    for mask in steps(masks, "holding data out"):
        rows = ~mask
        if rows.sum() <= len(model.params):
            raise FitError(
                f"{record.name}: too few samples to hold a {record.block_kind} out for {len(model.params)} parameters"
            )
        values = solve(
            model, record.inputs, record.force, lambda m, rows=rows: m[rows], whole.values, quick=quick
        ).values
        square += float(np.sum((record.force - model.force(record.inputs, values))[mask] ** 2))
    return math.sqrt(square / len(record))


def in_best_forms(base: Fit, terms: Sequence[Term]) -> list[Term]:
    """The terms in the written forms with which blocks are predicted best, each by a fit to the others.

    A few lengths or cycles do not tell forms apart by the fit alone: the richest wins there and predicts worst. Of
    forms that predict alike the ones with the fewest parameters are taken.
    """

    def heldout(choice: tuple[Term, ...]) -> float:
        try:
            return heldout_rmse(base.model.adding(*choice), base.record, quick=True)
        except FitError:
            return math.inf  # too few samples for so rich a form

    choices = list(product(*([Term(t.effect, f) for f in t.effect.written] for t in terms)))
    errors = [heldout(choice) for choice in choices]
    alike = [choice for choice, error in zip(choices, errors, strict=True) if error <= ALIKE * min(errors)]
    return list(min(alike, key=lambda choice: sum(len(t.form.params) for t in choice)))


def fit_quickly(model: Model, record: Record, start: Mapping[str, float]) -> tuple[dict[str, float], float]:
    """Values of a quick fit of the force at all rows, from a `start`, and the error in N rms that it leaves."""
    values = solve(model, record.inputs, record.force, all_rows, start, quick=True).values
    return values, float(np.sqrt(np.mean((record.force - model.force(record.inputs, values)) ** 2)))


def heldout_nearby(model: Model, record: Record, values: Mapping[str, float]) -> float:
    """As `heldout_rmse`, but each refit is one Gauss–Newton step from `values`, where the fit to all rows ended.

    A parameter at a bound stays there.
    """
    masks = folds(record)
    if len(masks) < 2:
        return math.nan
    free = [p.lower < values[p.name] < p.upper for p in model.bounded(record.inputs)]
    slopes = jacobian(model, record.inputs, values, record.force)[:, free]
    left = record.force - model.force(record.inputs, values)
    scale = np.linalg.norm(slopes, axis=0)
    slopes = slopes / np.where(scale > 0, scale, 1.0)
    gram, product = slopes.T @ slopes, slopes.T @ left
    ridge = 1e-10 * np.eye(len(gram))
    square = float(np.sum(left[~np.any(masks, axis=0)] ** 2))
    for mask in masks:
        part, there = slopes[mask], left[mask]
        step = np.linalg.solve(gram - part.T @ part + ridge, product - part.T @ there)
        square += float(np.sum((there - part @ step) ** 2))
    return math.sqrt(square / len(record))
