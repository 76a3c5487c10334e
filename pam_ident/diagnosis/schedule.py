"""Drivers that the schedule of a test makes one."""

import numpy as np

from ..core import Array
from ..records import Record

SPEED_RATIO = 1.5
"""Speeds closer than this are one speed: within a stroke, speed varies with contraction and proves nothing."""
SELDOM = 0.05
"""Share of the samples, behind the first stroke of an isobar, up to which a muscle never rests."""


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


def way_is_time(record: Record) -> bool:
    """Whether strokes of one speed follow each other at once, so that the way since a reversal is the time since."""
    inputs = record.inputs
    if inputs.moving is None or inputs.segment is None or not one_speed(record):
        return False
    begun = np.zeros(len(record), bool)  # that a segment begins at rest tells nothing
    for segment in np.unique(inputs.segment):
        here = np.flatnonzero(inputs.segment == segment)
        begun[here] = np.maximum.accumulate(inputs.moving[here])
    return bool(np.mean(inputs.moving[begun]) > 1.0 - SELDOM)


def mean_of_each(group: Array, values: Array) -> Array:
    """The mean of some values (n,) over each sample's group (n,), shape (n,)."""
    _, one = np.unique(group, return_inverse=True)
    return (np.bincount(one, weights=values) / np.bincount(one))[one]


def _one(speeds: Array) -> bool:
    """Whether most of some speeds are practically one."""
    return float(np.quantile(speeds, 0.95)) < SPEED_RATIO * float(np.quantile(speeds, 0.05))
