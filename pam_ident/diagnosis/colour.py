"""The colour of noise: how it is correlated from sample to sample."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import product
from typing import NamedTuple

import numpy as np

from ..core import Inputs
from .track import SharedNoise
from .whitening import filter_gains, innovations

Array = np.ndarray
Place = tuple[int, int]
UNREAD = 1e12
"""Variance, over the noise's, of a sample that says nothing: an outlier, which no filter must take for a zero."""
SHARES = np.array([0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 0.95, 0.98, 0.99, 0.995, 1.0])
MEMORY_SAMPLES = np.array([0.7, 1.0, 1.5, 2.2, 3.3, 5.0, 8.0, 13.0, 20.0, *40.0 * 2.0 ** np.arange(6)])
"""Up to a wander over minutes: noise that is slower than any here passes for a drift."""
COARSE = tuple(product(range(0, len(MEMORY_SAMPLES), 2), (0, 2, 4, 6, 8, 10)))
"""Places in (MEMORY_SAMPLES, SHARES) where a search begins."""
BEYOND_WHITE = 12.0
"""Deviance by which a colour must be better than none."""
UNEVEN, SELDOM = 0.5, 0.01
"""Share of the usual step by which another differs, and share of steps that differ by more, up to which samples count
time."""
WANDERS = 2.0
"""Size of slow noise, over that of what is left, up to which it may be: it cannot have been small all the time."""


class Colour(NamedTuple):
    """A first-order process with a `share` of the variance and a `memory` by a clock; the rest is white."""

    share: float
    memory: float
    clock: str

    def decay(self, inputs: Inputs) -> Array:
        """Its memory from the sample before, (n,)."""
        if self.share == 0.0:
            return np.zeros(len(inputs))
        advance, unit = clocks(inputs)[self.clock]
        return _decays(advance, np.array([self.memory / unit]))[:, 0]


WHITE = Colour(0.0, 0.0, "samples")


@dataclass(frozen=True)
class Seen:
    """What noise is estimated from: columns z (n, k) about of unit variance, with `extra` (n,) variance of each row and
    what rows have in common."""

    z: Array
    extra: Array
    outlier: Array
    shared: SharedNoise | None

    @cached_property
    def apart(self) -> Array:
        """The variance of each row besides, with what it has in common with others as if it were its own, (n,)."""
        return self.extra + (self.shared.variance if self.shared else 0.0)

    def through(self, decay: Array, share: float) -> tuple[Array, Array, SharedNoise | None, Array]:
        """Gains and deviations of innovations (n,) in noise of which a `share` remembers the sample before by `decay`
        (n,), what these have in common, and z as white."""
        gain, spread = (v[:, 0] for v in filter_gains(decay[:, None], np.array([share]), self._unread(self.extra)))
        spread = np.where(self.outlier, 1.0, spread)

        def white(columns: Array) -> Array:
            return np.where(self.outlier[:, None], 0.0, innovations(columns, decay, gain) / spread[:, None])

        shared = self.shared.through(white) if self.shared else None
        passed = white(self.z)
        return gain, spread, shared, shared.even(passed) if shared else passed

    def deviance(self, decay: Array, share: float) -> float:
        """Minus twice the log likelihood of the first column in such noise, its scale profiled out, to a constant."""
        _, spread, shared, passed = self.through(decay, share)
        read = float(np.sum(~self.outlier))
        square = float(np.sum(passed[:, 0] ** 2)) / read
        return read * math.log(square) + 2.0 * float(np.sum(np.log(spread))) + (shared.volume if shared else 0.0)

    def exactly(self, places: Sequence[Place], advance: Array) -> list[float]:
        """The same for some memories, in steps (n,), and shares."""
        return [self.deviance(_decays(advance, MEMORY_SAMPLES[[k]])[:, 0], float(SHARES[j])) for k, j in places]

    def deviances(self, places: Sequence[Place], advance: Array) -> list[float]:
        """The same, with what rows have in common as if it were their own, all at once."""
        which = np.array(places)
        memory, share = MEMORY_SAMPLES[which[:, 0]], SHARES[which[:, 1]]
        decay, extra, z = _decays(advance, memory), self._unread(self.apart), self.z[:, :1]
        gain, spread = filter_gains(decay, share, extra)
        left = [innovations(z, d, g)[:, 0] for d, g in zip(decay.T, gain.T, strict=True)]
        logs, read = 2.0 * np.sum(np.log(spread[~self.outlier]), axis=0), float(np.sum(~self.outlier))
        square = np.sum([(e / s) ** 2 for e, s in zip(left, spread.T, strict=True)], axis=1) / read
        most = WANDERS**2 * np.mean(z[:, 0] ** 2 / (1.0 + extra))
        return np.where(square > most, np.inf, read * np.log(square) + logs).tolist()

    def _unread(self, extra: Array) -> Array:
        return np.where(self.outlier, UNREAD, extra)


