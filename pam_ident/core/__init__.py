"""What every layer speaks: parameters, the inputs of a force law, units, errors."""

from .errors import DataError, FitError, PamError, UsageError
from .inputs import Inputs, Specimen
from .param import Param
from .tables import blank_nan

__all__ = ["DataError", "FitError", "Inputs", "PamError", "Param", "Specimen", "UsageError", "blank_nan"]
