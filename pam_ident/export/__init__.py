"""A fitted model in other languages."""

from .c import c_header
from .equation import equation, latex
from .fitted import Fitted
from .matlab import matlab_function
from .mujoco import mujoco_actuator
from .python import python_function

__all__ = ["Fitted", "c_header", "equation", "latex", "matlab_function", "mujoco_actuator", "python_function"]
