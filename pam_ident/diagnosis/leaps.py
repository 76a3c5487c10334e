"""Where what is left jumps, and stays: noise, however slow, wanders all the time."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ..core.digits import newtons, number

Array = np.ndarray
APART, NEARBY, NORMAL, GAP = (20, 10, 5), 20, 0.455, 5.0
"""Samples on either side of a moment between which what is left jumps, and that tell how large noise is there;
the median square over the mean square of what is normal; and the usual times between samples from which a longer one is
a break."""
LEAP = 10.0
"""Standard deviations from which a single jump is none of noise: 4.8 at most in 86 records with nothing hidden."""
ENOUGH = 10
"""Times as many moments of one pace of sampling, before any of them is judged."""
ALONE = 4.0
"""Times as large, squared, as any that is left once it is taken out, from which a jump stands alone."""


@dataclass(frozen=True)
class Leap:
    """A jump that stands alone: its `moment` in s, `size_N` in N, and the squares in N² that it explains, `gain`."""

    moment: float
    size_N: float
    gain: float

    @classmethod
    def of(cls, moment: float, later: Array, left: Array) -> "Leap":
        """By the column of what is `later`, (n,), and what is `left` in N, (n,), both free of what a model follows."""
        square = max(float(later @ later), 1e-12)
        size = float(later @ left) / square
        return cls(moment, size, size**2 * square)

    @property
    def text(self) -> str:
        """In words."""
        return f"a single step of the force, by {newtons(self.size_N)} at {number(self.moment)} s"


def farthest(left: Array, time: Array, step: float) -> tuple[float, float]:
    """Moment in s of the largest jump in what is left, (n,) in N, and its size as `leaps` has it; 0 for none."""
    at, far = leaps(left, time, step, APART[0])
    return (float(time[at[np.argmax(far)]]), float(far.max())) if len(at) else (0.0, 0.0)


def leaps(left: Array, time: Array, step: float, apart: int) -> tuple[Array, Array]:
    """Moments, and by how much the middle halves of `apart` samples before and after each differ in the mean: squared,
    beside the usual.

    `left` is in N, (n,), at a `time` in s; the force was read in steps of `step` N. How much neighbouring samples
    differ, but for those that jump, takes it out that noise may be larger in places.
    """
    squares = np.diff(left) ** 2
    if len(squares) < 2 * NEARBY:
        return np.empty(0, int), np.empty(0)
    usual = np.sort(sliding_window_view(squares, 2 * NEARBY), axis=1)[:, : -2 * NEARBY // 5].mean(axis=1)
    at = np.arange(apart, len(left) - apart)
    middle = np.sort(sliding_window_view(left, apart), axis=1)[:, apart // 4 : apart - apart // 4].mean(axis=1)
    between = np.abs(middle[at] - middle[at - apart])
    beside = np.maximum(usual, 0.1 * np.median(usual))[np.clip(at - NEARBY, 0, len(usual) - 1)]
    gaps = np.diff(time, prepend=time[0])
    piece = np.cumsum(gaps > GAP * np.median(gaps))
    seen = (piece[at + apart - 1] == piece[at - apart]) & (beside > 0.0)
    at, between, beside = at[seen], between[seen], beside[seen]
    far = np.maximum(between, step / math.sqrt(apart / 2.0)) ** 2 / beside
    pace = np.round(np.log2((time[at + apart - 1] - time[at - apart]) / apart)) if len(at) else at
    enough = np.zeros(len(at), bool)
    for one in np.unique(pace):  # as fast as it is read, slow noise steps on, or is another each time
        alike = pace == one
        enough |= alike & (np.count_nonzero(alike) >= ENOUGH * apart)
        far[alike] *= NORMAL / np.median(far[alike])
    rounded = between <= step  # of what does not move it may be all
    far[rounded] = np.minimum(far[rounded], 1.0)
    return at[enough], far[enough]
