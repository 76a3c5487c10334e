"""A load cell, or its amplifier, at its end."""

import numpy as np

from ..core import Inputs

Array = np.ndarray
LEAST = 20
"""Rows that read the very same extreme force while the muscle moves."""
PILED = 3.0
"""How many times as often that force is read as the one next to it."""
MOVES = 0.005
"""Share of the stroke by which it moves meanwhile: more than a sensor's noise in a hold."""
DIFFERENT = 0.5
"""Share of the readings of other holds that differ from each other where there is noise."""
BESIDE = 2
"""Rows to both sides that go with them: near its end a sensor cuts off half of the noise."""
MOST = 0.25
"""Share of the rows up to which the others still are a record."""


def clipped_rows(inputs: Inputs, force: Array) -> Array:
    """Mask (n,) of the samples, in order of time, at the lowest or the highest force in N that the sensor can give.

    All that they say is that the force is beyond it. None where they are too many to do without. In a hold a force
    without noise repeats, too: there all others must differ. A coarse gauge repeats the reading next to its end, too.
    """
    contraction, out = inputs.contraction, np.zeros(len(force), bool)
    readings, counts = np.unique(force, return_counts=True)
    rest = (force > readings[0]) & (force < readings[-1])
    if inputs.moving is not None:
        rest &= ~inputs.moving
    noisy = rest.any() and len(np.unique(force[rest])) > DIFFERENT * rest.sum()
    for end, inner in ((0, 1), (-1, -2)) if len(readings) > 1 else ():
        here = force == readings[end]
        moves = np.ptp(contraction[here]) > MOVES * np.ptp(contraction)
        if counts[end] >= max(LEAST, PILED * counts[inner]) and (moves or noisy):
            out |= np.convolve(here, np.ones(2 * BESIDE + 1), "same") > 0.0
    return out if out.sum() <= MOST * len(out) else np.zeros(len(force), bool)
