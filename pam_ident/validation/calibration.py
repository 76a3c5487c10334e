"""Do stated probabilities mean what they say? Reliability by bins, and Brier's score."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

EDGES = (0.0, 0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99, 1.0)


@dataclass(frozen=True)
class ReliabilityBin:
    """Statements with a probability in [low, high): how many, their mean, and how many of them were true."""

    low: float
    high: float
    n: int
    stated: float
    true: int


@dataclass(frozen=True)
class Reliability:
    """Bins that hold statements, and Brier's score, the mean of (probability − truth)²; NaN without statements."""

    bins: tuple[ReliabilityBin, ...]
    brier: float

    @property
    def n(self) -> int:
        """Number of statements."""
        return sum(one.n for one in self.bins)


def reliability(stated: Sequence[float], true: Sequence[bool], edges: Sequence[float] = EDGES) -> Reliability:
    """Stated probabilities (n,) against what turned out true (n,), in bins between `edges`.

    Brier 1950, Monthly Weather Review 78(1), 1–3, for two outcomes counted once.
    """
    p, y = np.asarray(stated, float), np.asarray(true, float)
    place = np.clip(np.searchsorted(edges, p, side="right") - 1, 0, len(edges) - 2)
    found = []
    for k in np.unique(place):
        rows = place == k
        found.append(ReliabilityBin(edges[k], edges[k + 1], int(rows.sum()), float(p[rows].mean()), int(y[rows].sum())))
    return Reliability(tuple(found), float(np.mean((p - y) ** 2)) if len(p) else float("nan"))
