"""Drivers that the schedule of a test makes one."""

import numpy as np

from ..core import Array
from ..records import Record

SPEED_RATIO = 1.5
"""Speeds closer than this are one speed: within a stroke, speed varies with contraction and proves nothing."""
ONE_COURSE = 0.1
"""Share of the whole way on an isobar by which isobars of one course differ at most."""


def one_speed(record: Record) -> bool:
    """Whether the strokes of a record in time have practically one speed: all, or those of each isobar and direction.

    Where a drive slows down with the load, another speed is another pressure or branch, and proves nothing either;
    under a held load the pressure is driven at a speed, and how fast the length then goes is the answer.
    """
    speed, moving, rate = record.inputs.stroke_speed, record.inputs.moving, record.inputs.pressure_rate
    if record.carried and rate is not None:
        speed = mean_of_each(record.stroke, np.abs(rate))
    if speed is None or moving is None or not moving.any():
        return False
    level = record.level if record.inputs.pressure_rate is None else np.zeros(len(record))
    cells = (level + 1j * record.inputs.direction)[moving]  # a pair as one number
    return all(_one(speed[moving][cells == cell]) for cell in np.unique(cells))


def one_course(record: Record) -> frozenset[str]:
    """Drivers that take one course, so that a form alone tells them apart: the way gone, and the cycle, where it goes
    with the time since an isobar began alike on all isobars. None without isobars or time.
    """
    inputs = record.inputs
    if inputs.time is None or inputs.cycle is None or inputs.segment is None or inputs.pressure_rate is not None:
        return frozenset()
    isobars = np.split(np.arange(len(record)), np.flatnonzero(np.diff(record.level) != 0.0) + 1)
    ways = [np.cumsum(np.abs(np.diff(inputs.way_mm[one], prepend=inputs.way_mm[one[0]]))) for one in isobars]
    times = [inputs.time[one] - inputs.time[one[0]] for one in isobars]
    longest = int(np.argmax([time[-1] for time in times]))
    off = [way - np.interp(time, times[longest], ways[longest]) for way, time in zip(ways, times, strict=True)]
    alike = all(np.abs(one).max() <= ONE_COURSE * ways[longest][-1] for one in off)
    return frozenset({"cycle", "rest"}) if alike else frozenset()


def mean_of_each(group: Array, values: Array) -> Array:
    """The mean of some values (n,) over each sample's group (n,), shape (n,)."""
    _, one = np.unique(group, return_inverse=True)
    return (np.bincount(one, weights=values) / np.bincount(one))[one]


def _one(speeds: Array) -> bool:
    """Whether most of some speeds are practically one."""
    return float(np.quantile(speeds, 0.95)) < SPEED_RATIO * float(np.quantile(speeds, 0.05))
