"""Diagnose and add, down to the noise floor."""

from ..diagnosis import climb
from ..diagnosis.nouns import Ladder
from ..records import Record
from .setup import Setup


def climb_ladder(record: Record, setup: Setup) -> Ladder:
    """The ladder from `setup.model` up. Raises FitError or DataError where the record cannot be fitted at all."""
    return climb(setup.model, record, setup.extra)
