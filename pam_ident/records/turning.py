"""Where a displacement track turns, and where it rests."""

from bisect import bisect_left
from itertools import pairwise

import numpy as np

from ..core import Array
from .roughness import roughness

BLOCK = 64
"""Samples that are passed over at once where none of them can be a turn."""
PIECE = 1 << 20
"""Samples of a run that are looked at together at most; a longer run is parted at a turn past its half."""
SPIKE = 0.1
"""Share of the range below which a way of one step is no stroke."""
STRIDE, AWAY, WIDEST = 10, 3.0, 4
"""Samples over which a track's pace is taken, standard deviations of its noise that are no rest, and most neighbours on
either side for a mean."""
STEP, BAND = 8.0, 6.0
"""Standard deviations by which two levels in a rest are apart for sure, if noise is not all white; and those of single
samples within which a rest stays."""
NORMAL_QUARTER = 0.3186
"""Magnitude below which a quarter of standard normal numbers lie."""
NEAR, FAR_STEP = 8, 8.0
"""Samples on either side of a rest's end among which it is looked for, and the step of a stroke in standard deviations
of the noise that needs no such search."""
FEW, FAR = 3, 20.0
"""Samples that make a hold where a stroke would have gone so many bands of noise meanwhile."""


def evened(time: Array, x: Array, noise: float) -> tuple[Array, float]:
    """A track (n,) as means over as many neighbours as strokes at its usual pace take to leave the noise, and what is
    then left of that: by single samples a stroke of less than six standard deviations is none."""
    ways = np.abs(x[STRIDE:] - x[:-STRIDE])
    moved = ways[ways > AWAY * noise]
    half = int(min(AWAY * noise * STRIDE / np.median(moved), WIDEST)) if len(moved) else WIDEST
    if not half or len(x) < 4 * WIDEST:
        return x, noise
    width = 2 * half + 1
    padded = np.r_[2.0 * x[0] - x[half:0:-1], x, 2.0 * x[-1] - x[-2 : -half - 2 : -1]]
    even = np.convolve(padded, np.full(width, 1.0 / width), "valid")
    rough = roughness(even[half::width], time[half::width])  # of noise that neighbours share a mean keeps more
    slow = quantile(rough, 0.25) / NORMAL_QUARTER if len(rough) else noise  # many means are near a corner
    return even, float(min(max(noise / np.sqrt(width), slow), noise))


def pivots(x: Array, threshold: float) -> list[int]:
    """Indices of the turning points of x (n,), ends included, ignoring reversals below the threshold."""
    found, low, high, heading = [0], 0, 0, 0
    whole = len(x) // BLOCK
    blocks = x[: whole * BLOCK].reshape(whole, BLOCK)
    falls = (np.maximum.accumulate(blocks, axis=1) - blocks).max(axis=1, initial=0.0)
    rises = (blocks - np.minimum.accumulate(blocks, axis=1)).max(axis=1, initial=0.0)
    tops, bottoms = ((np.arange(whole) * BLOCK + at(axis=1)).tolist() for at in (blocks.argmax, blocks.argmin))
    quiet_down, quiet_up = (falls <= threshold).tolist(), (rises <= threshold).tolist()
    for b in range(whole + 1):
        if b < whole:
            top, bottom = tops[b], bottoms[b]
            stays_up = quiet_down[b] and x[high] - x[bottom] <= threshold
            stays_down = quiet_up[b] and x[top] - x[low] <= threshold
            if (heading < 0 or stays_up) and (heading > 0 or stays_down):
                high = top if x[top] > x[high] else high
                low = bottom if x[bottom] < x[low] else low
                continue
        for i in range(max(b * BLOCK, 1), min((b + 1) * BLOCK, len(x))):
            if x[i] > x[high]:
                high = i
            if x[i] < x[low]:
                low = i
            if heading >= 0 and x[high] - x[i] > threshold:
                if heading > 0 or x[high] - x[0] > threshold:
                    found.append(high)
                heading, low, high = -1, i, i
            elif heading <= 0 and x[i] - x[low] > threshold:
                if heading < 0 or x[0] - x[low] > threshold:
                    found.append(low)
                heading, low, high = 1, i, i
    if found[-1] != len(x) - 1:
        found.append(len(x) - 1)
    return found


