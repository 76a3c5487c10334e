"""Columns of numbers in files, read and written a stretch at a time."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..core import Array, UsageError

STRETCH = 1 << 18
"""Rows of a column that are read at a time."""
BITS = 16
"""Bits of a number by which an order statistic is narrowed down at a reading: as many counts as a cache holds."""


@dataclass(frozen=True)
class Columns:
    """Columns of one length in `folder`, a file each: 8 bytes a number, 4 for integers, 1 for signs and truths."""

    folder: Path

    def append(self, name: str, values: Array) -> None:
        """Lengthen a column by `values` (m,). Raises UsageError where the disk is full."""
        try:
            with (self.folder / name).open("ab") as file:
                file.write(np.ascontiguousarray(values).data)
        except OSError as error:
            raise UsageError(
                f"{self.folder}: {error.strerror or error}; a record that is read in chunks keeps its numbers there "
                "meanwhile, about twice as many bytes as its text has: set TMPDIR to a folder with that much room"
            ) from None

    def shift(self, name: str, begin: int, end: int, by: float) -> None:
        """Add a number to the rows begin … end of a column."""
        with (self.folder / name).open("r+b") as file:
            for first in range(begin, end, STRETCH):
                moved = self.read(name, first, min(first + STRETCH, end)) + by
                file.seek(8 * first)
                file.write(moved.data)

    def drop(self, name: str) -> None:
        """Forget a column."""
        (self.folder / name).unlink(missing_ok=True)

    def has(self, name: str) -> bool:
        """Whether there is such a column."""
        return (self.folder / name).exists()

    def read(self, name: str, begin: int, end: int, kind: type = np.float64) -> Array:
        """Rows begin … end of a column, shape (end − begin,)."""
        size = np.dtype(kind).itemsize
        return np.fromfile(self.folder / name, kind, end - begin, offset=begin * size)

    def differences(self, name: str, begin: int, end: int, order: int) -> Iterator[Array]:
        """Magnitudes of differences of rows begin … end, a stretch (m,) at a time; those of order 0 are the numbers."""
        for first in range(begin, end - order, STRETCH):
            yield np.abs(np.diff(self.read(name, first, min(first + STRETCH + order, end)), order))

    def quantile(self, name: str, begin: int, end: int, order: int, share: float) -> float:
        """Quantile of those differences, between neighbours by a straight line, 0 where there are none."""
        last = end - begin - order - 1
        if last < 0:
            return 0.0
        rank = int(share * last)
        low = high = self._ranked(name, begin, end, order, rank)
        if share * last > rank:
            up_to, above = 0, np.inf
            for values in self.differences(name, begin, end, order):
                up_to += int(np.count_nonzero(values <= low))
                above = min(above, float(values[values > low].min(initial=np.inf)))
            high = low if up_to > rank + 1 else above
        return low + (high - low) * (share * last - rank)

    def _ranked(self, name: str, begin: int, end: int, order: int, rank: int) -> float:
        """The difference that `rank` others come before, exactly: numbers above 0 are in the order of their bits."""
        known, shift = 0, 64
        while shift > 0:
            width = min(BITS, shift)
            counts = np.zeros(1 << width, np.int64)
            for values in self.differences(name, begin, end, order):
                bits = values.view(np.uint64)
                if shift < 64:
                    bits = bits[bits >> np.uint64(shift) == known]
                digits = (bits >> np.uint64(shift - width)) & np.uint64((1 << width) - 1)
                counts += np.bincount(digits.astype(np.int64), minlength=1 << width)
            total = np.cumsum(counts)
            digit = int(np.searchsorted(total, rank, side="right"))
            rank -= int(total[digit - 1]) if digit else 0
            known, shift = (known << width) | digit, shift - width
        return float(np.array(known, np.uint64).view(np.float64))
