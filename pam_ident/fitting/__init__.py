"""Least squares: a model and a record in, a Fit out."""

from .fit import Fit, fit, fit_branches
from .isobars import IsobarTable, fit_isobars, loop_energies

__all__ = ["Fit", "IsobarTable", "fit", "fit_branches", "fit_isobars", "loop_energies"]
