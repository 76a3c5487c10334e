"""Least squares: a model and a record in, a Fit out, with what its parameters are worth."""

from .bootstrap import bootstrap
from .covariance import covariance
from .fit import Fit, fit, fit_branches
from .floor import lack_of_fit, repeat_noise
from .isobars import IsobarTable, fit_isobars, loop_energies
from .problem import Problem, Solution
from .profile import profile
from .solvers import LevenbergMarquardt, Lmfit, Solver, VariableProjection, from_lmfit, lmfit_result
from .together import fit_together
from .weigh import Weighing

__all__ = [
    "Fit",
    "IsobarTable",
    "LevenbergMarquardt",
    "Lmfit",
    "Problem",
    "Solution",
    "Solver",
    "VariableProjection",
    "Weighing",
    "bootstrap",
    "covariance",
    "fit",
    "fit_branches",
    "fit_isobars",
    "fit_together",
    "from_lmfit",
    "lack_of_fit",
    "lmfit_result",
    "loop_energies",
    "profile",
    "repeat_noise",
]
