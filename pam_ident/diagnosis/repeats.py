"""What comes back with every cycle is no noise, whatever its colour."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..fitting.floor import nearest, repeats
from ..records import Record

Array = np.ndarray
Group = list[tuple[Array, Array]]
SHARE = 0.2
"""Share of a residual's variance that must come back before it counts as no noise: less may be the position's."""
APART, PLACES = 0.1, 5
"""Share of a record that lies between samples which slow noise does not make alike, and places among which such are
looked for."""
CERTAIN = 5.0
"""Standard errors by which it must differ from none."""


def without_repeats(record: Record, residual: Array, rows: Array) -> Array:
    """A residual (n,) in N as it is if nothing in it comes back; else that of repeated strokes less what they share.

    Strokes, and the holds behind them, repeat each other at one pressure, speed and direction. Of each cycle a line in
    time is taken off first, because noise slower than a cycle comes back, too; what its slopes at one pressure share
    does as well. So does what follows the force alone, an error of the load cell's. `rows` (mask, (n,)) are looked at.
    A stroke less its neighbour, over the root of two, has noise of the same size and colour as a stroke by itself.
    """
    if record.inputs.time is None:
        return residual
    trend, changing = _trends(record, residual, rows)
    flat = residual - trend
    groups = [*repeats(record, rows), *repeats(record, rows, at_rest=True)]
    coarse = rounding(step_of(record))
    common = in_common(groups, flat)
    again = common.shared - common.n * coarse if common.certain else 0.0
    by_force, one, other = _by_force(record, residual, flat, rows, coarse)
    own = residual.copy()
    if by_force * common.size > max(again, 0.0):
        own[one] = changing[one] + (flat[one] - flat[other]) / np.sqrt(2.0)
        return own
    if again <= SHARE * common.size:
        return residual
    for group in groups:
        for (one, x), (other, y) in zip(group, [*group[1:], group[0]], strict=True):
            own[one] = changing[one] + (flat[one] - flat[other[nearest(x, y)]]) / np.sqrt(2.0)
    return own


@dataclass(frozen=True)
class Common:
    """What neighbouring repeats share: the sum of their products `shared` and of their squares `size` over n samples,
    and whether noise with their memory would not share so much, nor differ so much by turns: then it is `certain`."""

    shared: float
    size: float
    n: int
    certain: bool


def in_common(groups: Iterable[Group], values: Array) -> Common:
    """Values (n,) of groups of repeats, as `fitting.floor.repeats` gives them, beside those of the next repeat."""
    shared, size, chance, n = 0.0, 0.0, 0.0, 0
    for group in groups:
        for (one, x), (other, y) in pairwise(group):
            here, there = values[one], values[other[nearest(x, y)]]
            shared += float(here @ there)
            size += float(here @ here)
            chance += float(here @ here) * float(there @ there) / len(one)
            n += len(one)
    return Common(shared, size, n, abs(shared) > CERTAIN * np.sqrt(chance * memory_of(values)))


def memory_of(noise: Array) -> float:
    """Samples of noise (n,) that count as one because they are correlated, at least 1: the sum of the first
    correlations, twice."""
    power = np.abs(np.fft.rfft(noise, 2 * len(noise))) ** 2
    correlation = np.fft.irfft(power)[: len(noise)] / max(float(noise @ noise), 1e-300)
    below = np.flatnonzero(correlation < 0.05)
    return 1.0 + 2.0 * float(np.sum(correlation[1 : below[0]])) if len(below) and below[0] > 1 else 1.0


def comes_back(record: Record, residual: Array, rows: Array) -> float:
    """Share of the squares of a residual (n,) in N, within strokes, that repeats share, or by which they differ by
    turns; 0 where it may be chance.

    Rounding of a coarse gauge comes back, too, and is taken off, as is a line in time of each cycle: slow noise is
    alike in neighbouring strokes, but never opposite. What strokes share wherever the force is the same comes back as
    well, where it is more than SHARE. `rows` (mask, (n,)) are looked at.
    """
    if record.inputs.time is None:
        return 0.0
    groups, flat = repeats(record, rows), residual - _trends(record, residual, rows)[0]
    coarse = rounding(step_of(record))
    by_force, *_ = _by_force(record, residual, flat, rows, coarse)
    alike = in_common(groups, flat)
    opposite = in_common(groups, residual)
    found = [(alike, alike.shared - alike.n * coarse), (opposite, -opposite.shared)]
    shares = [min(max(shared / max(one.size, 1e-300), 0.0), 1.0) for one, shared in found if one.certain]
    return max(by_force, *shares, 0.0)


def _by_force(record: Record, residual: Array, flat: Array, rows: Array, coarse: float) -> tuple[float, Array, Array]:
    """Share of the squares of a residual (n,) in N without its trend, `flat` (n,), that follows the force, less
    rounding of variance `coarse`; 0 up to SHARE, and where it may be chance. And two arrays of samples, of `rows`
    (mask, (n,)), by which it is known: neighbours by the force without its noise, as a model says it that leaves the
    residual, but APART in time.

    Nothing that is driven holds them together, so only what follows the force itself do they share.
    """
    time = record.inputs.time
    assert time is not None
    seen = np.random.default_rng(0).permutation(np.flatnonzero(rows))  # of equal forces none is beside the next in time
    order = seen[np.argsort((record.force - residual)[seen], kind="stable")]
    beside = np.full(len(rows), -1)
    for k in range(1, 1 + PLACES):
        one, other = order[:-k], order[k:]
        apart = (np.abs(time[one] - time[other]) > APART * (time[-1] - time[0])) & (beside[one] < 0)
        beside[one[apart]] = other[apart]
    here = np.flatnonzero(beside >= 0)
    there = beside[here]
    size = 0.5 * float(flat[here] @ flat[here] + flat[there] @ flat[there])
    shared = float(flat[here] @ flat[there]) - coarse * len(here)
    likely = shared > SHARE * size > 0.0  # else its memory need not be known
    certain = likely and shared > CERTAIN * size * math.sqrt(memory_of(flat) / len(here))
    return shared / size if certain else 0.0, here, there


def step_of(record: Record) -> float:
    """The step in N in which the force was read."""
    steps = np.diff(np.unique(record.as_measured.force))
    return float(np.min(steps)) if len(steps) else 0.0


def rounding(step: float) -> float:
    """Variance in N² of rounding to steps in N, which comes back where the noise is smaller than a step."""
    return step**2 / 12.0


def _trends(record: Record, residual: Array, rows: Array) -> tuple[Array, Array]:
    """A line in time through the residual's `rows` of each cycle, and that with the slope that is its own, (n,) each.

    Its own is what it has over the others at its pressure, per cycle, of the size that a slope by itself would have.
    """
    time = record.inputs.time
    assert time is not None
    trend, changing = np.zeros(len(residual)), np.zeros(len(residual))
    rises: dict[float, list[tuple[Array, float, float]]] = {}
    for block in np.unique(record.block):
        cycle = np.flatnonzero(record.block == block)
        seen = rows[cycle]
        if np.count_nonzero(seen) >= 4:
            known = time[cycle[seen]]
            at = (time[cycle] - known.mean()) / max(float(np.ptp(known)), 1e-9)
            rise, mean = np.linalg.lstsq(np.vander(at[seen], 2), residual[cycle[seen]], rcond=None)[0]
            trend[cycle], changing[cycle] = mean + rise * at, mean
            rises.setdefault(float(record.level[cycle[0]]), []).append((cycle, at, rise))
    for lines in rises.values():
        shared = np.mean([rise for *_, rise in lines])
        size = np.sqrt(len(lines) / max(len(lines) - 1, 1))
        for cycle, at, rise in lines:
            changing[cycle] += size * (rise - shared) * at
    return trend, changing
