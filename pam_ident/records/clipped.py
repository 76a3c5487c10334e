"""A load cell, or its amplifier, at its end."""

import numpy as np

Array = np.ndarray
LEAST = 10
"""Rows that read the very same extreme force while the muscle moves."""
MOVES = 0.005
"""Share of the stroke by which it moves meanwhile: more than a sensor's noise in a hold."""
BESIDE = 2
"""Rows to both sides that go with them: near its end a sensor cuts off half of the noise."""
MOST = 0.25
"""Share of the rows up to which the others still are a record."""


def clipped_rows(contraction: Array, force: Array) -> Array:
    """Mask (n,) of the samples, in order of time, at the lowest or the highest force in N that the sensor can give.

    All that they say is that the force is beyond it. None where they are too many to do without.
    """
    out = np.zeros(len(force), bool)
    for end in (force.min(), force.max()):
        here = force == end
        if here.sum() >= LEAST and np.ptp(contraction[here]) > MOVES * np.ptp(contraction):
            out |= np.convolve(here, np.ones(2 * BESIDE + 1), "same") > 0.0
    return out if out.sum() <= MOST * len(out) else np.zeros(len(force), bool)
