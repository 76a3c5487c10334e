"""Sensors that hang: one reading again and again, and a jump when it wakes, or a muscle that moves meanwhile."""

from collections.abc import Iterable, Mapping

import numpy as np

from ..core import Array

SENSORS = ("pressure", "displacement", "contraction", "length", "force")
LEAST = 5
"""Repeats of a reading from which it may hang."""
RARE = 0.01
"""Share of repeats among the other readings up to which a repeat is none of a coarse sensor or of a simulation."""
MOST = 0.2
"""Share of a column up to which its long repeats are faults; more are the protocol's rests."""
JUMP, FAR, FAST = 4.0, 8.0, 0.25
"""How many of its usual steps, and of those just behind it, a sensor jumps by when it wakes; by how many of its own the
way goes on beyond doubt; and the share of a fast step from which a step is none of a rest."""


def frozen_rows(values: Mapping[str, Array]) -> dict[str, Array]:
    """Quantity → mask (n,) of the rows in which its sensor hangs, for those in which any does."""
    way = next((values[key] for key in ("displacement", "contraction", "length") if key in values), None)
    found = {key: _frozen(values[key], way if key == "force" else None) for key in SENSORS if key in values}
    return {key: rows for key, rows in found.items() if rows.any()}


def _frozen(x: Array, way: Array | None) -> Array:
    """Mask (n,) of repeats of a reading after its first, in runs that end in a jump or in which the `way` (n,) goes on.

    A clipped sensor, a rest and a noiseless hold repeat readings too. The first is at an end of the range, and none
    ends in a step that is far larger than those before and behind.
    """
    hung = np.zeros(len(x), bool)
    repeats = x[1:] == x[:-1]
    if not LEAST <= np.count_nonzero(repeats) <= (MOST + RARE) * len(x):
        return hung
    runs = [(b, e) for b, e in _runs(repeats) if e - b >= LEAST]
    inside = sum(e - b for b, e in runs)
    if not runs or inside > MOST * len(x) or repeats.sum() - inside > RARE * len(x):
        return hung
    steps = np.abs(np.diff(x))
    usual = float(np.median(steps[steps > 0.0])) if inside < len(steps) else 0.0
    way = np.zeros(len(x)) if way is None else way
    ways = np.abs(np.diff(way))
    pace, fast = float(np.median(ways)), ways > FAST * float(np.quantile(ways, 0.95))
    for begin, end in runs:
        behind = steps[end + 1 : end + 4]
        wakes = len(behind) == 3 and steps[end] > JUMP * max(float(behind.max()), usual)
        far = np.ptp(way[begin : end + 1]) > FAR * pace > 0.0
        moves = far or np.count_nonzero(fast[begin:end]) >= LEAST
        hung[begin + 1 : end + 1] = (wakes or moves) and x.min() < x[begin] < x.max()
    return hung


def _runs(mask: Array) -> Iterable[tuple[int, int]]:
    """Begin and end of the runs of a mask (n,) that are true."""
    edges = np.flatnonzero(np.diff(np.r_[False, mask, False].astype(np.int8)))
    return zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
