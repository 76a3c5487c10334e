"""A force that is logged late, of another instant than the length: it looks like what follows the speed."""

import numpy as np

from ..core import Inputs, Param
from ..core.digits import number
from ..effects import Effect, TransformsContraction
from ..effects.base import Array, Values
from ..fitting.solve import solve
from ..model import Term
from .selection import Selection

FALLS_SHORT = 0.04
"""Share of the squares which an answer explains that a late force does not, up to which it is as good: where damping, a
lag of the pressure or Stribeck friction was hidden in 30 virtual records, it was 0.05 at least."""
LATE = Param("late", "s", "how much later than the length the force is read", -1.0, 1.0, scale=0.01)


def _past(inputs: Inputs, values: Values, force: Array) -> Array:
    assert inputs.velocity is not None
    return -inputs.velocity[:, None] / inputs.specimen.initial_length_mm


LOGGED_LATE = Effect(
    "logged_late",
    "force logged late",
    "a first-order expansion in the delay",
    (TransformsContraction("textbook", "ε → ε − late ε̇", (LATE,), _past),),
    test="mark an instant in every channel: knock at the clamp",
    candidate=False,
)


def logged_late(selection: Selection, left: float) -> str:
    """What else may be, in a sentence, where a force that is logged late looks like nearly all that an answer explains,
    of which mean squares are `left`, in N²; empty where none does."""
    inputs, clean = selection.record.inputs, ~selection.noise.outlier
    if inputs.velocity is None or inputs.locked or selection.record.carried:
        return ""
    model = selection.base.model.adding(Term(LOGGED_LATE, LOGGED_LATE.forms[0]))
    found = solve(model, inputs, selection.record.force, lambda m: m[clean], selection.base.values, quick=True)
    late = float(np.mean(selection.residual(model, found.values)[clean] ** 2))
    alone = selection.plain_square((), selection.base.values)
    if late - left > FALLS_SHORT * (alone - left):
        return ""
    by = found.values[f"{LOGGED_LATE.name}.{LATE.name}"]
    when = f"{number(abs(by), 2)} s {'after' if by > 0 else 'before'} the length"
    return f"It could be a force that is logged {when}: see whether the logger reads all channels at one instant."
