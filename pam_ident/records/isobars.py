"""Isobars: the pressures that a test holds, though a regulator ripples, droops, and takes its time between them."""

import numpy as np

from ..core import Array
from .kind import HELD_LENGTH, large_turns
from .roughness import position_noise

GAP = 0.005
"""MPa between the clusters of pressures that are isobars."""
SHORT_LIST = 200
"""Most pressures that may each be an isobar's own value; more are one sensor's noise about fewer."""
CROWD = 3
"""Most of them within 5 kPa, on average; more are the steps of a coarse sensor."""
HELD, FAR = 50, 5.0
"""Samples of a pressure that is held at least, and its standard deviations within which a sample is its own."""
DROOP = 0.02
"""MPa between neighbouring pressures of which a regulator may droop from one to the other while the muscle moves."""
FEW = 0.1
"""Share of the rows below which they were only passed on the way."""
REST = 0.25
"""Share of a driven pressure's range within which it rests: it still falls as the muscle begins to be moved."""
NEAR, NOISE, APART = 9, 8.0, 5.0
"""Samples that a muscle is locked at one length at least, standard deviations of a reading within which they are, and
by which the medians of such samples differ between lengths."""
AT_LEAST, STAYS = 2, 0.005
"""Samples to both sides, and share of all, for which a pressure stays within GAP where it is held."""


def levels_of(pressure: Array, listed: bool = True, gap: float = GAP) -> Array:
    """Nominal pressure of each sample, (n,): its own value in a short list, unless none is `listed`, else the median of
    its cluster, clusters parted by a `gap`."""
    values, inverse, counts = np.unique(np.round(pressure, 6), return_inverse=True, return_counts=True)
    return nominal(values, counts, listed, gap)[inverse]


