"""Which law to take for a record: all of them, compared on data that they have not seen."""

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..core import DataError, FitError, UsageError
from ..core.digits import millimetres, newtons
from ..core.progress import steps
from ..core.prose import capital
from ..fitting import fit
from ..fitting.fit import picker
from ..fitting.length import Lengths, by_length, solve_length
from ..fitting.solve import solve
from ..fitting.solvers import QUICK
from ..laws import get_law, listed
from ..model import Model
from ..records import Record, thinned
from ..records.doubt import Doubt
from ..records.folds import folds
from .gate import TooLittle, admit, computing, require_nameable
from .setup import AUTO, Setup

if TYPE_CHECKING:
    from ..fitting import Fit

Array = np.ndarray
ROWS = 5_000
"""Rows of a longer record that are enough to compare laws."""
BY_HAND = "exponential_law"
"""To begin by hand with."""
ALIKE = 1.01
"""Ratio of mean errors up to which laws predict several records alike."""
EXACT = 1e-6
"""Error over the largest force, or over the muscle's length, that is as good as none."""


@dataclass(frozen=True)
class LawTrial:
    """A law on trial: how many parameters it has, its errors in N (of the length, `in_mm`, where that answered), on the
    rows it was fitted to and on those it was not; NaN, with the `problem`, where this record cannot fit it."""

    law: str
    parameters: int
    rmse: float = math.nan
    heldout_rmse: float = math.nan
    problem: str = ""
    in_mm: bool = False


@dataclass(frozen=True)
class LawChoice:
    """The law that was taken, why, and all laws that were compared, the best on held-out data first."""

    law: str
    why: str
    trials: tuple[LawTrial, ...]


def settle(record: Record, setup: Setup, naming: bool = False) -> tuple[Setup, LawChoice | None]:
    """The setup with a law in place of `auto`, and how it was chosen; as it is where a law was named.

    Raises FitError where no law can be fitted to the record, DataError for a kind of test that no law is for; and,
    where effects are to be named, NothingNamed as `require_nameable`, before laws are compared.
    """
    if setup.law != AUTO:
        return setup, None
    if naming:
        require_nameable(record, setup.assume)
    else:
        admit(record)
    with computing(record):
        choice = choose_law(record, setup)
    return replace(setup, law=choice.law, chosen=True), choice


def begin(record: Record | None, setup: Setup) -> tuple[Setup, LawChoice | None]:
    """The same to begin by hand with, where any law will do if none can be chosen, or no record is there yet."""
    if record is not None:
        with suppress(FitError, DataError):
            return settle(record, setup)
    return (replace(setup, law=BY_HAND) if setup.law == AUTO else setup), None


def choose_law(record: Record, setup: Setup) -> LawChoice:
    """The law of the fewest parameters that predicts the rows it has not seen as well as any does.

    Every law, with the effects of `setup`, is fitted to the record less every fifth cycle in turn, or of a table less
    each length or isobar, and held against what was left out, by the force, or by the length where that answered. As
    well as the best is what is worse by less than one standard error of the difference between the folds. A law with a
    parameter that the record does not determine, or at a bound, is taken only where all are like that.

    Args:
        record: what the laws are held against; of a long one some thousand rows.
        setup: effects that every law gets.

    Raises:
        FitError: where no law can be fitted.

    Example:
        >>> from pam_ident.records import read_record
        >>> from pam_ident.tasks.law_choice import choose_law
        >>> from pam_ident.tasks.setup import AUTO, Setup
        >>> print(choose_law(read_record("dmsp20_300"), Setup(AUTO)).law)
        martens_boblan
    """
    whole, record = len(record), thinned(record, ROWS)
    in_mm = by_length(record)
    masks = folds(record)
    masks = masks if len(masks) > 1 else []
    trials: list[LawTrial] = []
    squares: dict[str, Array] = {}
    for law in steps(listed(), "comparing laws"):
        model = Model.build(law.name, setup.effects, setup.extra, setup.free_geometry)
        try:
            one = fit(model, record)
            squares[law.name] = _heldout(one, masks)
        except (FitError, DataError) as error:
            trials.append(LawTrial(law.name, len(model.params), problem=str(error), in_mm=in_mm))
            continue
        heldout = math.sqrt((squares[law.name].sum() + _never_held_out(one, masks)) / one.n) if masks else math.nan
        rmse = (one.length_errors or one.errors).rmse
        trials.append(LawTrial(law.name, len(model.params) - len(one.held), rmse, heldout, _problem(one), in_mm))
    if not squares:
        text = f"no law can be fitted. {trials[0].problem}"
        raise TooLittle(f"{record.source or record.name}: {text}", len(record), (Doubt("too_little", text),))
    trials.sort(key=lambda t: (math.isnan(t.rmse), t.heldout_rmse if masks else t.rmse))
    scale = record.specimen.initial_length_mm if in_mm else float(np.max(np.abs(record.force)))
    asked = "held-out data" if whole == len(record) else f"held-out data, of {len(record)} rows"
    return _chosen(tuple(trials), squares, masks, scale, asked)


