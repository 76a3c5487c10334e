"""Least squares: a model and a record in, a Fit out."""

from .fit import Fit, fit, fit_branches
from .isobars import IsobarTable, fit_isobars, loop_energies
from .lmfit_bridge import from_lmfit, lmfit_result
from .problem import Problem, Solution, white_covariance
from .solvers import LevenbergMarquardt, Lmfit, Solver, VariableProjection

__all__ = [
    "Fit",
    "IsobarTable",
    "LevenbergMarquardt",
    "Lmfit",
    "Problem",
    "Solution",
    "Solver",
    "VariableProjection",
    "fit",
    "fit_branches",
    "fit_isobars",
    "from_lmfit",
    "lmfit_result",
    "loop_energies",
    "white_covariance",
]
