"""Smooth courses of strokes and rests, where these describe what was measured to the noise."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.polynomial import chebyshev

from ..core import Array
from .roughness import position_noise
from .turning import quantile

FEWEST = 12
"""Samples of a stroke that a polynomial is fitted to."""
LARGEST = 4.0
"""Standard deviations that a sample of noise alone is off at most."""
NOISE_ONLY = 1.25
"""Ratio to the sensor's noise up to which what a curve misses of a stroke is noise alone."""
ALIKE = 0.25
"""Correlation of neighbours in it up to which it is, where there are too many samples for chance to matter."""
SETTLING, CHANCE = 8, 1e-3
"""Samples of a hold from which it may settle along a curve, and the chance that a record's rests are taken for that, or
its held pressures for ones that waver."""
SLOPE_NOISE = 0.01
"""Share of a stroke's speed that the sensor's noise may make of the speed at a sample."""


def smooth_stroke(time: Array, x: Array, noise: float) -> tuple[Array, Array]:
    """Position and dx/dt (n,) along one stroke, x over the time in s: a polynomial where that describes it to noise,
    else x and local slopes."""
    n, width = len(x), float(np.ptp(time))
    if width <= 0.0:
        return x, np.zeros(n)
    position = x
    if n >= FEWEST:
        waves = smooth_basis(time, n)
        few = waves[:, : min(7, n // 6) + 1]  # of more, a slope would swing at the ends of a stroke
        curve = np.linalg.lstsq(few, x, rcond=None)[0]
        missed = np.std(x - few @ curve)
        basis = np.linalg.qr(waves)[0]
        off, spread = x - basis @ (basis.T @ x), 1.0 - np.sum(basis**2, axis=1)
        # A curve that misses more than noise, of all samples or of one at an end, is off at the ends of every stroke
        # alike, which comes out as friction or creep: then the position stays as measured.
        smooth = noise_only(off, noise, waves.shape[1]) and np.all(off**2 <= (LARGEST * noise) ** 2 * spread)
        position = x - off if smooth else x
        slopes = chebyshev_slopes(few, curve, width)
        if missed < 2e-4 * np.ptp(x) or noise_only(x - few @ curve, noise, len(curve)):
            return position, slopes
        parabolas, rates = soft_course(time)
        curve = np.linalg.lstsq(parabolas, x, rcond=None)[0]
        if noise_only(x - parabolas @ curve, noise, len(curve)):
            return position, rates @ curve
        if missed < 3.0 * noise:
            return position, slopes
    return position, _local_slopes(time, x, noise)


def soft_course(time: Array) -> tuple[Array, Array]:
    """Parabolas over the times (m,) of a stroke that meet smoothly 2, 4, 8 … samples from its ends, (m, k), and their
    slopes: a drive speeds up and brakes there, and goes on steadily between."""
    n, width = len(time), float(np.ptp(time))
    near = 2 ** np.arange(1, max(int(np.log2(n / 3.0)), 1) + 1)
    knots = np.r_[time[near], time[n - 1 - near]]
    t = (time - time[0])[:, None] / width
    beyond = np.maximum(time[:, None] - knots, 0.0) / width
    return np.hstack([np.ones_like(t), t, t**2, beyond**2]), np.hstack(
        [np.zeros_like(t), np.ones_like(t), 2.0 * t, 2.0 * beyond]
    ) / width


def noise_only(off: Array, noise: float, taken: int) -> bool:
    """Whether what a curve of `taken` parameters misses, (n,), is white noise of a standard deviation; nothing is.

    A curve that cuts a kink misses little in all, but neighbours in the same sense.
    """
    if not len(off):
        return True
    free, square = max(len(off) - taken, 1), float(off @ off)
    white = off[1:] @ off[:-1] <= max(4.0 / np.sqrt(len(off)), ALIKE) * square
    return bool(white and square < max(NOISE_ONLY**2, 1.0 + 3.0 * np.sqrt(2.0 / free)) * noise**2 * free)


def smooth_basis(time: Array, n: int) -> Array:
    """Polynomials over the times (m,) of a stroke of `n` samples, which its track is smoothed by, shape (m, orders).

    As many as samples allow: what an order too few leaves out is the same in every stroke, and passes for an effect.
    """
    return chebyshev_waves(time, min(7, n // 3))


def chebyshev_waves(time: Array, orders: int) -> Array:
    """Chebyshev polynomials of 0 … `orders` over some times (m,), shape (m, orders + 1)."""
    return chebyshev.chebvander(2.0 * (time - time[0]) / float(np.ptp(time)) - 1.0, orders)


def chebyshev_slopes(waves: Array, curve: Array, width: float) -> Array:
    """Slopes (m,) of a curve, `waves` (m, k) of `chebyshev_waves` times its coefficients (k,), over times that span a
    `width` in s."""
    return waves[:, :-1] @ chebyshev.chebder(curve) * 2.0 / width


def _local_slopes(time: Array, x: Array, noise: float) -> Array:
    """dx/dt from a line through the neighbours of each sample, at the ends from a parabola: over as few as keep the
    noise below SLOPE_NOISE of the stroke's speed, because a drive may speed up and brake within a few samples."""
    n, step = len(x), float(np.ptp(time)) / (len(x) - 1)
    pace = float(np.ptp(x)) / float(np.ptp(time))
    half = 1
    while half < min(6, n // 4) and noise > SLOPE_NOISE * pace * step * np.sqrt(half * (half + 1) * (2 * half + 1) / 3):
        half += 1
    index = np.arange(n)
    m, st, sx, stt, stx = (np.zeros(n) for _ in range(5))
    for offset in range(-half, half + 1):
        near = np.clip(index + offset, 0, n - 1)
        inside = near == index + offset
        dt, dx = inside * (time[near] - time), inside * (x[near] - x)
        for total, part in ((m, inside), (st, dt), (sx, dx), (stt, dt * dt), (stx, dt * dx)):
            total += part
    slope = (stx - st * sx / m) / np.maximum(stt - st**2 / m, 1e-15)
    span = 2 * half + 1
    if n > span:
        for ends, near in ((index[:half], index[:span]), (index[-half:], index[-span:])):
            at = time[near] - time[near[half]]
            if np.ptp(at) > 0.0:
                scaled = at / np.ptp(at)
                bent, straight, _ = np.linalg.lstsq(np.vander(scaled, 3), x[near] - x[near[half]], rcond=None)[0]
                slope[ends] = (2.0 * bent * (time[ends] - time[near[half]]) / np.ptp(at) + straight) / np.ptp(at)
    return slope


def smooth_holds(position: Array, time: Array, x: Array, rest: Array, noise: float) -> None:
    """Replace the position (n,) in each hold by its mean, or where holds settle by a curve, if that leaves no more than
    the noise, but for samples out of the noise and the hold's own scatter, in which a drive still brakes or speeds up.
    """
    holds = [hold for hold in np.split(rest, np.flatnonzero(np.diff(rest) > 1) + 1) if len(hold) >= 4]
    settle = _settle(time, x, holds)
    for hold in holds:
        basis = settling_basis(time[hold]) if settle and len(hold) >= SETTLING else None
        off = x[hold] - (quantile(x[hold], 0.5) if basis is None else along(basis, x[hold]))
        if np.std(off) < 2.0 * noise:
            still = np.abs(off) <= 3.0 * max(1.4826 * quantile(np.abs(off), 0.5), noise)
            seen = x[hold[still]]
            position[hold[still]] = seen.mean() if basis is None else along(basis[still], seen)


def _settle(time: Array, x: Array, holds: list[Array]) -> bool:
    """Whether curves describe holds better than their means do, by an F test over all of them."""
    level, curve, more, rest = 0.0, 0.0, 0, 0
    for hold in holds:
        if len(hold) >= SETTLING:
            basis = settling_basis(time[hold])
            more, rest = more + basis.shape[1] - 1, rest + len(hold) - basis.shape[1]
            level += float(np.sum((x[hold] - x[hold].mean()) ** 2))
            curve += float(np.sum((x[hold] - along(basis, x[hold])) ** 2))
    return level > curve > 0.0 and _beyond_chance(level, curve, more, rest)


def moves_on(level: float, line: float, lines: int, free: int) -> bool:
    """Whether lines in what seem to be rests miss less than levels do, in squares, by more than chance; `free` samples
    are left by the lines."""
    return free > lines and level > line > 0.0 and _beyond_chance(level, line, lines, free)


def _beyond_chance(before: float, after: float, more: int, rest: int, chance: float = CHANCE) -> bool:
    """Whether squares fall by more than a chance would have it, by an F test: with so many parameters `more`, where
    `rest` are left."""
    from scipy.special import fdtrc  # slow to import, and seldom needed

    return float(fdtrc(more, rest, (before - after) / more * rest / after)) < chance


def settling_basis(time: Array) -> Array:
    """A parabola in the root of the time (m,) since a hold began, (m, 3): a regulator's pressure settles like that."""
    return chebyshev.chebvander(2.0 * np.sqrt((time - time[0]) / max(float(np.ptp(time)), 1e-9)) - 1.0, 2)


def along(basis: Array, x: Array) -> Array:
    """What a basis (n, k) follows of values x (n,), shape (n,)."""
    return basis @ np.linalg.lstsq(basis, x, rcond=None)[0]


def calmed(values: Array, segment: Array, time: Array | None = None, run: Array | None = None) -> Array:
    """What is held (n,), with each segment's mean where its deviations are white, so that they are the sensor's noise.

    Only white deviations are the sensor's: what a regulator does slowly is the muscle's own pressure. Where the `run`
    (n,) of a stroke or hold shows that it does, each run has the smooth course over `time` (n,) that describes it to
    the noise, or what was measured.
    """
    calm, segments = values.copy(), list(_runs(segment))
    for rows in segments:
        held = values[rows]
        off = held - held.mean()
        square = float(np.mean(off**2))
        if len(off) <= 20 or not square > 0.0:
            continue
        if time is not None and run is not None and _wavers(off, time[rows], run[rows], CHANCE / len(segments)):
            noise = position_noise(held, time[rows])
            for part in _runs(run[rows]):
                calm[rows][part] = smooth_stroke(time[rows][part], held[part], noise)[0]
        elif np.mean(off[1:] * off[:-1]) < 4.0 / np.sqrt(len(off)) * square:
            calm[rows] = held.mean()
    return calm


def _wavers(off: Array, time: Array, run: Array, chance: float) -> bool:
    """Whether a line in each run describes deviations (n,) better than none, beyond a chance."""
    left, more, rest = 0.0, 0, 0
    for part in _runs(run):
        t, y = time[part] - time[part].mean(), off[part]
        slope = float(t @ y) / max(float(t @ t), 1e-300)
        left += float(np.sum((y - y.mean() - slope * t) ** 2))
        more, rest = more + min(2, len(y)), rest + max(len(y) - 2, 0)
    return rest > more and left > 0.0 and _beyond_chance(float(off @ off), left, more, rest, chance)


def _runs(segment: Array) -> Iterator[slice]:
    """The samples of each segment."""
    edges = [0, *(np.flatnonzero(np.diff(segment)) + 1).tolist(), len(segment)]
    return (slice(begin, end) for begin, end in pairwise(edges))
