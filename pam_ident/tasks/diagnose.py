"""Which effect a law lacks, record by record."""

import multiprocessing
import os
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from functools import partial

from ..core import PamError
from ..core.progress import steps
from ..diagnosis import diagnose
from ..diagnosis.nouns import Diagnosis
from ..model import Model
from ..parallel.one_thread import without_script
from ..records import Record
from .setup import Setup

Answer = Diagnosis | PamError


def diagnose_record(record: Record, setup: Setup) -> Diagnosis:
    """Which effect `setup.model` lacks on a record.

    Args:
        record: what the model is held against.
        setup: the law, and effects that are known already.

    Raises:
        FitError, DataError: where the record cannot be fitted at all.

    Example:
        >>> from pam_ident.records.datasets import dataset_record
        >>> from pam_ident.tasks.diagnose import diagnose_record
        >>> from pam_ident.tasks.setup import Setup
        >>> setup = Setup("exponential_law")
        >>> print(diagnose_record(setup.read(dataset_record("nothing_hidden")), setup).sentence)
        exponential_law leaves 2.08 N rms; the noise is about 2.01 N. Nothing is missing that this record could show.
    """
    return diagnose(setup.model, record, setup.extra)


def diagnose_records(records: Iterable[str], setup: Setup) -> Iterator[tuple[str, Answer]]:
    """Path and Diagnosis of each record, in order; in place of a Diagnosis the error of a bad record.

    Several records are shared among the machine's cores, unless the user's own effects are in play, which another
    process could not look up. Raises UsageError for an unknown law or effect, before any record is read.
    """
    one = partial(_diagnose, setup, setup.model)
    paths, workers = list(records), os.cpu_count() or 1
    if len(paths) < 3 or workers < 2 or setup.extra:
        yield from zip(paths, map(one, paths), strict=True)
        return
    with ProcessPoolExecutor(min(workers, len(paths)), mp_context=multiprocessing.get_context("spawn")) as pool:
        with without_script():
            futures = [pool.submit(one, path) for path in paths]
        for path, future in steps(zip(paths, futures, strict=True), "records", len(paths)):
            try:
                answer = future.result()
            except BrokenProcessPool:
                answer = one(path)  # a worker was killed; what it was asked is not lost
            yield path, answer


def _diagnose(setup: Setup, model: Model, path: str) -> Answer:
    try:
        return diagnose(model, setup.read(path), setup.extra)
    except PamError as error:
        return error
    except Exception as error:
        if os.environ.get("PAM_IDENT_DEBUG"):
            raise
        return PamError(f"{path}: the diagnosis broke down ({type(error).__name__}: {error}); please report the record")
