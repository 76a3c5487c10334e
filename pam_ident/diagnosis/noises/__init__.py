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
    others = [_Mixtures.of(name, steps.tobytes()).deviances(z) for name in catalogue() for steps in clocks]
    deviances, squares = (np.concatenate(parts) for parts in zip(first, *others, strict=True))
    best = int(np.argmin(deviances))
    return float(deviances[0] - deviances[best]), float(np.sqrt(squares[best]))


def _deviance(innovation: Array, spread: Array) -> tuple[Array, Array]:
    """Minus twice the log likelihood of columns (n, m), their scale profiled out, up to a constant, and that scale's
    square, shape (m,) each."""
    square = np.mean((innovation / spread) ** 2, axis=0)
    return len(spread) * np.log(square) + 2.0 * np.sum(np.log(spread), axis=0), square


@dataclass(frozen=True)
class _Mixtures:
    """The Kalman filters of a colour's mixtures on a clock: memory from the sample before, (n, 1, k), gains (n, m, k)
    and deviations of the innovations (n, m)."""

    decay: Array
    gain: Array
    spread: Array

    @classmethod
    @lru_cache(maxsize=4)
    def of(cls, name: str, clock: bytes) -> "_Mixtures":
        """Those of a colour by its name, and of steps from sample to sample (n,) as bytes."""
        steps = np.frombuffer(clock)
        memory, variance = catalogue()[name].mixtures(float(np.sum(steps)))
        decay = np.exp(-steps[:, None, None] / memory)
        white = 1.0 - variance.sum(axis=1)
        unit = variance[:, :, None] * np.eye(len(memory))
        covariance, fresh = unit.copy(), unit * (1.0 - decay**2)[:, :, :, None]
        gain, spread = np.empty((len(steps), *variance.shape)), np.empty((len(steps), len(variance)))
        for k, (kept, new) in enumerate(zip(decay, fresh, strict=True)):
            covariance = covariance * (kept[:, :, None] * kept[:, None, :]) + new if k else covariance
            seen = covariance.sum(axis=2)
            total = seen.sum(axis=1) + white
            gain[k], spread[k] = seen / total[:, None], total
            covariance = covariance - gain[k][:, :, None] * seen[:, None, :]
        return cls(decay, gain, np.sqrt(spread))

    def deviances(self, z: Array) -> tuple[Array, Array]:
        """Of a series (n,), with the squares of its scale, shape (m,) each."""
        state, left = np.zeros(self.gain.shape[1:]), np.empty(self.spread.shape)
        for k, value in enumerate(z):
            state = state * self.decay[k]
            left[k] = value - state.sum(axis=1)
            state += self.gain[k] * left[k][:, None]
        return _deviance(left, self.spread)
