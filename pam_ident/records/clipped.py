"""A load cell, or its amplifier, at its end."""

import numpy as np

from ..core import Array, Inputs

CHANCE = 1e-6
"""Chance that as many rows read the very same extreme force, if it is as likely as a step of the gauge next to it."""
NEXT, PILED = 5, 3.0
"""Readings that count as next to it, and how many times as often as any of these it must be read."""
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
    rest = (force > force.min(initial=np.inf)) & (force < force.max(initial=-np.inf))
    if inputs.moving is not None:
        rest &= ~inputs.moving
    noisy = rest.any() and len(np.unique(force[rest])) > DIFFERENT * rest.sum()
    for here in ends_piled_up(force):
        if noisy or np.ptp(contraction[here]) > MOVES * np.ptp(contraction):
            out |= np.convolve(here, np.ones(2 * BESIDE + 1), "same") > 0.0
    return out if out.sum() <= MOST * len(out) else np.zeros(len(force), bool)


def ends_piled_up(force: Array) -> list[Array]:
    """Masks (n,) of the samples that read the lowest force, and the highest, where chance gives fewer."""
    readings, counts = np.unique(force, return_counts=True)
    found = []
    for end, inner in ((0, slice(1, 1 + NEXT)), (-1, slice(-1 - NEXT, -1))) if len(readings) > 1 else ():
        if counts[end] < PILED * counts[inner].max():
            continue
        from scipy.special import pdtrc  # slow to import, and seldom needed

        step = np.diff(readings).min()
        expected = counts[inner].sum() * step / np.abs(readings[inner] - readings[end]).max()
        if pdtrc(counts[end] - 1, expected) < CHANCE:
            found.append(force == readings[end])
    return found
