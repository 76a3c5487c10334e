"""How rough a track is: the noise of its sensor."""

import numpy as np

from ..core import Array

NORMAL_MEDIAN = 0.6745
"""Median magnitude of a standard normal number."""
STAIRS, OFTEN = 3.0, 0.6
"""How many times as long the shortest way between two rests is as the longest step that noise makes in one, and share
of windows without a corner from which their median is the noise."""
ROWS = 21
"""Samples around one that tell of the noise at it."""


def position_noise(x: Array, time: Array | None = None) -> float:
    """Standard deviation of the noise on a smooth track (n,), in its unit, from the median of its `roughness`; rows are
    evenly spaced where no `time` (n,), in any unit, is given, or where none of it tells them apart."""
    rough = roughness(x, time)
    if len(rough):
        return float(np.median(rough) / NORMAL_MEDIAN)
    return position_noise(x) if time is not None and len(x) > 4 else 0.0


def noise_in_steps(x: Array, time: Array) -> float:
    """`position_noise` of a track (n,) that may go from rest to rest in few rows: each row is then near a corner, which
    is rough without noise. Where two sorts of steps, STAIRS apart, stand side by side in many windows, the noise is
    that of windows with one sort, or else of the small steps alone."""
    noise, steps = position_noise(x, time), np.abs(np.diff(x))
    sizes = np.sort(steps[steps > 0.0])
    inner = slice(len(sizes) // 20, len(sizes) - len(sizes) // 20)
    apart = sizes[inner][1:] / sizes[inner][:-1]
    if len(apart) < ROWS or apart.max() < STAIRS:
        return noise
    small = steps <= sizes[inner][int(np.argmax(apart))]
    count = np.convolve(small, np.ones(4), "valid")
    alike = (count == 0.0) | (count == 4.0)
    if alike.mean() > OFTEN:
        return noise
    rough = _distances(x, time)[alike]
    rough = rough[np.isfinite(rough)]
    found = np.median(rough) / NORMAL_MEDIAN if len(rough) >= ROWS else np.sqrt(0.5 * np.mean(steps[small] ** 2))
    return min(noise, float(found))


def noise_around(x: Array, time: Array, run: Array | None = None) -> Array:
    """Standard deviation of the noise on a smooth track at each sample, from ROWS around it, shape (n,).

    Of a track that turns between runs, numbered in `run` (n,), only those are taken that have their four neighbours in
    one: at a turn of few samples a track is rough without noise.
    """
    rough = _distances(x, time)
    seen = np.isfinite(rough)
    if run is not None:
        part = np.cumsum(np.diff(run, prepend=run[0]) != 0)
        seen &= part[4:] == part[:-4]
    known = np.flatnonzero(seen)
    if len(known) < ROWS:
        return np.full(len(x), position_noise(x, time))
    around = np.pad(rough[known], ROWS // 2, mode="reflect")
    median = np.median(np.lib.stride_tricks.sliding_window_view(around, ROWS), axis=1)
    nearest = np.searchsorted(0.5 * (known[1:] + known[:-1]) + 2.0, np.arange(len(x)))
    return median[nearest] / NORMAL_MEDIAN


def roughness(x: Array, time: Array | None = None) -> Array:
    """Distance of a sample from the cubic through its four neighbours over what unit noise would make of it, (m,) of
    the samples of a track (n,) that have them; not where a clock is coarser than the rows."""
    off = _distances(x, time)
    return off[np.isfinite(off)]


def _distances(x: Array, time: Array | None) -> Array:
    n = max(len(x) - 4, 0)
    # By the clock as it is: second differences of rows taken as even make a clock's jitter into noise of the sensor,
    # by which strokes then were smoothed, and their ends came out as a rub or as friction.
    t = np.arange(len(x), dtype=float) if time is None else time
    near, shares = (0, 1, 3, 4), []
    with np.errstate(over="ignore", invalid="ignore"):  # steps of a spoilt clock; what is not finite is left out
        for j in near:
            share = np.ones(n)
            for k in near:
                if k != j:
                    apart = t[j : j + n] - t[k : k + n]
                    share *= np.divide(t[2 : 2 + n] - t[k : k + n], apart, out=np.full(n, np.nan), where=apart != 0.0)
            shares.append(share)
        off = x[2 : 2 + n] - sum(share * x[j : j + n] for j, share in zip(near, shares, strict=True))
        return np.where(np.isfinite(off), np.abs(off), np.nan) / np.sqrt(1.0 + sum(share**2 for share in shares))
