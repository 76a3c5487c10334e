"""A force that is logged late, of another instant than the length: it looks like what follows the speed."""

import numpy as np

from ..fitting.solve import solve
from ..model import Term
from .patterns.reading import LATE, LOGGED_LATE, ONE_INSTANT, PATTERN, misread
from .selection import Selection

FALLS_SHORT = 0.04
"""Share of the squares which an answer explains that a late force does not, up to which it is as good: where damping, a
lag of the pressure or Stribeck friction was hidden in 30 virtual records, it was 0.05 at least."""


def logged_late(selection: Selection, left: float) -> str:
    """What else may be, in a sentence, where a force that is logged late looks like nearly all that an answer explains,
    of which mean squares are `left`, in N²; empty where none does."""
    inputs, clean = selection.record.inputs, ~selection.noise.outlier
    if inputs.velocity is None or inputs.locked or selection.record.carried:
        return ""
    model = selection.base.model.adding(Term(PATTERN.in_forms((LOGGED_LATE,)), LOGGED_LATE))
    found = solve(model, inputs, selection.record.force, lambda m: m[clean], selection.base.values, quick=True)
    late = float(np.mean(selection.residual(model, found.values)[clean] ** 2))
    alone = selection.plain_square((), selection.base.values)
    if late - left > FALLS_SHORT * (alone - left):
        return ""
    by = found.values[f"{PATTERN.name}.{LATE.name}"]
    return f"It could be {misread(LOGGED_LATE, by)}: {ONE_INSTANT}."
