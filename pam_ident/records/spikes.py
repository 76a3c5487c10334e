"""Single readings of the force that leave all others, as a loose plug or a lost bit makes them."""

from collections.abc import Mapping

import numpy as np

from ..core import Array

LEAST = 20
"""Rows below which a reading is not held against the others."""
RARE = 0.01
"""Share of the rows (one at least) up to which such readings are faults; more are the muscle's or the noise's."""
BEYOND = 5.0
"""How many times the largest of the other readings no muscle reaches."""
REACH, FIFTH = 12, 5
"""How far to both sides of a reading others are looked at, the fifth largest of how far those are off: of two spikes
side by side but for a row or two, what lies between is off, too, and none may hide the other."""
TIMES, SHARE = 4.0, 0.02
"""How many times that a reading is off (some ten standard deviations of white noise), and the share of the largest
force that it is off: a smaller one decides nothing."""


def impossible_rows(values: Mapping[str, Array]) -> dict[str, Array]:
    """Force → mask (n,) of the rows, few, whose force is several times as large as every other; empty without any."""
    size = np.abs(values["force"])
    most = _most(len(size))
    largest = np.sort(np.partition(size, -most - 1)[-most - 1 :])
    gaps = np.flatnonzero((largest[1:] > BEYOND * largest[:-1]) & (largest[:-1] > 0.0))
    return {"force": size > largest[gaps[0]]} if most and len(gaps) else {}


def spike_rows(values: Mapping[str, Array]) -> dict[str, Array]:
    """Force → mask (n,) of the rows, few, in order of time, in which the force leaves its neighbours for one reading or
    two and comes back; empty without any.

    It is off the median about it, and off the straight lines through the two before and the two behind: a step, a turn
    of the motion and a burst are not. The first row and the last have nothing to come back to.
    """
    force = values["force"]
    most = _most(len(force))
    if "time" not in values or not most:
        return {}
    near = _windows(force, 2)
    middle = np.partition(near, 2, axis=1)[:, 2]
    bend = np.abs(force - [2.0 * near[:, 1] - near[:, 0], 2.0 * near[:, 3] - near[:, 4]]).min(axis=0)
    off = np.minimum(bend, np.abs(force - middle))
    far = np.flatnonzero(off > SHARE * np.partition(np.abs(force), -most - 1)[-most - 1])
    usual = np.partition(_windows(bend, REACH)[far], -FIFTH, axis=1)[:, -FIFTH]
    lone = far[off[far] > TIMES * usual]
    return {"force": np.isin(np.arange(len(force)), lone)} if 0 < len(lone) <= most else {}


def _most(n: int) -> int:
    """How many of n readings may be faults; none of a few, that cannot be held against each other."""
    return max(int(RARE * n), 1) if n >= LEAST else 0


def _windows(x: Array, reach: int) -> Array:
    """View (n, 2 reach + 1) of the values up to `reach` before and behind each one; the ends are repeated."""
    return np.lib.stride_tricks.sliding_window_view(np.pad(x, reach, mode="edge"), 2 * reach + 1)
