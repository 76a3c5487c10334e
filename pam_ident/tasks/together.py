"""Fit a law to several records at once, with parameters that all share and others that are each record's own."""

from collections.abc import Sequence

import numpy as np

from ..core import UsageError
from ..core.threads import one_blas_thread
from ..fitting import fit_together
from ..fitting.fit import branch_names
from ..model import Model
from ..records import Record
from .fit import FitAnswer, FitOptions, checks_of
from .gate import admit
from .law_choice import AUTO
from .setup import Setup

ALL = "all"


def fit_records(
    records: Sequence[Record], setup: Setup, shared: Sequence[str] = (), wishes: FitOptions | None = None
) -> tuple[FitAnswer, ...]:
    """Fit `setup.model` to several records at once; an answer each, as `fit_record` gives it.

    Args:
        records: two or more, each of a muscle of its own or of the same.
        setup: the law and its effects.
        shared: parameters that have one value for all records: names, an effect's for all of its own, or `all`.
        wishes: branches and parameters to hold; anything else cannot be asked of several records.

    Raises:
        UsageError: for one record, one given twice, a law that nobody named, an unknown parameter, and other wishes.
        FitError, DataError: as `fit_record`.

    Example:
        >>> from pam_ident.records.datasets import dataset_record
        >>> from pam_ident.tasks.setup import Setup
        >>> from pam_ident.tasks.together import fit_records
        >>> setup = Setup("exponential_law", ("coulomb_friction",))
        >>> records = [setup.read(dataset_record(name)) for name in ("hidden_effect", "nothing_hidden")]
        >>> one, two = (answer.fits["together"] for answer in fit_records(records, setup, ["mu"]))
        >>> print(f"mu {one.values['mu']:.1f} for both; friction", end=" ")
        >>> print(*(f"{fit.values['coulomb_friction.F_c']:.1f}" for fit in (one, two)), "N")
        mu 38.4 for both; friction 6.0 0.0 N
    """
    wishes = wishes or FitOptions()
    if setup.law == AUTO:
        raise UsageError("several records are fitted together by one law; name it by --law")
    for name, asked in wishes.special.items():
        raise UsageError(f"--{name} {asked} is for one record; leave it out to fit several together")
    for k, record in enumerate(records):
        if any(_same_rows(record, one) for one in records[:k]):
            raise UsageError(f"{record.source or record.name}: given twice; it would count as twice the evidence")
    names = shared_names(setup.model, shared)
    with one_blas_thread():
        for record in records:
            admit(record)
        each = {b: fit_together(setup.model, records, names, b, wishes.held) for b in branch_names(wishes.branch)}
        answers = []
        for k, record in enumerate(records):
            fits = {branch: found[k] for branch, found in each.items()}
            checks = {branch: checks_of(one) for branch, one in fits.items()}
            answers.append(FitAnswer(record, fits, checks))
    return tuple(answers)


def _same_rows(one: Record, other: Record) -> bool:
    """Whether two records hold the same states and forces; a force alone may be the same held load."""
    pairs = ((r.force, r.inputs.pressure, r.inputs.contraction) for r in (one, other))
    return all(np.array_equal(a, b) for a, b in zip(*pairs, strict=True))


def shared_names(model: Model, shared: Sequence[str]) -> tuple[str, ...]:
    """Names of the parameters that `shared` means, in the model's order. Raises UsageError for an unknown one."""
    found: set[str] = set()
    for word in shared:
        meant = {n for n in model.names if word in (ALL, n, n.partition(".")[0] if "." in n else n)}
        if not meant:
            raise UsageError(f"--shared {word}: no parameter of the model; it has {', '.join(model.names)}")
        found |= meant
    return tuple(name for name in model.names if name in found)
