"""Whether a model may be evaluated on some of a record's samples at a time."""

import numpy as np

from ..core import Inputs
from ..model import Model, Term

Array = np.ndarray


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
