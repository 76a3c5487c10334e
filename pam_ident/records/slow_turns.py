"""Where a drive turns so slowly that the sensor cannot see it move: no rest."""

from collections import Counter
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..core import Array
from .roughness import roughness
from .smoothing import FEWEST, NOISE_ONLY, along, chebyshev_waves, moves_on, noise_only, smooth_basis

SLOW_ORDERS = 12
"""Highest order of a polynomial that describes a drive's slow turn: enough for a sine, too few for a corner."""
LONGER = 1.5
"""Times the longest slow turn from which a record's first or last rest is a wait, and no turn."""
INNER, AS_GOOD = 0.7, 1.05
"""Share of half a rest that is far from its end, and the squares, over those that rests miss, that smooth strokes may
miss where the muscle moves on even there."""


def without_slow_turns(
    time: Array, x: Array, turns: list[int], held: Array, sharp: Array, noise: float
) -> tuple[list[int], Array]:
    """The turning points, and a mask of the rests (n,), without those where a drive turns so slowly that the sensor
    cannot see it: smooth strokes run from the middle of each to the next, and describe the track to the noise, and
    better than rests and strokes between them do, or as well where it moves on even in these. All strokes together, or
    else those that are smooth by themselves: in a test at several rates some turn slowly, and others rest. A record may
    wait before its first stroke and behind its last."""
    edges = np.flatnonzero(np.diff(held, prepend=False, append=False))
    ends = []
    for turn in turns:
        begin, end = turn, turn
        if held[turn]:
            after = int(np.searchsorted(edges, turn, side="right"))
            begin, end = int(edges[after - 1]), int(edges[after]) - 1
        ends.append((begin, end))
    turns_in = Counter(ends)
    ends = [(turn, turn) if turns_in[rest] > 1 else rest for turn, rest in zip(turns, ends, strict=True)]
    middles = [(begin + end) // 2 for begin, end in ends]
    longest = LONGER * max((end - begin + 1 for begin, end in ends[1:-1]), default=len(x))
    waits = [end - begin > longest for begin, end in (ends[0], ends[-1])]  # before the first stroke, behind the last
    middles[0], middles[-1] = ends[0][waits[0]], ends[-1][not waits[1]]
    if any(time[end] <= time[begin] for begin, end in pairwise(middles)):
        return turns, sharp
    strokes = [
        _SlowStroke.of(time[begin : end + 1], x[begin : end + 1], held[begin : end + 1], sharp[begin : end + 1])
        for begin, end in pairwise(middles)
    ]
    known = [one for one in strokes if one]
    smooth = np.ones(len(strokes), bool)
    if not _nothing_rests(known, noise):
        smooth[:] = [one is None or (one.still.mean() < 0.5 and one.is_smooth(noise)) for one in strokes]
        if not _nothing_rests([one for one, alone in zip(strokes, smooth, strict=True) if one and alone], noise):
            return turns, sharp
    beside = np.r_[True, smooth] & np.r_[smooth, True]  # turns between two smooth strokes
    rests = sharp.copy()
    for k in np.flatnonzero(smooth):
        begin = middles[k] if beside[k] else ends[k][1] + 1
        rests[begin : middles[k + 1] + 1 if beside[k + 1] else ends[k + 1][0]] = False
    return [m if alone else turn for m, turn, alone in zip(middles, turns, beside, strict=True)], rests


@dataclass(frozen=True)
class _SlowStroke:
    """What a smooth stroke misses of a track (n,), its rows that seem to rest, the roughness of the others, and the
    squares that rests and strokes between them miss; each with what it leaves free. In the middle of each rest, those
    that its level misses and those that a line does, of so many lines."""

    off: Array
    still: Array
    calm: Array
    free: int
    by_rests: float
    free_of_rests: int
    level: float
    line: float
    lines: int
    free_of_lines: int

    @classmethod
    def of(cls, t: Array, x: Array, held: Array, sharp: Array) -> "_SlowStroke | None":
        """None of too few rows to tell a smooth stroke by."""
        if len(t) < FEWEST:
            return None
        even = np.linspace(t[0], t[-1], len(t))  # between few rows at rest a curve could do as it likes
        way, still = np.interp(even, t, x), np.interp(even, t, held.astype(float)) > 0.0
        waves = chebyshev_waves(even, min(SLOW_ORDERS, len(t) // 3))
        resting, by_rests, free = np.interp(even, t, sharp.astype(float)) > 0.5, 0.0, 0
        for part in np.split(np.arange(len(t)), np.flatnonzero(np.diff(resting)) + 1):
            level = resting[part[0]] or len(part) < 4
            basis = np.ones((len(part), 1)) if level else smooth_basis(even[part], len(part))
            by_rests += float(np.sum((way[part] - along(basis, way[part])) ** 2))
            free += len(part) - basis.shape[1]
        calm = roughness(way)[np.convolve(still, np.ones(5), "valid") == 0.0]
        level, line, lines, rows = 0.0, 0.0, 0, 0
        for half in (held, held[::-1]):
            rest = np.arange(int(INNER * (len(half) if half.all() else np.argmin(half))))
            rest = rest if half is held else len(t) - 1 - rest
            if len(rest) >= 4:
                level += float(np.sum((x[rest] - x[rest].mean()) ** 2))
                line += float(np.sum((x[rest] - along(chebyshev_waves(t[rest], 1), x[rest])) ** 2))
                lines, rows = lines + 1, rows + len(rest) - 2
        return cls(
            way - along(waves, way), still, calm, len(t) - waves.shape[1], by_rests, free, level, line, lines, rows
        )

    def is_smooth(self, noise: float) -> bool:
        """Whether it misses noise alone, where it moves and where it seems to rest."""
        whole = float(np.sqrt(np.mean(np.r_[noise, self.calm] ** 2)))
        taken = len(self.off) - self.free
        return noise_only(self.off, whole, taken) and noise_only(self.off[self.still], noise, 1)


def _nothing_rests(strokes: list[_SlowStroke], noise: float) -> bool:
    """Whether smooth strokes describe what seems to rest, all of them together."""
    if not any(one.still.any() for one in strokes):
        return False
    off, still = (np.concatenate([getattr(one, name) for one in strokes]) for name in ("off", "still"))
    # Of the moving rows, too: there a jittering clock's noise grows with the speed.
    whole = np.sqrt(np.mean(np.concatenate([[noise], *(one.calm for one in strokes)]) ** 2))
    smooth = np.std(off) < NOISE_ONLY * whole and np.std(off[still]) < NOISE_ONLY * noise
    by_rests, free, rested = (sum(getattr(one, k) for one in strokes) for k in ("by_rests", "free", "free_of_rests"))
    sums = (sum(getattr(one, k) for one in strokes) for k in ("level", "line", "lines", "free_of_lines"))
    as_good = AS_GOOD if moves_on(*sums) else 1.0
    return bool(smooth and float(off @ off) * rested < as_good * by_rests * free)  # each over what it leaves free
