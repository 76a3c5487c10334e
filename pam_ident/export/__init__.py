"""A fitted model in other languages."""

from .c import c_header
from .fitted import Fitted
from .matlab import matlab_function
from .python import python_function

__all__ = ["Fitted", "c_header", "matlab_function", "python_function"]
