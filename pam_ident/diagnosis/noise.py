"""What is noise: how large, how unequal, and how correlated from sample to sample."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..records import Record
from ..records.roughness import noise_around
from .colour import WHITE, Seen, clocks, colour_of
from .noises import likelier_colour
from .repeats import without_repeats
from .track import SharedNoise, TrackError
from .whitening import innovations

Array = np.ndarray
SMALL, SMALL_COLOURED = 0.04, 0.1
"""Share of the noise's variance that is too small to matter, because for less a wrong name is worse; and what is added
where all noise is coloured: no noise has the colour it is given exactly."""
OTHER_SIZE = 1.0 / 3.0
"""Share by which the variance of what is left exceeds that of the noise it is taken for, from which it is not that
noise: 0.27 at most in 262 records without anything hidden."""
SELDOM = 0.02
"""Share of the samples that single readings are far off in, at most."""
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
        outlier = isolated(calm, middle)
        outlier |= unsure.unread if unsure else False
    extra = np.zeros(len(residual))
    if record.inputs.time is not None:
        off = unsure.by_itself if unsure else noise_around(record.inputs.displacement_mm, record.inputs.time)
        extra = (off * slope / middle) ** 2
    own = without_repeats(record, residual, ~outlier)
    series = np.where(outlier[:, None], 0.0, np.column_stack([own, residual]) / middle)
    seen = Seen(series, extra, outlier, shared)
    colour, rough = (WHITE, WHITE) if white else colour_of(record.inputs, seen)
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
        even = filled(series[:, 0], outlier) / np.sqrt(1.0 + seen.apart)
        steps = tuple(advance for advance, _ in clocks(record.inputs).values())
        gained, scale = likelier_colour(even, steps, rough.decay(record.inputs), rough.share)
        return replace(noise, whole=whole(middle * scale), deviance=deviance - gained) if gained > 0.0 else noise

    return noise, in_its_colour


def filled(z: Array, gaps: Array) -> Array:
    """A series (n,) with straight lines across its gaps (mask, (n,))."""
    if gaps.all():
        return z
    rows = np.arange(len(z))
    return np.interp(rows, rows[~gaps], z[~gaps])


def _middle(residual: Array) -> float:
    """Standard deviation of most of a residual, in N."""
    return max(float(np.median(np.abs(residual))) / 0.6745, 1e-9)


def isolated(residual: Array, size: float | None = None) -> Array:
    """Samples (n,) of what a model leaves that are far off singly or in twos, by the `size` of most of it, in N; none
    where they are more than SELDOM: then they are no faults of reading."""
    far = np.abs(residual) > 5.0 * (size or _middle(residual))
    near = np.convolve(far.astype(float), np.ones(7))[3 : len(far) + 3]
    found = far & (near <= 2.0)
    return found if np.mean(found) <= SELDOM else np.zeros(len(found), bool)
