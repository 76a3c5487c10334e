"""Error on data that neither fit nor selection has seen: everything is chosen anew without the held-out rows.

A selection that has seen them makes their error too small (Cawley & Talbot 2010, J. Machine Learning Research 11,
2079–2107).
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..core import FitError, UsageError
from ..core.digits import newtons
from ..core.prose import capital
from ..effects import named
from ..fitting import Fit, fit
from ..fitting.solve import solve
from ..laws import get_law, listed
from ..model import Model
from ..parallel.executor import Executor
from ..records import Record
from ..records.folds import FOLDS, in_parts, told_by_the_rest
from ..records.kind import held_lengths
from .heldout import heldout_rmse
from .ladder import LEAST_FALL
from .nouns import Diagnosis, Ladder, Nested, Rung

Array = np.ndarray
MANY = 40
"""Pressures from which they count as continuous, and are held out in bands."""
AS_WELL = 1.05
"""Error over that of the ladder up to which a law alone predicts as well."""
MEAN = "mean over pressure"
HERE = Executor()
"""This process."""


def usual(record: Record) -> str:
    """What is held out where nobody says: lengths of an isometric test, cycles of others in time, blocks of a table."""
    if record.inputs.time is None:
        return "length" if record.block_kind == "length" else "pressure"
    return "length" if record.kind == "isometric" else "cycle"


def masks_of(record: Record, by: str) -> list[Array]:
    """Masks (n,) of the rows to hold out in turn, in FOLDS parts at most, each of every fifth block.

    Raises UsageError for what the record has less than two of, or where one pressure is left without one.
    """
    masks = told_by_the_rest(record, in_parts(_blocks(record, by)))
    if len(masks) < 2:
        text = "less than two, or one pressure is left without one"
        raise UsageError(f"--heldout {by}: {record.name} has {text}; hold something else out")
    return masks


def _blocks(record: Record, by: str) -> Array:
    """What tells each sample's block from others, shape (n,); all alike where a record has no such blocks."""
    alike = np.zeros(len(record), int)
    if by == "cycle":
        return alike if record.inputs.time is None else record.block
    if by == "pressure":
        return _banded(record.level) if len(record.levels) > MANY else record.level
    if by == "length" and record.block_kind == "length":
        return record.block
    if by == "length":
        locked = record.kind == "isometric"
        return held_lengths(record.inputs.contraction) if locked else _banded(record.inputs.contraction)
    return record.groups.get(by, alike)


def _banded(values: Array) -> Array:
    """Number (n,) of each value's band, of FOLDS that are alike in width."""
    return np.digitize(values, np.linspace(values.min(), values.max(), FOLDS + 1)[1:-1])


def nested(
    ladder: Ladder,
    again: Callable[[Record], Sequence[Fit]],
    ended: Callable[[Model], Diagnosis],
    by: str = "",
    executor: Executor = HERE,
) -> Ladder:
    """The ladder with its error on rows that its selection has not seen, up to where that stops falling.

    Args:
        ladder: as climbed on all rows.
        again: the fits of the rungs on some of the rows, everything chosen anew.
        ended: diagnoses the model of a lower rung, where the ladder is to end there.
        by: what is held out whole, a word of `records.kind.BLOCKS`; by default what suits the kind of test.
        executor: who climbs; other processes need an `again` that can be pickled.

    Rung k errs as k effects do that are found without the held-out rows; a ladder that finds fewer ends there.
    Raises FitError where too few rows are left, UsageError as `masks_of`.
    """
    record = ladder.rungs[0].fit.record
    by = by or usual(record)
    masks = masks_of(record, by)
    errors = anew(record, masks, again, len(ladder.rungs), executor)
    rungs = [
        replace(rung, heldout_rmse=float(error), refit_rmse=rung.heldout_rmse)
        for rung, error in zip(ladder.rungs, errors, strict=True)
    ]
    height = _height(errors)
    kept, dropped = rungs[: height + 1], rungs[height + 1 :]
    last = ladder.last
    if dropped:
        found = dropped[0].found
        last = found if found and found.base.model == kept[-1].fit.model else ended(kept[-1].fit.model)
    beside = beside_it(rungs[0].fit, record, masks, float(errors[0]))
    text = _told(kept, dropped, beside, by)
    return Ladder(tuple(kept), ladder.noise_floor, last, Nested(by, len(masks), beside, text))


