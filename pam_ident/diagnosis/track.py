"""What an unsure track of what is driven, the position or the pressure of a locked muscle, does to the force.

The track of a stroke is a smooth curve through its samples, x̂ = B Bᵀ x with B an orthonormal basis, so its samples
share their errors: σ² B Bᵀ is their covariance. Where the force is steep they share newtons, and what repeats in one
stroke and not in the next would pass for an effect.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from ..core import Inputs, Specimen
from ..records import Record
from ..records.motion import FEWEST_HELD
from ..records.roughness import noise_around
from ..records.smoothing import settling_basis, smooth_basis
from .dictionary import Slopes

Array = np.ndarray
Block = tuple[Array, Array]
NEGLIGIBLE = 0.05
"""Share of the noise's variance below which it does not matter how unsure the track is."""
FAINT = 1e-6
"""Variance of what rows have in common, over that of the noise, below which it is none."""
SLOW = 0.8
"""Share of its speed at which a stroke goes over into a turn that may be anywhere in a short rest."""
ON_LEVEL = 4.0
"""Standard deviations of the position sensor within which a sample lies on a hold's level."""


@dataclass(frozen=True)
class SharedNoise:
    """Noise that rows of a block share, over white noise of unit variance: rows (m,), and columns (m, k) whose product
    with their transpose is the block's covariance. `alone` (n,) is the standard deviation of what a row has by itself.
    Blocks have no row in common, and none that has any alone."""

    blocks: tuple[Block, ...]
    alone: Array

    @cached_property
    def _directions(self) -> tuple[sparse.csr_matrix, Array]:
        """An orthonormal basis (n, k) of all blocks, and the variance in each direction, (k,)."""
        single = np.flatnonzero(self.alone)
        count = len(single)
        rows, columns, values, variances = [single], [np.arange(count)], [np.ones(count)], [self.alone[single] ** 2]
        for where, block in self.blocks:
            size, turned = np.linalg.eigh(block.T @ block)
            seen = size > FAINT
            basis = block @ (turned[:, seen] / np.sqrt(size[seen]))
            rows.append(np.repeat(where, basis.shape[1]))
            columns.append(np.tile(np.arange(count, count + basis.shape[1]), len(where)))
            values.append(basis.ravel())
            variances.append(size[seen])
            count += basis.shape[1]
        parts = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
        return sparse.csr_matrix(parts, shape=(len(self.alone), count)), np.concatenate(variances)

    def through(self, white: Callable[[Array], Array]) -> "SharedNoise":
        """What rows have in common once columns (n, k) went through a filter, `white`.

        That carries what one block has into the next; there it is counted, but as if it were the next one's own.
        """
        wide = max((block.shape[1] for _, block in self.blocks), default=0)
        columns = np.zeros((len(self.alone), 2 * wide))
        for k, (rows, block) in enumerate(sorted(self.blocks, key=lambda one: one[0][0])):
            columns[rows, k % 2 * wide : k % 2 * wide + block.shape[1]] = block
        passed = white(columns)
        return SharedNoise(tuple((rows, passed[rows]) for rows, _ in self.blocks), np.zeros(len(self.alone)))

    @property
    def variance(self) -> Array:
        """What it adds to the variance of each row, (n,)."""
        found = self.alone**2
        for rows, block in self.blocks:
            found[rows] += np.sum(block**2, axis=1)
        return found

    def _scaled(self, values: Array, by: Array) -> Array:
        basis, _ = self._directions
        along = basis.T @ values
        found = values + basis @ ((by[:, None] if values.ndim == 2 else by) * along)
        return found.astype(values.dtype, copy=False)

    def even(self, values: Array) -> Array:
        """Values (n,) or columns (n, k) with the shared noise scaled down to the white noise's size."""
        return self._scaled(values, 1.0 / np.sqrt(1.0 + self._directions[1]) - 1.0)

    def back(self, values: Array) -> Array:
        """The inverse of `even`."""
        return self._scaled(values, np.sqrt(1.0 + self._directions[1]) - 1.0)

    @property
    def volume(self) -> float:
        """What `even` takes from twice the logarithm of a likelihood."""
        return float(np.sum(np.log1p(self._directions[1])))

    def take(self, rows: Array) -> "SharedNoise":
        """That of some rows, by index (m,) in order."""
        place = np.full(len(self.alone), -1)
        place[rows] = np.arange(len(rows))
        kept = [(place[where], block, place[where] >= 0) for where, block in self.blocks]
        blocks = tuple((at[seen], block[seen]) for at, block, seen in kept if seen.any())
        return SharedNoise(blocks, self.alone[rows])


