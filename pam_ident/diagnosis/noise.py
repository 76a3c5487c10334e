"""What is noise: how large, how unequal, and how correlated from sample to sample."""

from dataclasses import dataclass

import numpy as np

from ..core.recursion import decaying_sum
from ..records import Record

Array = np.ndarray
SHARES = np.array([0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 1.0])
MEMORY_SAMPLES = np.array([0.7, 1.0, 1.5, 2.2, 3.3, 5.0, 8.0, 13.0, 20.0, 40.0, 80.0])


@dataclass(frozen=True)
class Noise:
    """Noise of a record: standard deviation per sample (N, shape (n,)) and a correlated share of its variance.

    `memory` is the correlation time, in samples or in seconds as `clock` says; `gain` and `spread` are the
    Kalman gains and innovation deviations of the first-order process plus white noise, `decay` its memory from
    the sample before. `outlier` marks isolated samples that no smooth model reaches.
    """

    sigma: Array
    share: float
    memory: float
    clock: str
    decay: Array
    gain: Array
    spread: Array
    outlier: Array

    @property
    def coloured(self) -> bool:
        """Whether neighbouring samples are correlated."""
        return self.share > 0.0

    @property
    def floor(self) -> float:
        """Root mean square of the noise over the record, N."""
        return float(np.sqrt(np.mean(self.sigma[~self.outlier] ** 2)))

    def whiten(self, columns: Array) -> Array:
        """Scale and decorrelate rows so that noise has unit variance; (n,) or (n, k) in N → the same shape."""
        flat = columns.ndim == 1
        scaled = (columns if not flat else columns[:, None]) / self.sigma[:, None]
        scaled[self.outlier] = 0.0
        out = innovations(scaled, self.decay, self.gain) / self.spread[:, None] if self.coloured else scaled
        out[self.outlier] = 0.0
        return out[:, 0] if flat else out


def innovations(z: Array, decay: Array, gain: Array) -> Array:
    """One-step prediction errors of each column of z (n, k) under a filter, decay and gain (n,)."""
    return z - decaying_sum(decay[1:] * (1.0 - gain[:-1]), (decay[1:] * gain[:-1])[:, None] * z[:-1])


def filter_gains(decay: Array, share: Array) -> tuple[Array, Array]:
    """Kalman gain and innovation deviation of unit-variance noise with a correlated share; decay (n, g), share (g,)."""
    gain, spread = np.empty_like(decay), np.empty_like(decay)
    variance = share + 0.0
    for i in range(len(decay)):
        predicted = decay[i] ** 2 * variance + (1.0 - decay[i] ** 2) * share
        total = predicted + 1.0 - share
        gain[i], spread[i] = predicted / total, np.sqrt(total)
        variance = predicted * (1.0 - gain[i])
    return gain, spread


def estimate_noise(record: Record, residual: Array, slope_x: Array, slope_p: Array, parameters: int) -> Noise:
    """Noise from what the richest model leaves.

    `residual` (N, (n,)) of a model with `parameters` free parameters; `slope_x` (N/mm) and `slope_p` (N/MPa)
    carry the sensors' own noise on displacement and pressure into force.
    """
    n = len(residual)
    sensor = _sensor_variance(record, slope_x, slope_p)
    dof = n / max(n - parameters, 1)
    robust = (np.median(np.abs(residual)) / 0.6745) ** 2 * dof
    shape = np.sqrt(np.maximum(robust - np.mean(sensor), 0.2 * robust) + sensor)
    z = residual / np.maximum(shape, 1e-9)
    outlier = _isolated(np.abs(z) > 5.0 * max(np.median(np.abs(z)) / 0.6745, 1e-12))
    scale = np.sqrt(np.mean(z[~outlier] ** 2) * dof) if (~outlier).sum() > 10 else 1.0
    sigma = np.maximum(shape * scale, 1e-9)
    z = np.where(outlier, 0.0, residual / sigma)
    share, memory, clock, decay = _colour(record, z)
    gain, spread = filter_gains(decay[:, None], np.array([share]))
    return Noise(sigma, share, memory, clock, decay, gain[:, 0], spread[:, 0], outlier)


def _sensor_variance(record: Record, slope_x: Array, slope_p: Array) -> Array:
    """Variance in N² that noise of the displacement and pressure sensors brings, shape (n,)."""
    if record.inputs.time is None:
        return np.zeros(len(record))
    x, p = record.inputs.displacement_mm, record.inputs.pressure - record.level
    noise = [np.median(np.abs(np.diff(v, 2))) / 0.6745 / np.sqrt(6.0) if len(v) > 4 else 0.0 for v in (x, p)]
    return (slope_x * noise[0]) ** 2 + (slope_p * noise[1]) ** 2


def _isolated(far: Array) -> Array:
    """Samples that are far off singly or in twos."""
    near = np.convolve(far.astype(float), np.ones(7), "same")
    return far & (near <= 2.0)


def _colour(record: Record, z: Array) -> tuple[float, float, str, Array]:
    """Correlated share, memory and clock that make z most likely; white unless clearly better."""
    n = len(z)
    white = np.zeros(n)
    inputs = record.inputs
    if inputs.time is None or n < 60:
        return 0.0, 0.0, "samples", white
    lags = [float(np.mean(z[:-k] * z[k:])) for k in (1, 2, 3, 4)]
    if max(lags[0], 0.5 * sum(lags)) < 3.0 / np.sqrt(n):
        return 0.0, 0.0, "samples", white
    step = np.diff(inputs.time, prepend=inputs.time[0])
    unit = float(np.median(step[1:]))
    best = (float(np.sum(z**2)) + 12.0, 0.0, 0.0, "samples", white)
    memories, shares = (m.ravel() for m in np.meshgrid(MEMORY_SAMPLES, SHARES))
    for clock, advance in (("samples", np.ones(n)), ("seconds", step / unit)):
        decay = np.exp(-advance[:, None] / memories)
        decay[0] = 0.0
        gain, spread = filter_gains(decay, shares)
        cost = np.array(
            [
                np.sum((innovations(z[:, None], decay[:, g], gain[:, g])[:, 0] / spread[:, g]) ** 2)
                + 2.0 * np.sum(np.log(spread[:, g]))
                for g in range(len(shares))
            ]
        )
        k = int(np.argmin(cost))
        if cost[k] < best[0]:
            memory = float(memories[k]) * (unit if clock == "seconds" else 1.0)
            best = (float(cost[k]), float(shares[k]), memory, clock, decay[:, k])
    return best[1:]