def colour_of(inputs: Inputs, seen: Seen) -> tuple[Colour, Colour]:
    """The colour that makes what is seen most likely, white unless clearly better; and that with what rows have in
    common as if it were their own, which is near it and found sooner."""
    n = len(seen.z)
    if inputs.time is None or n < 60:
        return WHITE, WHITE
    passed = seen.through(np.zeros(n), 0.0)[-1][:, 0]
    square = max(float(np.mean(passed**2)), 1e-300)
    lags = [float(np.mean(passed[:-k] * passed[k:])) / square for k in (1, 2, 3, 4)]
    if max(lags[0], 0.5 * sum(lags)) < 3.0 / np.sqrt(n):
        return WHITE, WHITE
    best, least = (WHITE, WHITE), seen.deviance(np.zeros(n), 0.0) - BEYOND_WHITE
    for clock, (advance, unit) in clocks(inputs).items():
        rough, criterion = _likeliest(partial(seen.deviances, advance=advance), COARSE)
        place = rough
        if seen.shared:
            place, criterion = _likeliest(partial(seen.exactly, advance=advance), [rough])
        if criterion < least:
            best, least = (_at(place, clock, unit), _at(rough, clock, unit)), criterion
    return best


def _at(place: Place, clock: str, unit: float) -> Colour:
    return Colour(float(SHARES[place[1]]), float(MEMORY_SAMPLES[place[0]]) * unit, clock)


def _decays(advance: Array, memory: Array) -> Array:
    """Memory from the sample before, (n, m), by steps (n,) and memories (m,) in such steps."""
    decay = np.exp(-advance[:, None] / memory)
    decay[0] = 0.0
    return decay


def clocks(inputs: Inputs) -> dict[str, tuple[Array, float]]:
    """Ways to count the memory of noise: steps (n,) from sample to sample, and a step's length; one where hardly any
    step differs from it."""
    assert inputs.time is not None
    step = np.diff(inputs.time, prepend=inputs.time[0])
    unit = float(np.median(step[1:]))
    found = {"seconds": (step / unit, unit)}
    if np.mean(np.abs(step[1:] / unit - 1.0) > UNEVEN) > SELDOM:
        found["samples"] = (np.ones(len(step)), 1.0)
    return found


def _likeliest(deviances: Callable[[Sequence[Place]], list[float]], first: Sequence[Place]) -> tuple[Place, float]:
    """Place in (MEMORY_SAMPLES, SHARES) of the likeliest process, and its deviance: at the first ones, then near."""
    found: dict[Place, float] = {}

    def weigh(places: Iterable[Place]) -> Place:
        new = [(k, j) for k, j in places if (k, j) not in found and k < len(MEMORY_SAMPLES) and j < len(SHARES)]
        if new:
            found.update(zip(new, deviances(new), strict=True))
        return min(found, key=found.__getitem__)

    here = weigh(first)
    while True:
        k, j = here
        near = weigh(product(range(max(k - 1, 0), k + 2), range(max(j - 1, 0), j + 2)))
        if near == here:
            return here, found[here]
        here = near
