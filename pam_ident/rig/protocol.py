"""Isobaric test protocols and the fine-grained course of one run.

Each half cycle is a move with a fixed number of rows, then a hold with a fixed number of rows; the course is
computed on a grid `substeps` times finer than the rows, gaps between the isobars included, because effects
with memory (creep, lag, presliding) go on while nobody logs.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .muscle import Array, Muscle

LEAD_S, TRAIL_S = 0.15, 0.05  # unlogged beginning and end of a hold


@dataclass(frozen=True)
class Course:
    """One run on the fine grid, all arrays of shape (m,); `rows` (n,) are the logged instants.

    time (s), contraction eps, rate d(eps)/dt (1/s), pressure at the valve (gauge MPa), temperature (deg C),
    moving -1 (extension) | 0 | +1 (contraction), heading = last motion, cycle within the isobar from 1,
    count of cycles since the start of the test, isobar number from 0.
    """

    time: Array
    eps: Array
    rate: Array
    pressure: Array
    temperature: Array
    moving: Array
    heading: Array
    cycle: Array
    count: Array
    isobar: Array
    rows: NDArray[np.intp]
    length_mm: float

    def since_stop(self) -> Array:
        """Seconds since the last motion ended, 0 while moving."""
        last = np.maximum.accumulate(np.where(self.moving != 0, self.time, self.time[0]))
        return self.time - last


@dataclass(frozen=True)
class Protocol:
    """Pressures (MPa), speeds (mm/s), cycles for each speed, hold (s) at each end, rows of each."""

    pressures_MPa: tuple[float, ...] = (0.1, 0.2, 0.3, 0.4, 0.5)
    speeds_mm_s: tuple[float, ...] = (2.0, 10.0, 40.0)
    cycles_per_speed: int = 3
    hold_s: float = 4.0
    move_rows: int = 40
    hold_rows: int = 12
    gap_s: float = 20.0
    stroke_share: float = 0.28
    unevenness: float = 0.14
    substeps: int = 8

    def __post_init__(self) -> None:
        if not self.pressures_MPa or min(self.pressures_MPa) <= 0:
            raise ValueError(f"pressures_MPa = {self.pressures_MPa}: at least one, all above zero")
        if not self.speeds_mm_s or min(self.speeds_mm_s) <= 0:
            raise ValueError(f"speeds_mm_s = {self.speeds_mm_s}: at least one, all above zero")
        if self.cycles_per_speed < 1 or self.move_rows < 5 or self.substeps < 1:
            raise ValueError("a protocol needs a cycle, five rows a move and one substep")
        if self.hold_rows and self.hold_s < 0.5:
            raise ValueError(f"hold_s = {self.hold_s}: rows in a hold need at least 0.5 s")

    @property
    def n_rows(self) -> int:
        """Rows of the record."""
        halves = 2 * len(self.pressures_MPa) * len(self.speeds_mm_s) * self.cycles_per_speed
        return halves * (self.move_rows + self.hold_rows)

    def run(self, muscle: Muscle, rng: np.random.Generator) -> Course:
        """The course of a run with the pressures in random order (temperature still flat)."""
        log = _Log(self, muscle.specimen.initial_length_mm)
        order = [float(p) for p in rng.permutation(self.pressures_MPa)]
        at, before = muscle.stroke_mm(order[0], self.stroke_share), order[0]
        for number, pressure in enumerate(order):
            top = muscle.stroke_mm(pressure, self.stroke_share)
            log.gap(at, top, before, pressure, number)
            for speed in self.speeds_mm_s:
                for _ in range(self.cycles_per_speed):
                    log.start_cycle()
                    for start, end in ((top, 0.0), (0.0, top)):
                        log.move(start, end, speed)
                        log.hold(end)
            at, before = top, pressure
        return log.course()


@dataclass
class _Log:
    """Appends the pieces of a run one after another."""

    protocol: Protocol
    length_mm: float
    clock: float = 0.0
    pressure: float = 0.0
    cycle: int = 0
    count: int = 0
    isobar: int = 0
    pieces: list[Array] = field(default_factory=list)

    def start_cycle(self) -> None:
        self.cycle, self.count = self.cycle + 1, self.count + 1

    def _put(
        self, after: Array, x: Array, v: Array, moving: float, logged: Array, pressure: Array | None = None
    ) -> None:
        one = np.ones_like(after)
        p = self.pressure * one if pressure is None else pressure
        self.pieces.append(
            np.array(
                [
                    self.clock + after,
                    x,
                    v,
                    p,
                    moving * one,
                    max(self.cycle, 1) * one,
                    self.count * one,
                    self.isobar * one,
                    logged,
                ]
            )
        )

    def _marks(self, rows: int) -> tuple[Array, Array]:
        """Progress 0..1 on the fine grid, and 1 where a row is logged."""
        k = self.protocol.substeps
        logged = np.zeros((rows - 1) * k + 1)
        logged[::k] = 1.0
        return np.linspace(0.0, 1.0, len(logged)), logged

    def gap(self, x0: float, x1: float, p0: float, p1: float, isobar: int) -> None:
        """Between isobars, not logged: to the new pressure and stroke in a quarter of the gap, then rest."""
        self.cycle, self.isobar, self.pressure = 0, isobar, p1
        total = self.protocol.gap_s
        after = np.linspace(0.0, total, 400, endpoint=False)
        share = np.clip(4 * after / total, 0.0, 1.0)
        v = np.where(share < 1, (x1 - x0) * 4 / total, 0.0)
        self._put(after, x0 + (x1 - x0) * share, v, 0.0, 0 * after, p0 + (p1 - p0) * share)
        self.clock += total

    def move(self, start: float, end: float, speed: float) -> None:
        """A move at `speed` on average; the carriage is slower at both ends, as a real drive is."""
        duration, depth = abs(end - start) / speed, self.protocol.unevenness
        s, logged = self._marks(self.protocol.move_rows)
        x = start + (end - start) * (s - depth / (2 * np.pi) * np.sin(2 * np.pi * s))
        v = (end - start) / duration * (1 - depth * np.cos(2 * np.pi * s))
        self._put(s * duration, x, v, float(np.sign(end - start)), logged)
        self.clock += duration

    def hold(self, x: float) -> None:
        """A hold: a little unlogged rest, the rows, a little rest; without rows only the last."""

        def still(after: Array, logged: Array) -> None:
            self._put(after, x + 0 * after, 0 * after, 0.0, logged)

        k = self.protocol.substeps
        if self.protocol.hold_rows:
            lead = LEAD_S / k * np.arange(1, k)
            s, logged = self._marks(self.protocol.hold_rows)
            still(lead, 0 * lead)
            span = self.protocol.hold_s - LEAD_S - TRAIL_S
            still(LEAD_S + s * span, logged)
            self.clock += LEAD_S + span
        trail = TRAIL_S / k * np.arange(1, k)
        still(trail, 0 * trail)
        self.clock += TRAIL_S

    def course(self) -> Course:
        t, x, v, p, moving, cycle, count, isobar, logged = np.concatenate(self.pieces, axis=1)
        index = np.maximum.accumulate(np.where(moving != 0, np.arange(len(t)), 0))
        heading = np.where(moving[index] == 0, 1.0, moving[index])  # it was contracted before the first row
        return Course(
            t,
            x / self.length_mm,
            v / self.length_mm,
            p,
            np.full_like(t, 23.0),
            moving,
            heading,
            cycle,
            count,
            isobar,
            np.flatnonzero(logged > 0),
            self.length_mm,
        )


PROTOCOLS: dict[str, Protocol] = {
    "standard": Protocol(),
    "other_speeds": Protocol(speeds_mm_s=(1.0, 5.0, 25.0), hold_s=6.0),
    "four_speeds": Protocol(speeds_mm_s=(2.0, 6.0, 20.0, 60.0), move_rows=30, hold_rows=8),
    "slow_to_fast": Protocol(
        speeds_mm_s=(1.0, 4.0, 16.0, 50.0), cycles_per_speed=2, hold_s=8.0, move_rows=44, hold_rows=14
    ),
    "six_pressures": Protocol((0.1, 0.2, 0.3, 0.4, 0.5, 0.6), cycles_per_speed=2, move_rows=48, hold_rows=14),
    "four_pressures": Protocol((0.15, 0.3, 0.45, 0.6), hold_s=5.0, move_rows=50, hold_rows=14),
    "long_holds": Protocol(cycles_per_speed=2, hold_s=20.0, move_rows=50, hold_rows=26),
    "blunt": Protocol(speeds_mm_s=(10.0,), hold_s=0.0, hold_rows=0),
}
