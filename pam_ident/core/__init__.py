"""What every layer speaks: parameters, the inputs of a force law, units, errors."""

from .errors import DataError, FitError, PamError, UsageError
from .files import blank_nan
from .inputs import Inputs, Sensors, Specimen
from .param import Param, Range
from .recursion import Array as Array  # no word of the glossary, and so not in the list below

__all__ = [
    "DataError",
    "FitError",
    "Inputs",
    "PamError",
    "Param",
    "Range",
    "Sensors",
    "Specimen",
    "UsageError",
    "blank_nan",
]
