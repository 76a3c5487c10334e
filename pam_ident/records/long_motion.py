"""The motion of a record on disk, followed piece by piece."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from . import turning
from .columns_on_disk import STRETCH, Columns
from .motion import NORMAL_MEDIAN, Motion, move_piece, reversal, roughness
from .record import long_pause, turns

Array = np.ndarray
KINDS = {"branch": np.int8, "moving": np.bool_, "segment": np.int32, "stroke": np.int32, "turn": np.int32}
"""How columns are kept that are no floating-point numbers."""
Level = Callable[[int, int], Array]
"""Nominal pressures of some rows, begin … end."""


@dataclass
class Follower:
    """Finds strokes, holds, cycles, segments and turns of `n` rows as `build_record` does, and keeps them as columns.

    `span` is the range of the motion in mm; `given` columns stand already. Counts go on from piece to piece.
    """

    on_disk: Columns
    n: int
    length_mm: float
    span: float
    level: Level
    given: tuple[str, ...]
    count: int = 0
    turn: int = 0
    segment: int = -1
    heading: float = 0.0
    reversals: int = 0
    moved: bool = False

    def run(self) -> None:
        """Follow the whole record."""
        noise = self._noise()
        for fresh, time, x in self._pieces(noise):
            self._follow(fresh, time, x, noise)

    def _noise(self) -> float:
        """`position_noise` of the whole record in mm."""
        count = self._roughness(timed=True) or self._roughness(timed=False)
        middle = self.on_disk.quantile("roughness", 0, count, 0, 0.5)
        self.on_disk.drop("roughness")
        return middle / NORMAL_MEDIAN

    def _roughness(self, timed: bool) -> int:
        """Keep the roughness of the track, by the clock or as of even rows, as a column; how many numbers it has."""
        count = 0
        for begin in range(0, self.n, STRETCH):
            end = min(begin + STRETCH + 4, self.n)
            x = self.on_disk.read("contraction", begin, end) * self.length_mm
            rough = roughness(x, self.on_disk.read("time", begin, end) if timed else None)
            self.on_disk.append("roughness", rough)
            count += len(rough)
        return count

    def _pieces(self, noise: float) -> Iterator[tuple[bool, Array, Array]]:
        """Time and position of each piece, and whether a segment begins with it."""
        pause, threshold = long_pause(self.on_disk.quantile("time", 0, self.n, 1, 0.95)), reversal(noise, self.span)
        most, begin, fresh = turning.PIECE, 0, True
        while begin < self.n:
            end = min(begin + 2 * most, self.n)
            time = self.on_disk.read("time", begin, end)
            x = self.on_disk.read("contraction", begin, end) * self.length_mm
            breaks = np.flatnonzero((np.diff(self.level(begin, end)) != 0.0) | (np.diff(time) > pause)) + 1
            at = 0
            for stop in [*breaks.tolist(), len(x)]:
                while stop - at > most:
                    cut = at + turning.cut_at_turn(x[at : at + most], threshold)
                    yield fresh, time[at:cut], x[at:cut]
                    at, fresh = cut, False
                if stop < len(x) or end == self.n:
                    yield fresh, time[at:stop], x[at:stop]
                    at, fresh = stop, True
            begin += at

    def _follow(self, fresh: bool, time: Array, x: Array, noise: float) -> None:
        n = len(x)
        found = Motion(np.zeros(n), np.zeros(n), np.zeros(n, bool), np.zeros(n, int), np.zeros(n), x.copy())
        self.count = move_piece(found, time, x, noise, self.span, self.count)
        begins = turns(x, found.stroke, np.zeros(n))
        begins[0] |= fresh and self.segment >= 0
        turn = self.turn + np.cumsum(begins)
        if fresh:
            self.segment, self.reversals, self.moved = self.segment + 1, 0, False
        columns = {"velocity": found.velocity, "stroke_speed": found.stroke_speed, "moving": found.moving}
        columns |= {"stroke": found.stroke, "turn": turn, "segment": np.full(n, self.segment)}
        for name, column in (("branch", found.direction), ("cycle", self._cycles(found))):
            if name not in self.given:
                columns[name] = column
        for name, column in columns.items():
            self.on_disk.append(name, column.astype(KINDS.get(name, np.float64)))
        self.turn = int(turn[-1])

    def _cycles(self, found: Motion) -> Array:
        """Each second reversal of a segment begins a cycle, counted from 1 with what is before its first stroke."""
        turned = np.diff(found.direction, prepend=self.heading) != 0.0
        if not self.moved:
            turned[: int(np.argmax(found.moving)) + 1] = False
        self.moved = self.moved or bool(found.moving.any())
        reversals = self.reversals + np.cumsum(turned)
        self.heading, self.reversals = float(found.direction[-1]), int(reversals[-1])
        return reversals // 2 + 1.0
