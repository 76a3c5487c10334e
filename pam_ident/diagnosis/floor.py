"""The noise of a record as measured: the error that no model can go below."""

import math

import numpy as np

from ..fitting import Fit, fit
from .follows import Following, steadied
from .selection import Selection


def noise_floor(found: Fit) -> float | None:
    """Standard deviation in N of the noise in the rows of a fit, as a diagnosis has it before any name.

    It is what the model, smooth surfaces over all drivers, and free curves over contraction leave; None where there are
    no more rows than parameters.

    Args:
        found: of any model to a record of forces.

    Example:
        >>> from pam_ident.diagnosis import noise_floor
        >>> from pam_ident.fitting import fit
        >>> from pam_ident.model import Model
        >>> from pam_ident.records import read_record
        >>> from pam_ident.records.datasets import dataset_record
        >>> found = fit(Model.build("exponential_law"), read_record(dataset_record("hidden_effect")))
        >>> print(f"{found.rmse:.1f} N are left, noise is {noise_floor(found):.1f} N")
        6.3 N are left, noise is 2.1 N
    """
    record = found.record if found.rows.all() else found.record.take(np.flatnonzero(found.rows))
    if len(record) <= len(found.values):
        return None
    steady, unsure = steadied(record)
    alone = fit(found.model, steady, start=found.values, detail=False)
    selection = Selection(alone, [], Following(steady, found.model, alone.values, unsure))
    return as_measured(selection.noise.whole, found)


def as_measured(noise: float, found: Fit) -> float:
    """The noise in N with what that of the pressure and displacement sensors adds, of a size in N without it."""
    record = found.record
    raw, calm = (found.model.force(inputs, found.values)[found.rows] for inputs in (record.inputs, record.steady))
    return min(math.hypot(noise, float(np.sqrt(np.mean((raw - calm) ** 2)))), found.rmse)
