"""Readings that are faults: a sensor that hangs, one reading again and again, and a jump when it wakes or a muscle
that moves meanwhile; single readings that leave all others, as a loose plug or a lost bit makes them.
"""

import math
from collections.abc import Iterable, Mapping

import numpy as np

from ..core import Array

ENOUGH = 20
"""Rows below which a reading is not held against the others."""
FAULTY = 0.01
"""Share of the rows (one at least) up to which such readings are faults; more are the muscle's or the noise's."""
BEYOND = 5.0
"""How many times the largest of the other readings no muscle reaches."""
REACH, FIFTH = 12, 5
"""How far to both sides of a reading others are looked at, the fifth largest of how far those are off: of two spikes
side by side but for a row or two, what lies between is off, too, and none may hide the other."""
TIMES, SHARE = 4.0, 0.02
"""How many times that a reading is off (some ten standard deviations of white noise), and the share of the largest
that it is off: a smaller one decides nothing."""
SENSORS = ("pressure", "displacement", "contraction", "length", "force")
LEAST, CHANCE = 5, 0.01
"""Repeats of a reading from which it may hang, and the probability, in a record, of as many by chance: a coarse sensor,
which repeats more than that share of its other readings, repeats itself, too."""
COARSEST = 0.5
"""Share of repeats from which a sensor is too coarse, or a simulation too still, to tell."""
MOST = 0.2
"""Share of a column up to which its long repeats are faults; more are the protocol's rests."""
JUMP, FAR, FAST = 4.0, 8.0, 0.25
"""How many of its usual steps, and of those just behind it, a sensor jumps by when it wakes; by how many of its usual
bends from row to row the way goes on beyond doubt; and the share of a fast step from which a step is none of a rest."""


def impossible_rows(values: Mapping[str, Array]) -> dict[str, Array]:
    """Force → mask (n,) of the rows, few, whose force is several times as large as every other; empty without any."""
    size = np.abs(values["force"])
    most = _most_faults(len(size))
    largest = np.sort(np.partition(size, -most - 1)[-most - 1 :])
    gaps = np.flatnonzero((largest[1:] > BEYOND * largest[:-1]) & (largest[:-1] > 0.0))
    return {"force": size > largest[gaps[0]]} if most and len(gaps) else {}


def spike_rows(values: Mapping[str, Array]) -> dict[str, Array]:
    """Quantity → mask (n,) of the rows, few, in order of time, in which its sensor leaves its neighbours for one
    reading or two and comes back, for those in which any does.

    It is off the median about it, and off the straight lines through the two before and the two behind: a step, a turn
    of the motion and a burst are not. The first row and the last have nothing to come back to, nor has one beside a
    step of the pressure, which another run or isobar begins with, or of the track itself.
    """
    if "time" not in values or not _most_faults(len(values["time"])):
        return {}
    found = {}
    for key in (key for key in SENSORS if key in values):
        x = values[key] if key == "force" else values[key] - np.median(values[key])
        guards = [values[other] for other in {"pressure", key} - {"force"} if other in values]
        rows = _spikes(x, np.zeros(len(x)) if key == "force" else np.abs(np.diff(x, prepend=x[0])), guards)
        if rows.any():
            found[key] = rows
    return found


def _spikes(x: Array, moves: Array, guards: Iterable[Array]) -> Array:
    """Mask (n,) of the lone readings of a sensor, farther off than it `moves` (n,) from row to row, where it is driven;
    none where one of the `guards` (n,) steps."""
    most, near = _most_faults(len(x)), _windows(x, 2)
    middle = np.partition(near, 2, axis=1)[:, 2]
    bend = np.abs(x - [2.0 * near[:, 1] - near[:, 0], 2.0 * near[:, 3] - near[:, 4]]).min(axis=0)
    off = np.minimum(bend, np.abs(x - middle))
    far = np.flatnonzero(off > SHARE * np.partition(np.abs(x), -most - 1)[-most - 1])
    lone = far[off[far] > TIMES * _usual(np.maximum(bend, moves), far)]
    for guard in guards:
        ends = np.pad(guard, 1, mode="edge")
        across = np.abs(ends[2:] - ends[:-2])
        steps = np.maximum(TIMES * _usual(across, lone), SHARE * np.abs(guard).max())
        lone = lone[across[lone] <= steps]
    return np.isin(np.arange(len(x)), lone if len(lone) <= most else [])


def _usual(x: Array, rows: Array) -> Array:
    """The fifth largest of x (n,) about each of some rows."""
    return np.partition(_windows(x, REACH)[rows], -FIFTH, axis=1)[:, -FIFTH]


def _most_faults(n: int) -> int:
    """How many of n readings may be faults; none of a few, that cannot be held against each other."""
    return max(int(FAULTY * n), 1) if n >= ENOUGH else 0


def _windows(x: Array, reach: int) -> Array:
    """View (n, 2 reach + 1) of the values up to `reach` before and behind each one; the ends are repeated."""
    return np.lib.stride_tricks.sliding_window_view(np.pad(x, reach, mode="edge"), 2 * reach + 1)


def frozen_rows(values: Mapping[str, Array]) -> dict[str, Array]:
    """Quantity → mask (n,) of the rows in which its sensor hangs, for those in which any does."""
    way = next((values[key] for key in ("displacement", "contraction", "length") if key in values), None)
    moves = {"force": way, "pressure": values.get("pressure_set")}
    found = {key: _frozen(values[key], moves.get(key)) for key in SENSORS if key in values}
    return {key: rows for key, rows in found.items() if rows.any()}


def _frozen(x: Array, way: Array | None) -> Array:
    """Mask (n,) of repeats of a reading after its first, in runs that end in a jump or in which the `way` (n,), which
    moves the reading, goes on; of a coarse sensor in runs that do both.

    A clipped sensor, a rest and a noiseless hold repeat readings too. The first is at an end of the range, and none
    ends in a step that is far larger than those before and behind.
    """
    hung = np.zeros(len(x), bool)
    repeats = x[1:] == x[:-1]
    count = np.count_nonzero(repeats)
    if not LEAST <= count <= COARSEST * len(x):
        return hung
    least = max(LEAST, math.log(len(x) / CHANCE) / math.log(len(x) / count))
    runs = [(b, e) for b, e in _runs(repeats) if e - b >= least]
    inside = sum(e - b for b, e in runs)
    if not runs or inside > MOST * len(x):
        return hung
    coarse = count - inside > CHANCE * len(x)
    steps = np.abs(np.diff(x))
    usual = float(np.median(steps[steps > 0.0])) if inside < len(steps) else 0.0
    way = np.zeros(len(x)) if way is None else way
    ways = np.abs(np.diff(way))
    rough = float(np.median(np.abs(np.diff(way, 2)))) or float(np.median(ways))
    fast = ways > FAST * float(np.quantile(ways, 0.95))
    for begin, end in runs:
        behind = steps[end + 1 : end + 4]
        wakes = len(behind) == 3 and steps[end] > JUMP * max(float(behind.max()), usual)
        far = np.ptp(way[begin : end + 1]) > FAR * rough > 0.0
        moves = far or np.count_nonzero(fast[begin:end]) >= LEAST
        hangs = wakes and moves if coarse else wakes or moves
        hung[begin + 1 : end + 1] = hangs and x.min() < x[begin] < x.max()
    return hung


def _runs(mask: Array) -> Iterable[tuple[int, int]]:
    """Begin and end of the runs of a mask (n,) that are true."""
    edges = np.flatnonzero(np.diff(np.r_[False, mask, False].astype(np.int8)))
    return zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
