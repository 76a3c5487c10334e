"""Rows in which a locked muscle hangs slack: it pulls with nothing while the pressure changes."""

import numpy as np

from ..core import Array
from .kind import held_lengths
from .record import Record
from .roughness import position_noise

BAND, NEAR = 4.0, 0.02
"""Noises of the force, and share of its largest, within which it stands where it begins; and of zero."""
INSIDE, AFTER, STOPPED = 0.98, 0.1, 8.0
"""Share of the rows up to a pressure that stand there, share of the pressure's range behind it in which the force is
seen to grow, and bands by which it would have grown, had nothing been slack."""


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
    after = (pressure > pressure[min(end, len(force) - 1)]) & (
        pressure < pressure[min(end, len(force) - 1)] + AFTER * np.ptp(pressure)
    )
    if np.count_nonzero(after) < 3:
        return 0
    course = np.polyfit(pressure[after], force[after], 1)[0]
    return end if course * (pressure[end] - pressure[0]) > STOPPED * band else 0
