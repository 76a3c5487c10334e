"""Colours that noise may have, one a file.

A file that defines NOISE takes part: where one of its mixtures is likelier than the best first-order process, which the
estimate is made with, the noise has its likelihood.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np

from ...core.discover import instances
from ..whitening import filter_gains, innovations

Array = np.ndarray


@dataclass(frozen=True)
class NoiseColour:
    """A family of mixtures of white noise with processes of the first order.

    `mixtures` takes the length of a record in steps of a clock, and gives the memories of the processes in such steps,
    (k,), and some sets of their variances, (m, k); what a set lacks of 1 is white.
    """

    name: str
    source: str
    mixtures: Callable[[float], tuple[Array, Array]]


@cache
def catalogue() -> dict[str, NoiseColour]:
    """Every colour by name."""
    return {one.name: one for one in instances(__name__, __path__, NoiseColour)}


def likelier_colour(z: Array, clocks: Sequence[Array], decay: Array, share: float) -> tuple[float, float]:
    """By how much the deviance of z (n,), about of unit variance, falls if its noise has the best of these colours, and
    how large that noise is.

    It is held against a first-order process with a `share` of the variance and the memory `decay` (n,) from sample to
    sample; `clocks` are the steps (n,) from sample to sample, in samples or as time goes.
    """
    gain, spread = filter_gains(decay[:, None], np.array([share]), np.zeros(len(z)))
    first = _deviance(innovations(z[:, None], decay, gain[:, 0]), spread)
    others = _Mixtures.of(tuple(catalogue()), tuple(steps.tobytes() for steps in clocks)).deviances(z)
    deviances, squares = (np.concatenate(parts) for parts in zip(first, others, strict=True))
    best = int(np.argmin(deviances))
    return float(deviances[0] - deviances[best]), float(np.sqrt(squares[best]))


def _deviance(innovation: Array, spread: Array) -> tuple[Array, Array]:
    """Minus twice the log likelihood of columns (n, m), their scale profiled out, up to a constant, and that scale's
    square, shape (m,) each."""
    square = np.mean((innovation / spread) ** 2, axis=0)
    return len(spread) * np.log(square) + 2.0 * np.sum(np.log(spread), axis=0), square


@dataclass(frozen=True)
class _Mixtures:
    """The Kalman filters of all colours' mixtures on some clocks, side by side: memory from the sample before and
    gains, (n, k, m), and deviations of the innovations (n, m)."""

    decay: Array
    gain: Array
    spread: Array

    @classmethod
    @lru_cache(maxsize=2)
    def of(cls, names: tuple[str, ...], clocks: tuple[bytes, ...]) -> "_Mixtures":
        """Those of colours by their names, and of steps from sample to sample (n,) as bytes."""
        each = [(np.frombuffer(clock), catalogue()[name]) for name in names for clock in clocks]
        made = [(steps, *colour.mixtures(float(np.sum(steps)))) for steps, colour in each]
        k = max(len(memory) for _, memory, _ in made)
        decays, parts = [], []
        for steps, memory, variance in made:
            decay = np.exp(-steps[:, None] / np.pad(memory, (0, k - len(memory)), constant_values=1.0))
            decays.append(np.repeat(decay[:, :, None], len(variance), axis=2))
            parts.append(np.pad(variance, ((0, 0), (0, k - len(memory)))).T)
        return cls._filtering(np.concatenate(decays, axis=2), np.concatenate(parts, axis=1))

    @classmethod
    def _filtering(cls, decay: Array, variance: Array) -> "_Mixtures":
        """Of memories (n, k, m) and variances (k, m); the first sample remembers nothing."""
        decay[0] = 1.0
        k, m = variance.shape
        white, fresh = 1.0 - variance.sum(axis=0), variance * (1.0 - decay**2)
        gain, spread = np.empty(decay.shape), np.empty((len(decay), m))
        covariance = np.zeros((k, k, m))
        covariance[range(k), range(k)] = variance
        diagonal = covariance.reshape(k * k, m)[:: k + 1]
        for kept, new, own, total in zip(decay, fresh, gain, spread, strict=True):
            covariance *= kept[:, None] * kept
            diagonal += new
            seen = covariance.sum(axis=0)
            np.add(seen.sum(axis=0), white, out=total)
            np.divide(seen, total, out=own)
            covariance -= seen[:, None] * own
        return cls(decay, gain, np.sqrt(spread))

    def deviances(self, z: Array) -> tuple[Array, Array]:
        """Of a series (n,), with the squares of its scale, shape (m,) each."""
        state, left = np.zeros(self.gain.shape[1:]), np.empty(self.spread.shape)
        for value, decay, gain, error in zip(z, self.decay, self.gain, left, strict=True):
            state *= decay
            np.subtract(value, state.sum(axis=0), out=error)
            state += gain * error
        return _deviance(left, self.spread)
