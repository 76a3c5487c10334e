"""What is noise: how large, how unequal, and how correlated from sample to sample."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import product
from typing import NamedTuple

import numpy as np

from ..core import Inputs
from ..records import Record
from ..records.roughness import noise_around
from .noises import likelier_colour
from .repeats import without_repeats
from .track import SharedNoise, TrackError
from .whitening import filter_gains, innovations

Array = np.ndarray
Place = tuple[int, int]
SMALL, SMALL_COLOURED = 0.04, 0.1
"""Share of the noise's variance that is too small to matter, because for less a wrong name is worse; and what is added
where all noise is coloured: no noise has the colour it is given exactly."""
UNREAD = 1e12
"""Variance, over the noise's, of a sample that says nothing: an outlier, which no filter must take for a zero."""
SHARES = np.array([0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 1.0])
MEMORY_SAMPLES = np.array([0.7, 1.0, 1.5, 2.2, 3.3, 5.0, 8.0, 13.0, 20.0, *40.0 * 2.0 ** np.arange(6)])
"""Up to a wander over minutes: noise that is slower than any here passes for a drift."""
COARSE = tuple(product(range(0, len(MEMORY_SAMPLES), 2), (0, 2, 4, 6, 7)))
BEYOND_WHITE = 12.0
"""Deviance by which a colour must be better than none."""
WANDERS = 2.0
"""Size of slow noise, over that of what is left, up to which it may be: it cannot have been small all the time."""
ALIKE = 0.1
"""Difference in size up to which noises of one colour scanned to the same answer."""


@dataclass(frozen=True)
class Noise:
    """Noise of standard deviation `sigma` (N), of whose variance `share` is correlated from sample to sample.

    `whole` (N) is its size with what an unsure track adds where the force is steep. `memory` is the correlation
    time, in samples or in seconds as `clock` says; `gain` and `spread` are the Kalman gains and innovation deviations
    of a first-order process plus white noise, `decay` its memory from the sample before. `outlier` marks isolated
    samples that no smooth model reaches, and turning points. `deviance` is minus twice the log likelihood of the
    residual it was estimated from, up to a constant: of this process, or of a colour of `noises` where that is
    likelier.
    """

    sigma: float
    whole: float
    share: float
    memory: float
    clock: str
    decay: Array
    gain: Array
    spread: Array
    outlier: Array
    deviance: float
    shared: SharedNoise | None = None

    @property
    def coloured(self) -> bool:
        """Whether neighbouring samples are correlated."""
        return self.share > 0.0

    @property
    def too_small(self) -> float:
        """Share of its variance below which what is left, or what a name explains, does not matter."""
        return SMALL + SMALL_COLOURED * self.share

    def memory_samples(self, time: Array) -> float:
        """Its correlation time in samples that were taken at some times (n,) in s."""
        return self.memory / float(np.median(np.diff(time))) if self.clock == "seconds" else self.memory

    def like(self, other: "Noise") -> bool:
        """Whether another noise has the same colour and practically the same size."""
        same = (self.share, self.memory, self.clock) == (other.share, other.memory, other.clock)
        return same and abs(self.sigma - other.sigma) < ALIKE * other.sigma

    def take(self, rows: Array) -> "Noise":
        """The noise of some samples, by index (m,), as if they followed each other."""
        parts = {name: getattr(self, name)[rows] for name in ("decay", "gain", "spread", "outlier")}
        return replace(self, shared=self.shared.take(rows) if self.shared else None, **parts)

    def whiten(self, columns: Array) -> Array:
        """Scale and decorrelate rows so that noise has unit variance; (n,) or (n, k) in N → the same, as precise."""
        flat = columns.ndim == 1
        table = columns[:, None] if flat else columns
        out = innovations(table, self.decay, self._read) if self.coloured else table
        out = out * self._weight[:, None].astype(table.dtype)
        if self.shared and table.size > 0:  # a law without parameters has no columns
            out = self.shared.even(out)
        return out[:, 0] if flat else out

    @cached_property
    def volume(self) -> float:
        """What is added to the squares of its innovations for minus twice the log likelihood, up to a constant."""
        shared = self.shared.volume if self.shared else 0.0
        return 2.0 * float(np.sum(np.log(self.sigma * self.spread[~self.outlier]))) + shared

    @cached_property
    def _weight(self) -> Array:
        """What a row is multiplied with where noise is white: none of an outlier."""
        return np.where(self.outlier, 0.0, 1.0 / (self.sigma * self.spread))

    @cached_property
    def _read(self) -> Array:
        """The gains without those of outliers, which no other row hears of."""
        return np.where(self.outlier, 0.0, self.gain)


