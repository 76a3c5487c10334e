"""How rough a track is: the noise of its sensor."""

import numpy as np

Array = np.ndarray
NORMAL_MEDIAN = 0.6745
"""Median magnitude of a standard normal number."""


def position_noise(x: Array, time: Array | None = None) -> float:
    """Standard deviation of the noise on a smooth track (n,), in its unit, from the median of its `roughness`; rows are
    evenly spaced where no `time` (n,), in any unit, is given, or where none of it tells them apart."""
    rough = roughness(x, time)
    if len(rough):
        return float(np.median(rough) / NORMAL_MEDIAN)
    return position_noise(x) if time is not None and len(x) > 4 else 0.0


def noise_around(x: Array, time: Array, rows: int = 21) -> Array:
    """Standard deviation of the noise on a smooth track at each sample, from `rows` around it, shape (n,)."""
    if len(x) < rows + 4:
        return np.full(len(x), position_noise(x, time))
    rough = np.pad(_distances(x, time), 2, constant_values=np.nan)
    rough[~np.isfinite(rough)] = np.median(rough[np.isfinite(rough)]) if np.isfinite(rough).any() else 0.0
    around = np.pad(rough, rows // 2, mode="reflect")
    return np.median(np.lib.stride_tricks.sliding_window_view(around, rows), axis=1) / NORMAL_MEDIAN


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