def without_spikes(x: Array, turns: list[int], span: float) -> list[int]:
    """The turning points of x (n,) but those of lone samples off the track: a way back of one step, small beside the
    range `span`, and most of it out in one step, too, is a sensor's spike. Each such spike would count as a reversal,
    and two of them as a cycle."""
    kept: list[int] = []
    for turn in turns:
        last = kept[-1] if kept else turn
        back = abs(x[turn] - x[last])
        lone = turn - last == 1 and back < SPIKE * span and abs(x[last] - x[last - 1]) > 0.5 * back
        if len(kept) > 1 and turn < len(x) - 1 and lone:
            kept.pop()
        else:
            kept.append(turn)
    return kept


def thinned_holds(
    time: Array, x: Array, turns: list[int], noise: float, span: float, even: Array, calm: float
) -> Array:
    """Mask of the samples at rest, shape of x, on means of so many samples that each moves beyond the noise; where none
    are put together, on the `even` track with what noise that has, `calm`."""
    travel = float(np.sum(np.abs(np.diff(x[turns])))) / len(x)
    # Where rows are logged densely a slow stroke moves by less than the noise from one to the next, and all of it
    # would be a hold.
    m = int(np.clip(4.0 * noise / max(travel, 1e-12), 1, max(1, len(x) // (60 * len(turns)))))
    if m == 1:
        return _holds(time, even, turns, max(BAND * calm, 5e-4 * span))
    starts = np.arange(0, len(x) - m + 1, m)
    counts = np.diff(np.r_[starts, len(x)])
    coarse_time, coarse_x = np.add.reduceat(time, starts) / counts, np.add.reduceat(x, starts) / counts
    coarse_turns = sorted({min(turn // m, len(starts) - 1) for turn in turns})
    held = _holds(coarse_time, coarse_x, coarse_turns, max(BAND * noise / np.sqrt(m), 5e-4 * span))
    return np.repeat(held, counts)


def _holds(time: Array, x: Array, turns: list[int], band: float) -> Array:
    """Mask of the samples at rest, shape of x."""
    held = np.zeros(len(x), bool)
    if band <= 0.0:
        return held
    pace = np.zeros(len(x))
    for begin, end in pairwise(turns):
        fast = _pace(time[begin : end + 1], x[begin : end + 1])
        pace[begin : end + 1] = np.maximum(pace[begin : end + 1], fast)
    candidates = _still_after(time, x, 3.0 * band / np.maximum(pace, 1e-12), band).tolist()
    total = np.r_[0.0, np.cumsum(x - x.mean())]
    start = 0
    while (k := bisect_left(candidates, start)) < len(candidates):
        start = candidates[k]
        stop = _leaves(x, start, band)
        middle = (start + stop) // 2
        drift = _mean(total, middle, stop) - _mean(total, start, middle) if stop - start >= 4 else 0.0
        if abs(drift) > 0.5 * band:  # more than it may be, whatever the rounding of the sums
            start += 1
            continue
        way = (time[stop - 1] - time[start]) * max(pace[start:stop].min(), 1e-12)  # what the stroke would have gone
        # To stay in the band is not enough: a slow stroke does for a while. Its two halves must have one mean, too.
        rests = way > 3.0 * band and abs(x[middle:stop].mean() - x[start:middle].mean()) < band / 3.0
        if rests if stop - start >= 4 else stop - start == FEW and way > FAR * band:
            held[start:stop] = True
            start = stop
        else:
            start += 1
    return held


def stepped(x: Array, held: Array, noise: float) -> Array:
    """The mask of rests (n,), parted where one holds two levels that are STEP standard deviations of their means apart:
    a stroke so short that all of it lies in the noise's band."""
    parted = held.copy()
    edges = np.flatnonzero(np.diff(held, prepend=False, append=False)).reshape(-1, 2).tolist()
    while edges and noise > 0.0:
        begin, end = edges.pop()
        n = end - begin
        if n < 2 * NEAR:
            continue
        total = np.cumsum(x[begin:end] - x[begin:end].mean())
        before = np.arange(1, n)
        apart = total[:-1] ** 2 * n / (before * (n - before))  # squares that two means save
        apart[: NEAR - 1] = apart[n - NEAR :] = 0.0
        k = int(np.argmax(apart)) + 1
        if apart[k - 1] < (STEP * noise) ** 2 or apart[k - 1] < _line(total):
            continue
        first, last = begin + k, begin + k
        low, high = x[begin : begin + k].mean(), x[begin + k : end].mean()
        if abs(x[begin + k] - x[begin + k - 1]) > max(0.5 * abs(high - low), BAND * noise):  # no sample between them
            edges += [[begin, begin + k], [begin + k, end]]
            continue
        way = np.sign(high - low)
        while first - 1 > begin and way * (x[first - 1] - low) > 2.0 * noise:
            first -= 1
        while last + 1 < end and way * (high - x[last]) > 2.0 * noise:
            last += 1
        first, last = min(first, begin + k - 1), max(last, begin + k + 1)
        parted[first:last] = False
        edges += [[begin, first], [last, end]]
    return parted


def _line(total: Array) -> float:
    """Squares that a line saves of values whose sums beside their mean are `total` (n,)."""
    n = len(total)
    return float(total[:-1].sum()) ** 2 * 12.0 / (n * (n * n - 1.0))


def with_corners(time: Array, x: Array, held: Array, noise: float) -> Array:
    """A mask of rests (n,) whose ends lie where a level and a parabola beside it describe the track best.

    The noise's band holds some samples of the stroke, too, and lacks some of the rest. Where one step of the stroke is
    far beyond the noise its own line tells, and nothing is changed here.
    """
    sharp = held.copy()
    edges = np.r_[0, np.flatnonzero(np.diff(held)) + 1, len(held)].tolist()
    for before, edge, after in zip(edges, edges[1:], edges[2:], strict=False):
        rest, stroke = np.arange(before, edge)[::-1], np.arange(edge, after)
        rest, stroke = (rest, stroke) if held[before] else (stroke, rest)
        near, far = min(len(rest) // 2, NEAR), min(len(stroke) // 3, NEAR)
        rows = np.r_[rest[::-1][-2 * NEAR :], stroke[: 3 * far]]
        first = min(len(rest), 2 * NEAR) - near
        if near < 2 or far < 2 or np.median(np.abs(np.diff(x[stroke[: far + 1]]))) > FAR_STEP * noise:
            continue
        missed = [_missed(time[rows], x[rows], k) for k in range(first, first + near + far + 1)]
        best = first + int(np.argmin(missed))
        sharp[rows[first:]] = False
        sharp[rows[first:best]] = True
    return sharp


def _missed(time: Array, x: Array, k: int) -> float:
    """Sum of squares that a level of the first k samples and a parabola through the others leave."""
    t = (time[k:] - time[k]) / (time[-1] - time[0])
    basis = np.vander(t, 3)
    off = x[k:] - basis @ np.linalg.lstsq(basis, x[k:], rcond=None)[0]
    return float(np.sum((x[:k] - x[:k].mean()) ** 2) + off @ off)


def _mean(total: Array, begin: int, end: int) -> float:
    return (total[end] - total[begin]) / (end - begin)


def _still_after(time: Array, x: Array, seconds: Array, band: float) -> Array:
    """Indices of the samples that, some seconds (n,) on and half that time on, the track is still within the band of:
    only from these can a hold begin that lasts longer."""
    later = np.searchsorted(time, time + (1.0 - 1e-9) * seconds, side="right")
    reached = np.flatnonzero(later < len(x))
    for share in (1, 2):
        at = reached + (later[reached] - reached) // share
        reached = reached[np.abs(x[at] - x[reached]) <= band]
    return reached


def _leaves(x: Array, start: int, band: float) -> int:
    """Index of the first sample at which the range of x since `start` exceeds the band, len(x) where none does."""
    low = high = x[start]
    begin, size = start + 1, 32
    while begin < len(x):
        highs = np.maximum(np.maximum.accumulate(x[begin : begin + size]), high)
        lows = np.minimum(np.minimum.accumulate(x[begin : begin + size]), low)
        beyond = highs - lows > band
        first = int(beyond.argmax())
        if beyond[first]:
            return begin + first
        low, high, begin, size = lows[-1], highs[-1], begin + size, 2 * size
    return len(x)


def _pace(time: Array, x: Array) -> float:
    """Speed of a stroke while it moves, in mm/s: from at most 40 chords, so that noise between samples adds nothing."""
    at = np.unique(np.linspace(0, len(x) - 1, min(len(x), 41)).astype(int))
    seconds, travel = np.diff(time[at]), np.diff(x[at]) * np.sign(x[-1] - x[0])
    speeds = travel / np.maximum(seconds, 1e-12)
    live = speeds > 0.3 * max(quantile(speeds, 0.9), 0.0)
    return float(travel[live].sum() / max(float(seconds[live].sum()), 1e-12)) if live.any() else 0.0


def quantile(values: Array, share: float) -> float:
    """As NumPy's, of finite values (n,), n > 0; a tenth of its time where they are few."""
    ordered = np.sort(values)
    at = share * (len(ordered) - 1)
    low, high = ordered[int(at)], ordered[min(int(at) + 1, len(ordered) - 1)]
    return float(low + (at - int(at)) * (high - low))
