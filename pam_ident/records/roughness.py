"""How rough a track is: the noise of its sensor."""

import numpy as np

from ..core import Array

NORMAL_MEDIAN = 0.6745
"""Median magnitude of a standard normal number."""
ROWS = 21
"""Samples around one that tell of the noise at it."""


def position_noise(x: Array, time: Array | None = None) -> float:
    """Standard deviation of the noise on a smooth track (n,), in its unit, from the median of its `roughness`; rows are
    evenly spaced where no `time` (n,), in any unit, is given, or where none of it tells them apart."""
    rough = roughness(x, time)
    if len(rough):
        return float(np.median(rough) / NORMAL_MEDIAN)
    return position_noise(x) if time is not None and len(x) > 4 else 0.0


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