def anew(
    record: Record,
    masks: Sequence[Array],
    again: Callable[[Record], Sequence[Fit]],
    count: int,
    executor: Executor = HERE,
) -> Array:
    """Root mean square errors in N, shape (count,), on the rows of masks (n,) of the fits that `again` finds without
    them; of fewer than `count` the last counts for the rest. Raises what `again` does."""
    parts = [record.take(np.flatnonzero(~mask)) for mask in masks]
    squares = np.zeros(count)
    for fits, mask in zip(executor.all(again, parts, "choosing anew without held-out rows"), masks, strict=True):
        found = [_square(one, record, mask) for one in fits]
        squares += [found[min(k, len(found) - 1)] for k in range(count)]
    return np.sqrt(squares / len(record))


def _height(errors: Array) -> int:
    """The rung above which no error is lower by what an effect is worth."""
    height = 0
    for k, error in enumerate(errors):
        if error < (1.0 - LEAST_FALL) * errors[height]:
            height = k
    return height


def _square(one: Fit, record: Record, mask: Array) -> float:
    """Sum of squares in N² on the rows of a mask (n,) by a model that was found without them.

    Of a record in time it is fitted anew along all of it, whose strokes are not interrupted there.
    """
    values = one.values
    if record.inputs.time is not None:
        values = solve(one.model, record.inputs, record.force, lambda m: m[~mask], values, quick=True).values
    square = float(np.sum((record.force - one.model.force(record.inputs, values))[mask] ** 2))
    return square if math.isfinite(square) else math.inf


def beside_it(alone: Fit, record: Record, masks: Sequence[Array], anew: float) -> dict[str, tuple[int, float]]:
    """Number of parameters and error in N of other laws in place of a fit's own, where the rows of each mask (n,)
    are held out in turn, best first, less those that cannot be fitted or that the record does not determine.

    Its own is among them where that, kept, errs less than if all is chosen `anew` (N): the choice of a law then errs.
    """
    model, found = alone.model, {MEAN: (2, _line_error(record, masks))}
    own = heldout_rmse(model, record, alone, masks)
    if AS_WELL * own < anew:
        found[model.law.name] = len(model.params), own
    for law in listed():
        if law.name == model.law.name:
            continue
        other = replace(model, law=law, free_geometry=False)
        try:
            whole = fit(other, record)
            if not whole.problems:
                found[law.name] = len(other.params), heldout_rmse(other, record, whole, masks)
        except FitError:
            continue
    return dict(sorted(found.items(), key=lambda item: item[1][1]))


def _line_error(record: Record, masks: Sequence[Array]) -> float:
    """Of the force as a line over pressure."""
    columns = np.column_stack([record.inputs.pressure, np.ones(len(record))])
    squares = 0.0
    for mask in masks:
        line = np.linalg.lstsq(columns[~mask], record.force[~mask])[0]
        squares += float(np.sum((record.force - columns @ line)[mask] ** 2))
    return math.sqrt(squares / len(record))


def _told(kept: Sequence[Rung], dropped: Sequence[Rung], beside: Mapping[str, tuple[int, float]], by: str) -> str:
    own, parameters = kept[-1].heldout_rmse, len(kept[-1].fit.model.params)
    said = [f"With each {by} held out and everything chosen anew without it (nested) the error is {newtons(own)}."]
    if dropped:
        model = dropped[-1].fit.model
        names = " and ".join(named(label, model.own) for label in model.labels[len(kept[-1].effects) :])
        said.append(f"{capital(names)} would make it {newtons(dropped[-1].heldout_rmse)}, and is left out.")
    best, (count, error) = next(iter(beside.items()))
    simple = {name: one for name, one in beside.items() if one[0] < parameters and one[1] <= AS_WELL * own}
    if best == kept[0].fit.model.law.name:
        said.append(f"What errs is the choice of a law: with {_named(best).lower()} kept it is {newtons(error)}.")
    elif AS_WELL * error < own:
        better = f"{_named(best)} alone, with {count} parameters, predicts better, to {newtons(error)}"
        said.append(f"{better}: take that one to predict.")
    elif simple:
        name, (count, error) = next(iter(simple.items()))
        said.append(f"{_named(name)}, with {count} parameters for {parameters}, predicts as well, to {newtons(error)}.")
    else:
        said.append("No law alone predicts as well." if error > AS_WELL * own else "")
    return " ".join(filter(None, said))


def _named(law: str) -> str:
    return f"The {law}" if law == MEAN else f"The {get_law(law).title} ({law})"
