"""Fit a law to a record that is larger than memory."""

from pathlib import Path

from ..core import UsageError
from ..fitting.fit import branch_names
from ..fitting.long import fit_long
from ..records.long import open_long
from .fit import Checks, FitAnswer, Wishes
from .setup import Setup


def fit_long_record(path: str | Path, setup: Setup, wishes: Wishes | None = None) -> FitAnswer:
    """Fit `setup.model` to the branches asked for, from a record read in chunks, as well as from memory.

    The answer's record is an even sample of the rows. From it are the loops' energies and the faults of sensors that
    parameters take up; noise floor and test for a lack of fit are left out. Raises what `fit_record` does, and
    UsageError for wishes, and effects, that need the whole record at once.
    """
    wishes = wishes or Wishes()
    plain = Wishes(wishes.branch, held=wishes.held)
    odd = [name for name in ("method", "weights", "loss", "intervals") if getattr(wishes, name) != getattr(plain, name)]
    if odd:
        raise UsageError(
            f"{path} is read in chunks: --{odd[0]} {getattr(wishes, odd[0])} needs all of it in memory at once; leave "
            "that out, or fit a part of the record"
        )
    with open_long(path, setup.specimen) as record:
        fits = fit_long(setup.model, record, branch_names(wishes.branch), wishes.held)
    sample = next(iter(fits.values())).record
    return FitAnswer(sample, fits, wishes, {name: Checks(None, None, one.stand_ins) for name, one in fits.items()})
