"""Error on data that a fit has not seen: blocks are held out whole."""

import math
from collections.abc import Sequence
from itertools import product

import numpy as np

from ..core import FitError
from ..core.progress import steps
from ..fitting import Fit, fit
from ..fitting.solve import solve
from ..model import Model, Term
from ..records import Record

Array = np.ndarray
FOLDS = 5
ALIKE = 1.01
"""Ratio of held-out errors up to which forms foretell alike."""


def folds(record: Record) -> list[Array]:
    """Masks (n,) of the rows to hold out in turn: each length or isobar of a table, every fifth cycle in time."""
    blocks = np.unique(record.block)
    if record.inputs.time is None:
        return [record.block == b for b in blocks]
    return [np.isin(record.block, blocks[k::FOLDS]) for k in range(min(FOLDS, len(blocks)))]


def heldout_rmse(model: Model, record: Record, whole: Fit | None = None) -> float:
    """Root mean square error in N of each block predicted by the model fitted to the others; NaN with one block only.

    `whole` is the fit to all rows, from which the refits start. Raises FitError as `fit` does.
    """
    masks = folds(record)
    if len(masks) < 2:
        return math.nan
    whole = whole or fit(model, record, detail=False)
    in_time = record.inputs.time is not None
    square = 0.0
    for mask in steps(masks, "holding data out"):
        rows = ~mask
        if rows.sum() <= len(model.params):
            raise FitError(
                f"{record.name}: too few samples to hold a {record.block_kind} out for {len(model.params)} parameters"
            )
        values = solve(
            model, record.inputs, record.force, lambda m, rows=rows: m[rows], whole.values, quick=in_time
        ).values
        square += float(np.sum((record.force - model.force(record.inputs, values))[mask] ** 2))
    return math.sqrt(square / len(record))


def in_best_forms(base: Fit, terms: Sequence[Term]) -> list[Term]:
    """The terms in the forms with which the blocks of a table are foretold best, each by a fit to the others.

    A few lengths do not tell forms apart by the fit alone: the richest wins there and foretells worst. Of forms that
    foretell alike the ones with the fewest parameters are taken.
    """

    def heldout(choice: tuple[Term, ...]) -> float:
        try:
            return heldout_rmse(base.model.adding(*choice), base.record)
        except FitError:
            return math.inf  # too few samples for so rich a form

    choices = list(product(*([Term(t.effect, form) for form in t.effect.forms] for t in terms)))
    errors = [heldout(choice) for choice in choices]
    alike = [choice for choice, error in zip(choices, errors, strict=True) if error <= ALIKE * min(errors)]
    return list(min(alike, key=lambda choice: sum(len(t.form.params) for t in choice)))


def linear_heldout(law: Array, columns: Array, residual: Array, masks: list[Array]) -> tuple[float, float]:
    """Root mean square error in N, on all rows and held out, of a linearised law (n, m) with columns (n, k) added."""
    matrix = np.hstack([law, columns])
    scale = np.linalg.norm(matrix, axis=0)
    matrix = matrix / np.where(scale > 0, scale, 1.0)
    gram, product = matrix.T @ matrix, matrix.T @ residual
    ridge = 1e-10 * np.eye(len(gram))
    inside = float(np.mean((residual - matrix @ np.linalg.solve(gram + ridge, product)) ** 2))
    outside = 0.0
    for mask in masks:
        part, left = matrix[mask], residual[mask]
        x = np.linalg.solve(gram - part.T @ part + ridge, product - part.T @ left)
        outside += float(np.sum((left - part @ x) ** 2))
    return math.sqrt(inside), math.sqrt(outside / len(residual)) if len(masks) > 1 else math.nan
