"""Whether a stroke has begun in the sample at its corner, which lies on the hold's level and on the stroke's line.

The track cannot tell. The force can: nothing has slid, and no speed is felt, where the muscle still rests.
"""

import numpy as np

from .motion import Motion, position_noise

Array = np.ndarray
REST = 3
"""Samples of a hold before a corner, over which its level and force are means."""
FEWEST = 4
"""Corners of one direction from which their mean difference is judged."""
SURE = 3.0
"""Standard errors from which a mean difference is no chance."""
NEAR = 4.0
"""Standard deviations of the sensor within which a sample lies on a level."""


def rest_corners(motion: Motion, time: Array, x: Array, force: Array) -> None:
    """Give the first samples of strokes to the hold before them, where they lie at its level x (n,) and the force (n,)
    is on the whole as it is in the hold."""
    at = _resting(motion, x, force, position_noise(x, time))
    motion.moving[at], motion.velocity[at] = False, 0.0
    for kept in (motion.direction, motion.stroke, motion.stroke_speed, motion.position, motion.cycle):
        kept[at] = kept[at - 1]


def _resting(motion: Motion, x: Array, force: Array, noise: float) -> Array:
    """Indices of the corners, none if in either direction the mean force is not the holds'."""
    at = np.flatnonzero(motion.moving[1:] & ~motion.moving[:-1]) + 1
    at = at[at >= REST]
    hold = at[:, None] - np.arange(1, REST + 1)
    whole = ~motion.moving[hold].any(axis=1) & (motion.segment[hold[:, -1]] == motion.segment[at])
    there = whole & (np.abs(x[at] - x[hold].mean(axis=1)) <= NEAR * noise)
    at, hold = at[there], hold[there]
    off = force[at] - force[hold].mean(axis=1)
    for sign in (-1.0, 1.0):
        one = off[motion.direction[at] == sign]
        if len(one) < FEWEST or abs(one.mean()) > SURE * one.std() / np.sqrt(len(one)):
            return at[:0]
    return at