def choose_for_all(records: Sequence[Record], setup: Setup) -> LawChoice:
    """One law for several records: that of the least error on held-out data, in the geometric mean over the records.

    Errors in the trials are such means. Of laws within a hundredth the one with the fewest parameters is taken, and one
    with a problem only where all have one. Raises FitError where no law can be fitted to all of them, UsageError where
    the length answered in some.
    """
    if len({by_length(record) for record in records}) > 1:
        raise UsageError("laws are compared by force in one record and by length in the other; name one with --law")
    found = [{t.law: t for t in choose_law(record, setup).trials} for record in records]
    trials = []
    for law in found[0]:
        mine = [one[law] for one in found]
        rmse, heldout = (math.exp(sum(map(_log, each)) / len(mine)) for each in zip(*map(_errors, mine), strict=True))
        problem = next((t.problem for t in mine if t.problem), "")
        trials.append(LawTrial(law, mine[0].parameters, rmse, heldout, problem, mine[0].in_mm))
    trials.sort(key=lambda t: (math.isnan(t.heldout_rmse), t.heldout_rmse))
    fitted = [t for t in trials if not math.isnan(t.heldout_rmse)]
    if not fitted:
        raise FitError(f"no law can be fitted to all of {len(records)} records. {trials[0].problem}")
    able = [t for t in fitted if not t.problem] or fitted
    alike = [t for t in able if t.heldout_rmse <= ALIKE * able[0].heldout_rmse]
    best = min(alike, key=lambda t: (t.parameters, t.heldout_rmse))
    second = next((t for t in able if t is not best), None)
    why = f"{_errs(best)} on held-out data of {len(records)} records"
    return LawChoice(best.law, why + _next(second), tuple(trials))


def _errs(trial: LawTrial) -> str:
    """What a law leaves of held-out data, with what is typed to take it."""
    title = capital(get_law(trial.law).title)
    return f"{title} ({trial.law}, {trial.parameters} parameters) errs by {_error(trial)}"


def _next(trial: LawTrial | None) -> str:
    return f"; the next, the {get_law(trial.law).title}, by {_error(trial)}" if trial else ""


def _error(trial: LawTrial) -> str:
    return (millimetres if trial.in_mm else newtons)(trial.heldout_rmse)


def _errors(trial: LawTrial) -> tuple[float, float]:
    """Error on the rows fitted, and on held-out ones where there are any."""
    return trial.rmse, trial.rmse if math.isnan(trial.heldout_rmse) else trial.heldout_rmse


def _log(error: float) -> float:
    return math.log(max(error, 1e-9)) if not math.isnan(error) else math.nan


def _chosen(
    trials: tuple[LawTrial, ...], squares: dict[str, Array], masks: list[Array], scale: float, asked: str
) -> LawChoice:
    """`squares` (folds,) in N² or mm² by law; `scale` in N or mm; on what the laws were `asked`, in words."""
    fitted = [t for t in trials if t.law in squares]
    able = [t for t in fitted if not t.problem] or fitted
    best = able[0]
    if not masks:
        title = capital(get_law(best.law).title)
        why = f"{title} ({best.law}) leaves the least; the record has too few cycles to hold any out"
        return LawChoice(best.law, why, trials)
    counts = np.array([mask.sum() for mask in masks])
    nothing = (EXACT * scale) ** 2

    def alike(trial: LawTrial) -> bool:
        gap = (squares[trial.law] - squares[best.law]) / counts
        return float(gap.mean()) <= float(gap.std(ddof=1)) / math.sqrt(len(masks)) + nothing

    simplest = min((t for t in able if alike(t)), key=lambda t: (t.parameters, t.heldout_rmse))
    said = f"{_errs(simplest)} on {asked}"
    if simplest is best:
        second = next((t for t in able if t is not best), None)
        why = said + _next(second)
    else:
        other = f"the {get_law(best.law).title} ({best.parameters}, {_error(best)})"
        why = f"{said}; {other} errs by less, but not beyond its standard error"
    return LawChoice(simplest.law, why, trials)


def _never_held_out(one: "Fit", masks: list[Array]) -> float:
    """Sum of squares that a fit leaves of its rows in no mask, as `_heldout`."""
    residual = one.residual if one.lengths is None else one.lengths.residual
    return float(np.sum(residual[one.rows & ~np.any(masks, axis=0)] ** 2))


def _heldout(one: "Fit", masks: list[Array]) -> Array:
    """Sum of squares of the rows of each mask, by the model fitted to the others, shape (folds,): of the force in N²,
    of a length that answered in mm²."""
    record, model, in_mm = one.record, one.model, one.lengths is not None
    found = []
    for mask in masks:
        rest = one.rows & ~mask
        if np.count_nonzero(rest) <= len(model.params):
            raise FitError(f"too few samples to hold a {record.block_kind} out for {len(model.params)} parameters")
        if in_mm:
            values = solve_length(model, record, rest, one.values, {}, QUICK)[0].values
            error = Lengths.of(model, record, values).residual
        else:
            pick = picker(rest, None)
            values = solve(model, record.inputs, record.force, pick, one.values, quick=True).values
            error = record.force - model.force(record.inputs, values)
        found.append(float(np.sum(error[one.rows & mask] ** 2)))
    return np.array(found)


def _problem(one: "Fit") -> str:
    stuck = [e.name for e in one.estimates if e.at_bound and "." not in e.name]
    return "; ".join([*one.problems, *([f"{', '.join(stuck)} at a bound"] if stuck else [])])
