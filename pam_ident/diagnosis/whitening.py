"""Filters that make coloured noise white, and their gains for a first-order process."""

import math

import numpy as np
from scipy.linalg import solve_toeplitz

from ..core.recursion import decaying_sum

Array = np.ndarray
LAGS = 16
"""Samples before that foretell the next one of noise of any colour."""


def innovation_variance(series: Array) -> float:
    """Mean square of what the LAGS samples before do not foretell of a series (n,), by linear prediction.

    Its logarithm times n is twice the log likelihood of Gaussian noise of that spectrum, up to a constant (Makhoul
    1975, Proceedings of the IEEE 63, 561–580).
    """
    n = len(series)
    lagged = np.array([series[k:] @ series[: n - k] for k in range(max(min(LAGS, n // 4), 1) + 1)]) / n
    lagged[0] = lagged[0] * (1.0 + 1e-9) + 1e-300
    return float(lagged[0] - lagged[1:] @ solve_toeplitz(lagged[:-1], lagged[1:]))


def innovations(z: Array, decay: Array, gain: Array) -> Array:
    """One-step prediction errors of each column of z (n, k) under a filter, decay and gain (n,), as precise as z."""
    taken = (decay[1:] * gain[:-1]).astype(z.dtype)
    return z - decaying_sum(decay[1:] * (1.0 - gain[:-1]), taken[:, None] * z[:-1])


def filter_gains(decay: Array, share: Array, extra: Array) -> tuple[Array, Array]:
    """Kalman gain and innovation deviation, shape (n, g) each, of unit-variance noise plus white noise `extra`.

    `decay` (n, g) is the memory from the sample before, `share` (g,) the correlated part of the unit variance,
    `extra` (n,) the variance of what is added.

    A step of the variance is a fraction of two straight lines, so a block of steps is one, too: a product of 2 × 2
    matrices. Blocks are multiplied out side by side, then their first variances follow one from the other.
    """
    n, g = decay.shape
    length = math.isqrt(n - 1) + 1
    square = _in_blocks(decay**2, length)
    fresh = (1.0 - square) * share
    white = 1.0 - share + _in_blocks(extra[:, None], length)
    shape = fresh[:, 0].shape
    a, b, c, d = np.ones(shape), np.zeros(shape), np.zeros(shape), np.ones(shape)
    for j in range(length):
        s, q, r = square[:, j], fresh[:, j], white[:, j]
        top, side = s * a + q * c, s * b + q * d  # variance predicted, times the denominator
        a, b, c, d = r * top, r * side, top + r * c, side + r * d
        unit = 1.0 / (c + d)
        a, b, c, d = a * unit, b * unit, c * unit, d * unit
    variance = np.empty_like(fresh[:, 0])
    variance[0] = share
    for k in range(1, len(variance)):
        v = variance[k - 1]
        variance[k] = (a[k - 1] * v + b[k - 1]) / (c[k - 1] * v + d[k - 1])
    gain, total = np.empty_like(fresh), np.empty_like(fresh)
    for j in range(length):
        predicted = square[:, j] * variance + fresh[:, j]
        total[:, j] = predicted + white[:, j]
        gain[:, j] = predicted / total[:, j]
        variance = predicted * (1.0 - gain[:, j])
    return gain.reshape(-1, g)[:n], np.sqrt(total.reshape(-1, g)[:n])


def _in_blocks(rows: Array, length: int) -> Array:
    """Rows (n, g) in blocks, (blocks, length, g), filled up with zeros."""
    short = -len(rows) % length
    return np.vstack([rows, np.zeros((short, rows.shape[1]))]).reshape(-1, length, rows.shape[1])
