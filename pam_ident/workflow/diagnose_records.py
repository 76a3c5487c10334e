"""Which effect a law lacks, record by record."""

from collections.abc import Iterable, Iterator

import numpy as np

from ..core import FitError, PamError
from ..diagnosis import diagnose
from ..diagnosis.nouns import Diagnosis
from .setup import Setup


def diagnose_records(records: Iterable[str], setup: Setup) -> Iterator[tuple[str, Diagnosis | PamError]]:
    """Path and Diagnosis of each record, as they come; in place of a Diagnosis the error of a bad record.

    Raises UsageError for an unknown law or effect, before any record is read.
    """
    model, extra = setup.model, setup.extra
    for path in records:
        try:
            yield path, diagnose(model, setup.read(path), extra)
        except PamError as error:
            yield path, error
        except np.linalg.LinAlgError as error:
            yield path, FitError(f"{path}: the fit broke down ({error}); check the record for constant columns")