def nominal(values: Array, counts: Array, listed: bool = True, gap: float = GAP) -> Array:
    """Nominal pressure in MPa of each of the pressures `values` (m,), ascending, that are read `counts` (m,) times."""
    edges = (np.flatnonzero(np.diff(values) > gap) + 1).tolist()
    ends = zip([0, *edges], edges, [*edges[1:], len(values)], strict=False)
    edges = [k for a, k, b in ends if not _stray(values, counts, a, k, b)]
    if listed and len(values) <= min(max(2, counts.sum() // 8), SHORT_LIST, CROWD * (len(edges) + 1)):
        return values
    parts = zip(np.split(values, edges), np.split(counts, edges), strict=True)
    return np.concatenate([np.full(len(v), round(_median(v, c), 4)) for v, c in parts])


def _stray(values: Array, counts: Array, begin: int, edge: int, end: int) -> bool:
    """Whether of two clusters, parted at an `edge`, one is a lone sample in the noise of the other, which is held."""
    few, many = sorted((slice(begin, edge), slice(edge, end)), key=lambda part: counts[part].sum())
    if counts[few].sum() > 1 or counts[many].sum() < HELD:
        return False
    mean = np.average(values[many], weights=counts[many])
    spread = np.sqrt(np.average((values[many] - mean) ** 2, weights=counts[many]))
    return bool(np.abs(values[few] - mean).max() < FAR * spread)


def _median(values: Array, counts: Array) -> float:
    """Median of values, ascending, that occur `counts` times."""
    last = np.cumsum(counts)
    middle = np.searchsorted(last, [(last[-1] - 1) // 2, last[-1] // 2], side="right")
    return float(np.mean(values[middle]))


def between(pressure: Array, contraction: Array) -> Array:
    """Mask (n,) of the samples in which the pressure in MPa goes from one isobar to another while the muscle rests."""
    return _between(pressure, GAP, contraction, HELD_LENGTH)


def between_lengths(pressure: Array, contraction: Array) -> Array:
    """Mask (n,) of the samples in which a muscle is moved from one length to another while the pressure rests."""
    gaps = HELD_LENGTH, NOISE * position_noise(contraction)
    wide, near = (_between(contraction, gap, pressure, REST * float(np.ptp(pressure))) for gap in gaps)
    return wide | near


def lengths_of(contraction: Array, pressure: Array, way: Array) -> Array:
    """The contraction ratio at which a muscle is locked at each sample, (n,), those on the `way` (n,) to a length given
    to that. A single reading between two lengths, or a step of a coarse gauge, is none; nor is where the fixture gives
    way to the pressure: at each of two lengths that lie close it stays a while, and the pressure is driven as far as at
    both."""
    from scipy.ndimage import median_filter  # slow to import

    near, apart = np.asarray(median_filter(contraction, NEAR, mode="nearest")), APART * position_noise(contraction)
    coarse, fine = given_to_next(contraction, way, False, max(GAP, apart)), given_to_next(near, way, False, apart)

    def driven(rows: Array) -> float:
        return float(np.ptp(pressure[rows]))

    for length in np.unique(coarse):
        joined = coarse == length
        parts = [joined & (fine == one) for one in np.unique(fine[joined])]
        stays = HELD * np.count_nonzero(np.diff(fine[joined])) <= np.count_nonzero(joined)
        if len(parts) > 1 and stays and min(driven(part) for part in parts) > 0.5 * driven(joined):
            coarse[joined] = fine[joined]
    return coarse


def _between(held: Array, gap: float, driven: Array, still: float) -> Array:
    """Mask (n,) of the samples in which what is `held` within a `gap` goes from one level to another while what is
    `driven` stays within `still`.

    None where these are more than FEW: then it is driven, too. An excursion that ends where it began is none.
    """
    from scipy.ndimage import maximum_filter1d, minimum_filter1d  # slow to import

    n = len(held)
    size = 2 * max(AT_LEAST, int(STAYS * n)) + 1
    reach = np.asarray(maximum_filter1d(held, size)) - np.asarray(minimum_filter1d(held, size))
    stays: Array = np.asarray(maximum_filter1d(reach <= gap, size), bool)
    none = np.zeros(n, bool)
    if stays.all() or not stays.any():
        return none
    levels = np.unique(levels_of(held[stays], listed=False, gap=gap))
    nearest = np.abs(held[:, None] - levels).argmin(axis=1)
    away = np.flatnonzero(~stays)
    ways = []
    for rows in np.split(away, np.flatnonzero(np.diff(away) > 1) + 1):
        far = np.flatnonzero(np.abs(held[rows] - levels[nearest[rows]]) > gap)
        way = rows[far[0] : far[-1] + 1] if len(far) else far
        if len(way) and (way[0] == 0 or nearest[way[0] - 1] != nearest[min(way[-1] + 1, n - 1)]):
            ways.append(way)
    found = none.copy()
    found[np.concatenate([np.empty(0, int), *ways])] = True
    moved = [float(np.ptp(driven[w])) for w in ways]
    return found if 0 < found.sum() <= FEW * n and np.median(moved) < still else none


def as_driven(level: Array, pressure: Array, contraction: Array, way: Array) -> Array:
    """Nominal pressures (n,) in MPa, those on their `way` (n,) between isobars given to the next, and those joined
    between which a regulator droops; `level` itself where there is neither."""
    return _without_droop(given_to_next(pressure, way) if way.any() else level, contraction)


def given_to_next(values: Array, way: Array, listed: bool = True, gap: float = GAP) -> Array:
    """Levels of values (n,), as `levels_of` finds them in those that are on no `way` (n,), the others given to the
    next."""
    held = np.flatnonzero(~way)
    after = np.searchsorted(held, np.arange(len(way)))
    return levels_of(values[held], listed, gap)[np.minimum(after, len(held) - 1)]


def _without_droop(level: Array, contraction: Array) -> Array:
    """Isobars (n,) in MPa, those joined between which a regulator droops: close ones of which one at most is driven
    both ways, and which are not driven alike."""
    values, which, counts = np.unique(level, return_inverse=True, return_counts=True)
    held = np.flatnonzero(counts > FEW * counts.max())  # the others were passed on the way to them
    if not np.any(np.diff(values[held]) < DROOP):
        return level
    ends = large_turns(contraction)
    out = np.repeat(np.diff(contraction[ends]) > 0.0, np.diff(ends))
    one = np.bincount(which[:-1], out, len(values)) / counts
    both = np.minimum(one, 1.0 - one) > FEW
    for group in np.split(held, np.flatnonzero(np.diff(values[held]) >= DROOP) + 1):
        if both[group].sum() <= 1 and np.ptp(2 * both[group] + (one[group] > 0.5)) > 0:
            values[group] = np.round(np.median(level[np.isin(which, group)]), 4)
    return values[which]