def estimate_noise(
    record: Record,
    residual: Array,
    slope: Array,
    parameters: float,
    outlier: Array | None = None,
    white: bool = False,
    unsure: TrackError | None = None,
) -> Noise:
    """Noise from what a model leaves: white, or partly a first-order process.

    `residual` (N, (n,)) of a model with `parameters` free parameters; `slope` (N/mm) carries what is left of the
    displacement sensor's noise, or of an `unsure` track, into force, where it is likelier with that than without:
    a motion that curves between two samples looks rough, too. `outlier` (mask) is found when not given; `white` forbids
    colour. What comes back with every cycle is left out.
    """
    first = _estimated(record, residual, slope, parameters, outlier, white, unsure)
    slopes = []  # without what the track shares, and without any noise of the driven sensors
    if first[0].shared:
        slopes = [slope, np.zeros_like(slope)]
    elif slope.any():
        slopes = [np.zeros_like(slope)]
    others = (_estimated(record, residual, one, parameters, first[0].outlier, white) for one in slopes)
    _, in_its_colour = min((first, *others), key=lambda one: one[0].deviance)
    return in_its_colour()


def _estimated(
    record: Record,
    residual: Array,
    slope: Array,
    parameters: float,
    outlier: Array | None,
    white: bool,
    unsure: TrackError | None = None,
) -> tuple[Noise, Callable[[], Noise]]:
    """The same with the noise of the driven sensors as they show it, of the first order; and what gives it in the
    likeliest of all colours."""
    middle, shared, calm = _middle(residual), None, residual
    if unsure:
        for _ in range(2):  # the noise's own size is known better once the shared part is down to it
            shared = unsure.in_force(slope, middle)
            calm = shared.even(residual) if shared else residual
            middle = _middle(calm)
    if outlier is None:
        outlier = _isolated(np.abs(calm) > 5.0 * middle)
        outlier |= unsure.unread if unsure else False
    extra = np.zeros(len(residual))
    if record.inputs.time is not None:
        off = unsure.by_itself if unsure else noise_around(record.inputs.displacement_mm, record.inputs.time)
        extra = (off * slope / middle) ** 2
    own = without_repeats(record, residual, ~outlier)
    series = np.where(outlier[:, None], 0.0, np.column_stack([own, residual]) / middle)
    seen = _Seen(series, extra, outlier, shared)
    colour, rough = (WHITE, WHITE) if white else _colour(record.inputs, seen)
    decay = colour.decay(record.inputs)
    gain, spread, shared, passed = seen.through(decay, colour.share)
    left, whole_left = np.sum(passed**2, axis=0)
    # The scale is profiled out: innovations of a coloured residual need not have unit variance.
    sigma = max(middle * float(np.sqrt(left / max((~outlier).sum() - parameters, 1))), 1e-9)
    deviance = 2.0 * float(np.sum(~outlier)) * np.log(sigma) + 2.0 * float(np.sum(np.log(spread)))
    deviance += float(whole_left - left) * (middle / sigma) ** 2
    if shared:
        deviance += shared.volume
    more = float(np.mean(seen.apart[~outlier])) if not outlier.all() else 0.0
    largest = math.sqrt(float(np.sum(residual[~outlier] ** 2)) / max((~outlier).sum() - parameters, 1))

    def whole(size: float) -> float:
        return min(size * math.sqrt(1.0 + more), max(largest, size))

    noise = Noise(sigma, whole(sigma), *colour, decay, gain, spread, outlier, deviance, shared)

    def in_its_colour() -> Noise:
        if colour.share == 0.0:
            return noise
        even = _filled(series[:, 0], outlier) / np.sqrt(1.0 + seen.apart)
        steps = tuple(advance for advance, _ in _clocks(record.inputs).values())
        gained, scale = likelier_colour(even, steps, rough.decay(record.inputs), rough.share)
        return replace(noise, whole=whole(middle * scale), deviance=deviance - gained) if gained > 0.0 else noise

    return noise, in_its_colour


def _filled(z: Array, gaps: Array) -> Array:
    """A series with straight lines across its gaps."""
    if gaps.all():
        return z
    rows = np.arange(len(z))
    return np.interp(rows, rows[~gaps], z[~gaps])


def _middle(residual: Array) -> float:
    """Standard deviation of most of a residual, in N."""
    return max(float(np.median(np.abs(residual))) / 0.6745, 1e-9)


def _isolated(far: Array) -> Array:
    """Samples that are far off singly or in twos."""
    near = np.convolve(far.astype(float), np.ones(7))[3 : len(far) + 3]
    return far & (near <= 2.0)


class Colour(NamedTuple):
    """A first-order process with a `share` of the variance and a `memory` by a clock; the rest is white."""

    share: float
    memory: float
    clock: str

    def decay(self, inputs: Inputs) -> Array:
        """Its memory from the sample before, (n,)."""
        if self.share == 0.0:
            return np.zeros(len(inputs))
        advance, unit = _clocks(inputs)[self.clock]
        return _decays(advance, np.array([self.memory / unit]))[:, 0]


WHITE = Colour(0.0, 0.0, "samples")


@dataclass(frozen=True)
class _Seen:
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


def _colour(inputs: Inputs, seen: _Seen) -> tuple[Colour, Colour]:
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
    for clock, (advance, unit) in _clocks(inputs).items():
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


def _clocks(inputs: Inputs) -> dict[str, tuple[Array, float]]:
    """Ways to count the memory of noise: steps (n,) from sample to sample, and a step's length."""
    assert inputs.time is not None
    step = np.diff(inputs.time, prepend=inputs.time[0])
    unit = float(np.median(step[1:]))
    return {"samples": (np.ones(len(step)), 1.0), "seconds": (step / unit, unit)}


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
