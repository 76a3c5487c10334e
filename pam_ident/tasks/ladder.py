"""Diagnose and add, down to the noise floor; or effects added by hand, one after the other."""

from collections.abc import Mapping
from dataclasses import replace

from ..diagnosis import climb, heldout_rmse
from ..diagnosis.nouns import Diagnosis, Ladder, Rung
from ..fitting import Fit, fit
from ..records import Record
from .gate import admit, check_completed, computing, may_name
from .setup import Setup


def climb_ladder(record: Record, setup: Setup) -> Ladder:
    """The ladder from `setup.model` up: diagnose, add, diagnose again.

    Args:
        record: what the model is held against.
        setup: the law, and effects that are known already.

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
        1 rung, adequate at 2.0 N
    """
    with computing(record):
        may_name(record, setup.model, setup.assume)
        found = climb(setup.model, record, setup.extra, setup.without, setup.only)
        check_completed(found.rungs[-1].fit, setup.assume)
        return found


def ladder_by_hand(
    record: Record, setup: Setup, known: Mapping[tuple[str, ...], Rung], latest: Diagnosis | None
) -> tuple[Rung, ...]:
    """A rung for the law and for each effect more, those that are known taken over; `latest` led to a new one."""
    admit(record)
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
    return f"{one.model.terms[-1].effect.title}: error {rungs[-1].fit.rmse:.3g} → {one.rmse:.3g} N, added by hand"
