"""Diagnose and add, down to the noise floor; or effects added by hand, one after the other."""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

from ..core import FitError, UsageError
from ..core.digits import newtons
from ..core.prose import capital
from ..diagnosis import climb, diagnose, heldout_rmse
from ..diagnosis.ladder import climbing
from ..diagnosis.nested import HERE, nested
from ..diagnosis.nouns import Diagnosis, Ladder, Rung
from ..diagnosis.sentence import why_it_ends
from ..fitting import Fit, fit
from ..model import Model, steps
from ..parallel.executor import Executor
from ..records import Record
from .forms import in_best_forms
from .gate import check_completed, computing, may_name
from .law_choice import settle
from .setup import AUTO, REFIT, Setup

__all__ = ["climb_ladder", "ladder_by_hand", "steps", "why_it_ends"]


def climb_ladder(record: Record, setup: Setup, executor: Executor = HERE) -> Ladder:
    """The ladder from `setup.model` up: diagnose, add, diagnose again.

    Its held-out error is nested, and it ends where that stops falling, unless `setup.heldout` asks for refits.

    Args:
        record: what the model is held against.
        setup: the law, and effects that are known already.
        executor: who chooses anew without the held-out rows.

    Raises:
        FitError, DataError: where the record cannot be fitted at all.
        NothingNamed: one of these, where it looks too wrong, or holds too little, to name an effect by.

    Example:
        >>> from pam_ident.records.datasets import dataset_record
        >>> from pam_ident.tasks.ladder import climb_ladder
        >>> from pam_ident.tasks.setup import Setup
        >>> setup = Setup("exponential_law")
        >>> found = climb_ladder(setup.read(dataset_record("nothing_hidden")), setup)
        >>> print(len(found.rungs), "rung,", found.last.verdict, f"at {found.noise_floor:.1f} N")
        1 rung, adequate at 2.1 N
    """
    with computing(record):
        may_name(record, setup.model, setup.assume)
        found = climb(in_best_forms(record, setup)[0], record, *setup.tried)
        if setup.heldout != REFIT:
            found = _nested(found, record, setup, executor)
        check_completed(found.rungs[-1].fit, setup.assume)
        return found


def _nested(found: Ladder, record: Record, setup: Setup, executor: Executor) -> Ladder:
    """The ladder with its nested error; as it is where nobody asked and the record is too small."""

    along = found.rungs[-1].fit.record  # in an isotonic test that of the lengths as predicted

    def ended(model: Model) -> Diagnosis:
        return diagnose(model, along, *setup.tried)

    # Effects of the user's own could not be looked up by another process.
    who, bare = (HERE, setup) if setup.own else (executor, setup.bare())
    again = partial(_again, bare, len(found.rungs))
    try:
        return nested(found, again, ended, setup.held_out, who)
    except (FitError, UsageError):
        if setup.held_out:
            raise
        return found


def _again(setup: Setup, count: int, part: Record) -> list[Fit]:
    """The rungs on some rows of a record, up to `count`, the law chosen anew too where nobody named it."""
    with computing(part):
        own = settle(part, replace(setup, law=AUTO))[0] if setup.chosen else setup
        rungs: tuple[Rung, ...] = ()
        for rungs, _ in climbing(in_best_forms(part, own)[0], part, *own.tried, detail=False):
            if len(rungs) >= count:
                break  # what more there is would not be read
        return [rung.fit for rung in rungs]


def ladder_by_hand(
    record: Record, setup: Setup, known: Mapping[tuple[str, ...], Rung], latest: Diagnosis | None
) -> tuple[Rung, ...]:
    """A rung for the law and for each effect more, those that are known taken over; `latest` led to a new one."""
    whole = setup.model
    rungs: list[Rung] = []
    for count in range(len(whole.terms) + 1):
        model = replace(whole, terms=whole.terms[:count])
        found = known.get(tuple(model.labels))
        if found is None:
            with computing(record):
                one = fit(model, record)
                found = Rung(one, heldout_rmse(model, record, one), _why(rungs, one), latest if rungs else None)
        rungs.append(found)
    return tuple(rungs)


def _why(rungs: list[Rung], one: Fit) -> str:
    if not rungs:
        return "the law alone"
    title = capital(one.model.terms[-1].effect.title)
    return f"{title}: error {newtons(rungs[-1].fit.rmse)} → {newtons(one.rmse)}, added by hand"
