"""Rows that tell nothing of a law: a load cell, or its amplifier, is at its end, or a locked muscle hangs slack."""

import numpy as np

from ..core import Array, Inputs
from .kind import held_lengths
from .record import Record
from .roughness import position_noise

CHANCE = 1e-6
"""Chance that as many rows read the very same extreme force, if it is as likely as a step of the gauge next to it."""
NEXT, PILED = 5, 3.0
"""Readings that count as next to it, and how many times as often as any of these it must be read."""
MOVES = 0.005
"""Share of the stroke, or of a locked muscle's pressures, by which it moves meanwhile: more than noise in a hold."""
DIFFERENT = 0.5
"""Share of the readings of other holds that differ from each other where there is noise."""
BESIDE = 2
"""Rows to both sides that go with them: near its end a sensor cuts off half of the noise."""
MOST = 0.25
"""Share of the rows up to which the others still are a record."""
BAND, NEAR = 4.0, 0.02
"""Noises of the force, and share of its largest, within which it stands where it begins; and of zero."""
INSIDE, AFTER, STOPPED = 0.98, 0.1, 8.0
"""Share of the rows up to a pressure that stand there, share of the pressure's range behind it in which the force is
seen to grow, and bands by which it would have grown, had nothing been slack."""


def clipped_rows(inputs: Inputs, force: Array) -> Array:
    """Mask (n,) of the samples, in order of time, at the lowest or the highest force in N that the sensor can give.

    All that they say is that the force is beyond it. None where they are too many to do without. In a hold a force
    without noise repeats, too: there all others must differ. A coarse gauge repeats the reading next to its end, too.
    """
    driven, out = inputs.pressure if inputs.locked else inputs.contraction, np.zeros(len(force), bool)
    rest = (force > force.min(initial=np.inf)) & (force < force.max(initial=-np.inf))
    if inputs.moving is not None:
        rest &= ~inputs.moving
    noisy = rest.any() and len(np.unique(force[rest])) > DIFFERENT * rest.sum()
    for here in ends_piled_up(force):
        if noisy or np.ptp(driven[here]) > MOVES * np.ptp(driven):
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


def slack_rows(record: Record) -> Array:
    """Mask (n,) of the samples of an isometric record in time in which the muscle is slack: at its length the force
    stands at zero up to a pressure, and beyond it grows. They tell nothing of a law, which would push there."""
    found = np.zeros(len(record), bool)
    inputs, force = record.inputs, record.force
    if record.kind != "isometric" or inputs.time is None:
        return found
    band = max(BAND * position_noise(force, inputs.time), NEAR * 0.1 * float(np.abs(force).max()))
    held, rising = held_lengths(inputs.contraction), np.gradient(inputs.pressure) > 0.0
    for length in np.unique(held):
        for way in (True, False):
            rows = np.flatnonzero((held == length) & (rising == way))
            rows = rows[np.argsort(inputs.pressure[rows], kind="stable")]
            found[rows[: _slack(inputs.pressure[rows], force[rows], band)]] = True
    return found


def _slack(pressure: Array, force: Array, band: float) -> int:
    """How many of some rows (n,), in the order of the pressure, are slack."""
    few = max(len(force) // 50, 3)
    if len(force) < 10 * few:
        return 0
    zero = float(np.median(force[:few]))
    if abs(zero) > max(band, NEAR * float(np.abs(force).max())):
        return 0
    stands = np.cumsum(np.abs(force - zero) < band) >= INSIDE * np.arange(1, len(force) + 1)
    end = int(np.flatnonzero(stands)[-1]) + 1 if stands.any() else 0
    edge = pressure[min(end, len(force) - 1)]
    after = (pressure > edge) & (pressure < edge + AFTER * np.ptp(pressure))
    if np.count_nonzero(after) < 3:
        return 0
    course = np.polyfit(pressure[after], force[after], 1)[0]
    return end if course * (pressure[end] - pressure[0]) > STOPPED * band else 0
