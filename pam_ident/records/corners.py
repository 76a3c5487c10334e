"""Whether a stroke has begun in the sample at its corner, which lies on the hold's level and on the stroke's line.

The track cannot tell. The force can: nothing has slid, and no speed is felt, where the muscle still rests.
"""

from collections.abc import Iterable
from dataclasses import dataclass

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
TAKEN = ("direction", "stroke", "stroke_speed", "position", "cycle")
"""What a sample at rest has of the one before it."""


@dataclass(frozen=True)
class Corners:
    """Rows (m,) in which strokes begin at the level of a hold, the direction there, and the force over the hold's."""

    rows: Array
    direction: Array
    off: Array

    @classmethod
    def of(cls, moving: Array, direction: Array, segment: Array, x: Array, force: Array, noise: float) -> "Corners":
        """Those of a track x with a sensor's `noise`, in one unit, by its motion and the force in N, (n,) each."""
        at = np.flatnonzero(moving[1:] & ~moving[:-1]) + 1
        at = at[at >= REST]
        hold = at[:, None] - np.arange(1, REST + 1)
        whole = ~moving[hold].any(axis=1) & (segment[hold[:, -1]] == segment[at])
        there = whole & (np.abs(x[at] - x[hold].mean(axis=1)) <= NEAR * noise)
        at, hold = at[there], hold[there]
        return cls(at, direction[at], force[at] - force[hold].mean(axis=1))

    @classmethod
    def together(cls, parts: Iterable["Corners"]) -> "Corners":
        """Those of pieces of one record, rows counted through."""
        every = list(parts)
        return cls(*(np.concatenate([getattr(one, name) for one in every]) for name in ("rows", "direction", "off")))

    @property
    def rest(self) -> bool:
        """Whether the force is the hold's, on the whole, in both directions."""
        for sign in (-1.0, 1.0):
            one = self.off[self.direction == sign]
            if len(one) < FEWEST or abs(one.mean()) > SURE * one.std() / np.sqrt(len(one)):
                return False
        return True


def rest_corners(motion: Motion, time: Array, x: Array, force: Array) -> None:
    """Give corners of a record's motion to the holds before them where they rest, by its time in s, its track x and the
    force in N, shape (n,) each."""
    found = Corners.of(motion.moving, motion.direction, motion.segment, x, force, position_noise(x, time))
    if found.rest:
        motion.moving[found.rows], motion.velocity[found.rows] = False, 0.0
        for name in TAKEN:
            values = getattr(motion, name)
            values[found.rows] = values[found.rows - 1]
