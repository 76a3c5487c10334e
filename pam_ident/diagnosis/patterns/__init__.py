"""Shapes that no known effect has, one a file: a ripple, a rub in one place, a step in time, a trend, a free curve.

A file that defines PATTERN is looked for, fitted and described without further ado. Patterns are fitted and priced like
effects, but they carry no physics and are never selected by name: they describe what is left.
"""

from collections.abc import Sequence
from functools import cache

import numpy as np

from ...core import Inputs
from ...core.discover import instances
from ...effects import Effect
from .base import SINCE_REVERSAL, Extent, PatternShape

__all__ = ["Extent", "PatternShape", "catalogue", "patterns"]
LENGTHS = 30


@cache
def catalogue() -> dict[str, PatternShape]:
    """Every pattern by name."""
    return {one.name: one for one in instances(__name__, __path__, PatternShape)}


def patterns(inputs: Inputs, beats: Sequence[float] = (), error_mm: float = 0.0) -> tuple[Effect, ...]:
    """The patterns that a record of these inputs can show, with grids as fine as its stroke and duration ask.

    `beats` are periods in s that a spectrum shows, tried beside the slow ones; nothing is looked for over displacement
    that is finer than the position's error in mm lets it be seen. A test at few lengths shows no pattern over
    displacement: any curve over contraction passes through its lengths.
    """
    timed, many = inputs.time is not None, len(np.unique(np.round(inputs.displacement_mm, 3))) >= LENGTHS
    seen = {"time": timed, "temperature": timed, SINCE_REVERSAL: timed and many}
    span = Extent.of(inputs, tuple(beats), error_mm)
    found = []
    for one in catalogue().values():
        if any(seen.get(along, many) for along in (one.coordinate, *one.elsewhere.values())):
            forms = tuple(form for form in one.forms(span) if seen.get(one.along(form), many))
            found += [one.in_forms(forms)] if forms else []
    return tuple(found)
