"""Which effect a law lacks, record by record."""

import os
from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import partial

from ..core import PamError, UsageError
from ..diagnosis import diagnose
from ..diagnosis.diagnose import diagnosing
from ..diagnosis.nested import anew, masks_of
from ..diagnosis.nouns import Diagnosis
from ..diagnosis.sentence import told
from ..fitting import Fit
from ..parallel.executor import Executor, WorkerLost
from ..records import Record
from ..schema.diagnosis import candidates
from .forms import in_best_forms
from .gate import check_completed, computing, may_name
from .law_choice import LawChoice, settle
from .setup import Setup

__all__ = ["candidates", "diagnose_record", "diagnose_records", "fit_command", "told"]
Answer = Diagnosis | PamError


def diagnose_record(record: Record, setup: Setup) -> Diagnosis:
    """Which effect `setup.model` lacks on a record.

    Args:
        record: what the model is held against.
        setup: the law, and effects that are known already.

    Raises:
        FitError, DataError: where the record cannot be fitted at all.
        NothingNamed: one of these, where it looks too wrong, or holds too little, to name an effect by.

    Example:
        >>> from pam_ident.records.datasets import dataset_record
        >>> from pam_ident.tasks.diagnose import diagnose_record
        >>> from pam_ident.tasks.setup import Setup
        >>> setup = Setup("exponential_law")
        >>> print(diagnose_record(setup.read(dataset_record("nothing_hidden")), setup).sentence.split("; ")[1])
        the noise is about 2.08 N. Nothing is missing that this record could show.
    """
    *_, found = diagnosing_record(record, setup)
    with computing(record):
        return _nested(found, record, setup) if setup.held_out else found


def fit_command(found: Diagnosis, record: str, setup: Setup) -> str:
    """The command line that fits the model with what was missing, so that it can be used."""
    model = found.best.model
    law = setup.law if setup.law.endswith(".py") else model.law.name
    return replace(setup, law=law, effects=tuple(model.labels)).command("fit", record, "--json", "fit.json")


def diagnosing_record(record: Record, setup: Setup) -> Iterator[Diagnosis]:
    """The answer as soon as it is there, and then the same with errors of every candidate and what to do next.

    Raises FitError or DataError, NothingNamed among them.
    """
    with computing(record):
        may_name(record, setup.model, setup.assume)
        model, said = in_best_forms(record, setup)
        for found in diagnosing(model, record, *setup.tried):
            check_completed(found.best, setup.assume)
            yield replace(found, sentence=said + found.sentence)


def _nested(found: Diagnosis, record: Record, setup: Setup) -> Diagnosis:
    """With the errors on held-out data of a diagnosis that has not seen it."""

    def again(part: Record) -> tuple[Fit, Fit]:
        other = diagnose(in_best_forms(part, setup)[0], part, *setup.tried, detail=False)
        return other.base, other.best

    before, after = anew(record, masks_of(record, setup.held_out), again, 2)
    return replace(found, heldout_rmse=float(before), heldout_rmse_after=float(after), heldout="nested")


def diagnose_records(records: Iterable[str], setup: Setup) -> Iterator[tuple[str, Answer, LawChoice | None]]:
    """Path, Diagnosis, and how its law was chosen if none was named, of each record, in order; in place of a Diagnosis
    the error of a bad record.

    Several records are shared among the machine's cores, unless the user's own effects are in play, which another
    process could not look up. Raises UsageError for an unknown law or effect, before any record is read.
    """
    setup.check()
    one = partial(_diagnose, setup)
    paths = list(records)
    if len(paths) < 3 or setup.own:
        yield from ((path, *one(path)) for path in paths)
        return
    for path, found in zip(paths, Executor.of_cores().in_order(one, paths, "records"), strict=True):
        yield (path, PamError(f"{path}: {found}"), None) if isinstance(found, WorkerLost) else (path, *found)


def _diagnose(setup: Setup, path: str) -> tuple[Answer, LawChoice | None]:
    choice = None
    try:
        record = setup.read(path)
        setup, choice = settle(record, setup, naming=True)
        return diagnose_record(record, setup), choice
    except PamError as error:
        return error, choice
    except MemoryError:
        return UsageError(f"{path}: the memory ran out; take a part of it, or a larger machine"), choice
    except Exception as error:
        if os.environ.get("PAM_IDENT_DEBUG"):
            raise
        said = f"{path}: the diagnosis broke down ({type(error).__name__}: {error}); please report the record"
        return PamError(said), choice