@dataclass(frozen=True)
class TrackError:
    """How far the track of a record's steady inputs may be off: the position in mm, the pressure in MPa of a `locked`
    muscle.

    `blocks` are rows (m,) that were smoothed together, with the columns (m, k) of their common errors; `alone` (n,) is
    the standard deviation of each other row, `by_itself` that of every row with what the steady track is rough by, and
    `sensor_mm` that of a reading of a position that is driven.
    """

    blocks: tuple[Block, ...]
    alone: Array
    by_itself: Array
    locked: bool
    sensor_mm: float
    unread: Array

    @classmethod
    def of(cls, record: Record, whole: Record) -> "TrackError | None":
        """That of a record in time, thinned from the `whole`, with its steady inputs; None without motion."""
        raw, locked = record.inputs, record.inputs.locked
        if raw.time is None or raw.moving is None:
            return None
        track, calm = ((one.pressure if locked else one.displacement_mm) for one in (raw, record.steady))
        run = record.stroke * 2 + raw.moving
        off = noise_around(track, raw.time, run)
        smoothed = calm != track
        assert whole.inputs.moving is not None
        counts = [np.bincount(whole.stroke, weights=mask) for mask in (~whole.inputs.moving, whole.inputs.moving)]
        blocks = []
        for group in _runs(run):
            group = group[smoothed[group]]
            if len(group) > 1:
                moving = bool(raw.moving[group[0]])
                m = int(max(counts[moving][record.stroke[group[0]]], len(group)))
                if moving:
                    basis = smooth_basis(raw.time[group], m)
                elif np.ptp(calm[group]) > 0.0:
                    basis = settling_basis(raw.time[group])
                else:
                    basis = np.ones((len(group), 1))
                basis = np.linalg.qr(basis)[0] * np.sqrt(len(group) / m)
                blocks.append((group, off[group, None] * basis))
        sensor_mm = 0.0 if locked else float(np.sqrt(np.mean(off**2)))
        alone = np.where(smoothed, 0.0, off)
        by_itself = np.maximum(alone, noise_around(calm, raw.time, run))
        unread = _unread(record.steady, None if locked else ON_LEVEL * sensor_mm)
        return cls(tuple(blocks), alone, by_itself, locked, sensor_mm, unread)

    def slope(self, around: Slopes, specimen: Specimen) -> Array:
        """That of the force over the track, (n,) in N/mm or N/MPa, from a model's."""
        return around.pressure if self.locked else around.contraction / specimen.initial_length_mm

    def matters(self, slope: Array, size: float) -> bool:
        """Whether what it makes of a force with a slope (n,) over the track is more than NEGLIGIBLE beside white noise
        of a `size` in N."""
        square = float(np.sum((slope * self.alone) ** 2))
        square += sum(float(np.sum((slope[rows, None] * block) ** 2)) for rows, block in self.blocks)
        return square > NEGLIGIBLE * len(slope) * size**2

    def in_force(self, slope: Array, size: float, every: bool = False) -> SharedNoise | None:
        """In a force with a slope (n,) over the track and white noise of a `size` in N; None where rows share nothing.

        Rows that were not smoothed are counted where `every` row is asked for.
        """
        scale = slope / max(size, 1e-300)
        blocks = tuple((rows, scale[rows, None] * block) for rows, block in self.blocks)
        alone = scale * self.alone if every else np.zeros(len(slope))
        return SharedNoise(blocks, alone) if blocks or alone.any() else None


def comes_to_rest(inputs: Inputs) -> Array:
    """Samples with which a rest begins behind a stroke, (n,)."""
    moving = inputs.moving
    return np.zeros(len(inputs), bool) if moving is None else np.diff(moving, prepend=False) & ~moving


def _unread(inputs: Inputs, near_mm: float | None) -> Array:
    """Samples in which the muscle may rest or slide either way, (n,): at the point of a turn without a hold, which
    belongs to both strokes, or to neither, and in a short rest of a slow turn, which may be anywhere in it; in the
    rest that a segment begins with, because nobody saw how it was come to; the first of any rest, in which a drive may
    still come back; the last one within `near_mm` of a hold's level, where a stroke may have begun; and that of a
    stroke there, where its last step falls short of the one before: it has ended since."""
    moving, segment, x = inputs.moving, inputs.segment, inputs.displacement_mm
    assert moving is not None and segment is not None and inputs.time is not None
    found = np.zeros(len(inputs), bool)
    turn = np.flatnonzero((np.diff(inputs.direction) != 0.0) & moving[1:] & moving[:-1])
    found[turn + (np.diff(x)[turn] * inputs.direction[turn] > 0.0)] = True
    begins = np.diff(segment, prepend=segment[0] - 1) != 0
    run = np.cumsum(begins | np.diff(moving, prepend=moving[0]))
    found |= np.isin(run, run[begins & ~moving]) & np.isin(segment, segment[moving])
    turned = np.flatnonzero(moving[1:] & ~moving[:-1] & (np.diff(inputs.direction) != 0.0))
    size = np.bincount(run)[run[turned]]
    if inputs.velocity is not None and inputs.stroke_speed is not None:
        slow = np.abs(inputs.velocity) < SLOW * inputs.stroke_speed  # a drive that stops at once has turned at the end
        softly = (size < FEWEST_HELD) & slow[turned + 1] & slow[np.maximum(turned - size, 0)]
        found |= np.isin(run, run[turned[softly]])
    found |= comes_to_rest(inputs)
    if near_mm is not None:
        step = np.abs(np.diff(x))
        last = np.flatnonzero(moving[1:] & ~moving[:-1])
        found[last + (step[last] <= near_mm)] = True
        pace = np.diff(inputs.time)
        short = step[:-1] * pace[1:] - step[1:] * pace[:-1] > near_mm * pace[:-1]
        found[2:-1] |= short[:-1] & moving[2:-1] & ~moving[3:] & (step[2:] <= near_mm)
    return found


def _runs(numbers: Array) -> Sequence[Array]:
    """Indices of neighbours with the same number."""
    return np.split(np.arange(len(numbers)), np.flatnonzero(np.diff(numbers)) + 1)
