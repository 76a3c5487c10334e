"""Where a model fails, which effect it lacks, and what to test next."""

from .compare import compare
from .diagnose import diagnose
from .heldout import heldout_rmse
from .ladder import climb
from .nouns import Bin, Candidate, Comparison, Diagnosis, Experiment, Follows, Ladder, Pattern, Region, Rung

__all__ = [
    "Bin",
    "Candidate",
    "Comparison",
    "Diagnosis",
    "Experiment",
    "Follows",
    "Ladder",
    "Pattern",
    "Region",
    "Rung",
    "climb",
    "compare",
    "diagnose",
    "heldout_rmse",
]
