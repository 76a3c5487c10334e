"""Fits by readings of all samples, some at a time: which models allow it, and where steps have reached the minimum."""

import numpy as np

from ..core import Inputs
from ..model import Model, Term

Array = np.ndarray
CLOSE = 1e-11
"""Way that may be left to the minimum, in typical sizes of the parameters."""
ROUNDING = 1e-18
"""Square of a step, as a share of that of the residual, below which steps that shrink no more are rounding."""


def reached(size: float, rate: float, moved: float) -> bool:
    """Whether a step of Gauss and Newton ends the way to the minimum.

    Near it each step is shorter than the one before by a `rate` (1 where it is not known), so that this and the step's
    `size`, in typical sizes of the parameters, tell what is left. `moved` is its square over all samples, as a share of
    the residual's.
    """
    left = size * rate / (1.0 - rate) if rate < 1.0 else size
    return left <= CLOSE or (rate > 0.8 and moved <= ROUNDING)


def with_memory(model: Model, inputs: Inputs, force: Array) -> list[Term]:
    """The terms whose columns at a sample hang on what lies between the record's first sample and it.

    So their forms say, or so it shows where stretches of some samples (`inputs`, force (n,) in N) stand alone with the
    first: an effect of one's own may not say it.
    """
    stretches = [np.r_[0, rows] for rows in np.array_split(np.arange(len(inputs)), 7)]

    def remembers(term: Term) -> bool:
        if term.form.remembers:
            return True
        shape = {p.name: p.start for p in term.form.shapes}
        whole = term.form.columns(inputs, shape, force)
        apart = (term.form.columns(inputs.take(rows), shape, force[rows]) for rows in stretches)
        return not all(np.allclose(a, whole[rows], 1e-9, 1e-12) for a, rows in zip(apart, stretches, strict=True))

    return [term for term in model.terms if remembers(term)]
