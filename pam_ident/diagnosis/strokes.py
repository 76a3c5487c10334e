"""A run on the test rig before it is made: strokes, holds and loops, and what a force law would be given in it."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, cycle
from textwrap import wrap

import numpy as np

from ..core import Inputs, Specimen

Array = np.ndarray
GAP_S = 20.0
"""Time between two pressures."""
MOVE_ROWS = 40
ROW_S = 1.5
"""Longest time between two rows of a hold; longer gaps would be taken for the end of a run."""
LEAST_ROWS = 10
ROOM_C = 23.0


@dataclass(frozen=True)
class StrokeLeg:
    """A move from `start` to `end` (mm) at a speed (mm/s), the hold (s) after it and the cycle it belongs to."""

    start: float
    end: float
    speed: float
    hold: float
    cycle: int


@dataclass(frozen=True)
class Strokes:
    """A protocol in rig words: pressures (MPa) in the order of the run, the end of the stroke at each (mm), speeds
    (mm/s), cycles at each speed.

    Strokes begin at `bottom_mm`. `hold_s` are the holds that follow the strokes in turn; `minor_loops_mm` are driven
    from the middle of the stroke; the muscle is warmed by `warming_K` until the middle of the run and cools again.
    """

    pressures_MPa: tuple[float, ...]
    tops_mm: tuple[float, ...]
    speeds_mm_s: tuple[float, ...]
    cycles_per_speed: int = 2
    bottom_mm: float = 0.0
    hold_s: tuple[float, ...] = (2.0,)
    minor_loops_mm: tuple[float, ...] = ()
    warming_K: float = 0.0

    @property
    def seconds(self) -> float:
        """Time on the rig, without what it takes to warm the muscle."""
        moves = sum(abs(leg.end - leg.start) / leg.speed + leg.hold for leg in chain(*self._isobars()))
        return moves + GAP_S * len(self.pressures_MPa)

    def _isobars(self) -> Iterator[list[StrokeLeg]]:
        """The legs of each isobar; a run begins contracted, and holds follow each other through the whole run."""
        holds = cycle(self.hold_s)
        for top in self.tops_mm:
            legs: list[StrokeLeg] = []
            number = 0
            for speed in self.speeds_mm_s:
                for _ in range(self.cycles_per_speed):
                    number += 1
                    legs.append(StrokeLeg(top, self.bottom_mm, speed, next(holds), number))
                    legs.append(StrokeLeg(self.bottom_mm, top, speed, next(holds), number))
                if self.minor_loops_mm:
                    number += 1
                    middle = 0.5 * (self.bottom_mm + top)
                    legs.append(StrokeLeg(top, middle, speed, 0.0, number))
                    for size in self.minor_loops_mm:
                        end = min(middle + size, top)
                        for _ in range(self.cycles_per_speed):
                            number += 1
                            legs += [
                                StrokeLeg(middle, end, speed, 0.0, number),
                                StrokeLeg(end, middle, speed, 0.0, number),
                            ]
                    legs.append(StrokeLeg(middle, top, speed, 0.0, number))
            yield legs

    def inputs(self, specimen: Specimen) -> Inputs:
        """What the run would give a force law at its rows: constant pressures and, in each stroke, one speed."""
        rows: list[Array] = []
        clock = 0.0
        for segment, (pressure, legs) in enumerate(zip(self.pressures_MPa, self._isobars(), strict=True)):
            clock += GAP_S
            for leg in legs:
                way, lasts = np.sign(leg.end - leg.start), abs(leg.end - leg.start) / leg.speed
                share = np.linspace(0.0, 1.0, MOVE_ROWS)
                rest = np.linspace(min(0.1, leg.hold), leg.hold, hold_rows(leg.hold))
                moving = np.r_[np.ones(MOVE_ROWS), np.zeros(len(rest))]
                block = np.ones((9, len(moving)))
                block[0] = clock + np.r_[lasts * share, lasts + rest]
                block[1] = pressure
                block[2] = np.r_[leg.start + (leg.end - leg.start) * share, leg.end + 0.0 * rest]
                block[3], block[4], block[5], block[6] = way, way * leg.speed * moving, leg.speed, moving
                block[7], block[8] = leg.cycle, segment
                rows.append(block)
                clock += lasts + max(leg.hold, 0.05)
        time, pressure, x, way, velocity, speed, moving, number, segment = np.hstack(rows)
        warmth = self.warming_K * np.sin(np.pi * (time - time[0]) / np.ptp(time)) ** 2
        return Inputs(
            pressure=pressure,
            contraction=x / specimen.initial_length_mm,
            specimen=specimen,
            direction=way,
            time=time,
            velocity=velocity,
            stroke_speed=speed,
            moving=moving > 0,
            cycle=number,
            temperature=ROOM_C + warmth,
            segment=segment.astype(int),
        )

    def table(self) -> dict[str, object]:
        """The keys of a protocol file; a stroke also ends at zero force there, which is where `tops_mm` come from."""
        return {
            "pressures_MPa": sorted(self.pressures_MPa),
            "speeds_mm_s": list(self.speeds_mm_s),
            "cycles_per_speed": self.cycles_per_speed,
            "stroke_mm": [self.bottom_mm, max(self.tops_mm)],
            "hold_s": list(self.hold_s),
            "move_rows": MOVE_ROWS,
            "hold_rows": [hold_rows(hold) for hold in self.hold_s],
            "minor_loops_mm": list(self.minor_loops_mm),
            "warming_K": self.warming_K,
            "gap_s": GAP_S,
        }

    def toml(self, comment: str) -> str:
        """A protocol file, with a comment above it."""
        above = wrap(comment, 100, initial_indent="# ", subsequent_indent="# ")
        return "\n".join([*above, "[protocol]", *(f"{key} = {value}" for key, value in self.table().items()), ""])

    def words(self) -> str:
        """The run as one would say it on the rig."""
        parts = [
            f"run {listed(tuple(sorted(self.pressures_MPa)))} MPa at {listed(self.speeds_mm_s)} mm/s, "
            f"{self.cycles_per_speed} cycles each from {self.bottom_mm:g} to {max(self.tops_mm):g} mm or zero force",
            f"hold {listed(self.hold_s)} s {'in turn ' if len(self.hold_s) > 1 else ''}after the strokes",
        ]
        if self.minor_loops_mm:
            parts.append(f"add minor loops of {listed(self.minor_loops_mm)} mm from the middle of the stroke")
        if self.warming_K:
            parts.append(f"warm the muscle by {self.warming_K:g} K until the middle of the run and let it cool")
        return ", ".join(parts)


def hold_rows(seconds: float) -> int:
    """Rows that a hold is logged with; none where there is no hold."""
    return max(LEAST_ROWS, math.ceil(seconds / ROW_S)) if seconds else 0


def listed(values: tuple[float, ...]) -> str:
    """Numbers as one says them: 1, 10 and 100."""
    *first, last = (f"{v:g}" for v in values)
    return f"{', '.join(first)} and {last}" if first else last
