"""Sets of drivers compared by the likelihood of the noise that each leaves, whatever its colour."""

import math

import numpy as np

from .noise import OTHER_SIZE, filled, isolated
from .surfaces import Surfaces
from .whitening import innovation_variance

Array = np.ndarray
LIKELIER = 100.0
"""Deviance by which slow noise must be likelier than drivers that leave much less: 56 where a load cell wandered,
186 and more in 14 of 16 records without anything hidden of which drivers explain so much."""


class OwnNoise:
    """Deviance of sets of groups of surfaces over what is `left` (n,), and their penalty, of which each driver has
    `each`; `best` is that of a search, and `read` (n,) the samples that are looked at.

    A search has one noise for all its sets, and takes what is slow in that for a driver's. A set that leaves two
    thirds more to slow noise must be LIKELIER, one that leaves less than that by less, and by nothing up to a third.
    """

    def __init__(self, left: Array, surfaces: Surfaces, best: frozenset[int], read: Array, each: float) -> None:
        self.left, self.surfaces, self.each = left, surfaces, each
        rest = left - surfaces.explained(best)
        self.gaps = ~read | isolated(rest)
        self.rows = int(np.count_nonzero(~self.gaps))
        self.least = max(float(np.sum(rest[~self.gaps] ** 2)), 1e-300)
        self.known: dict[frozenset[int], float] = {}

    def criterion(self, groups: frozenset[int]) -> float:
        """That of a set, the lower the likelier."""
        if groups not in self.known:
            left = self.left - self.surfaces.explained(groups)
            more = (float(np.sum(left[~self.gaps] ** 2)) / self.least - 1.0) / OTHER_SIZE
            doubt = LIKELIER * min(max(more - 1.0, 0.0), 1.0)
            penalty = self.surfaces.of(groups)[1] * math.log(max(self.rows, 10)) + self.each * len(groups)
            deviance = self.rows * math.log(innovation_variance(filled(left, self.gaps)))
            self.known[groups] = deviance + penalty + doubt
        return self.known[groups]
