"""Isobaric test protocols and the fine-grained course of one run.

Each half cycle is a move with a fixed number of rows, then a hold with a fixed number of rows; the course is
computed on a grid `substeps` times finer than the rows, gaps between the isobars included, because effects
with memory (creep, lag, presliding) go on while nobody logs.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

from .integrate import fading
from .muscle import Array, RigMuscle

T = TypeVar("T", int, float)
LEAD_S, TRAIL_S = 0.15, 0.05  # unlogged beginning and end of a hold


class TooShort(ValueError):
    """A muscle does not pull as far as a test asks."""


@dataclass(frozen=True)
class RigRun:
    """One run on the fine grid, all arrays of shape (m,); `rows` (n,) are the logged instants.

    time (s), contraction eps, rate d(eps)/dt (1/s), pressure at the valve (gauge MPa), temperature (deg C),
    moving -1 (extension) | 0 | +1 (contraction), cycle within the isobar from 1, count of cycles since the start of the
    test, isobar number from 0. `slide` is the contraction of the braid, of which rate, moving and heading are; `load`
    (N) what hangs on a muscle whose length answers, None where that is driven.
    """

    time: Array
    eps: Array
    rate: Array
    pressure: Array
    temperature: Array
    moving: Array
    cycle: Array
    count: Array
    isobar: Array
    rows: NDArray[np.intp]
    length_mm: float
    slide: Array
    load: Array | None = None

    @cached_property
    def heading(self) -> Array:
        """The last motion, shape (m,), +1 before any: it was contracted before the first row."""
        last = np.maximum.accumulate(np.where(self.moving != 0, np.arange(len(self.moving)), 0))
        return np.where(self.moving[last] == 0, 1.0, self.moving[last])

    def since_stop(self) -> Array:
        """Seconds since the last motion ended, 0 while moving."""
        last = np.maximum.accumulate(np.where(self.moving != 0, self.time, self.time[0]))
        return self.time - last


@dataclass(frozen=True)
class Protocol:
    """Pressures (MPa), speeds (mm/s), cycles for each speed, hold (s) at each end, rows of each.

    `hold_s` and `hold_rows` may be lists, whose holds then follow the half cycles in turn. A stroke ends at zero
    force, or at `stroke_share` of the length, or within `stroke_mm` (from, to) where that is given. `minor_loops_mm`
    are driven from the middle of the stroke at each speed, each `cycles_per_speed` times; `warming_K` warms the
    muscle by so much until the middle of the run and lets it cool again. `breathing` is the share of its level by which
    the pressure rises or falls at the fastest speed, because the regulator does not keep up. Raises ValueError for what
    no rig can run.
    """

    pressures_MPa: tuple[float, ...] = (0.1, 0.2, 0.3, 0.4, 0.5)
    speeds_mm_s: tuple[float, ...] = (2.0, 10.0, 40.0)
    cycles_per_speed: int = 3
    hold_s: float | tuple[float, ...] = 4.0
    move_rows: int = 40
    hold_rows: int | tuple[int, ...] = 12
    gap_s: float = 20.0
    stroke_share: float = 0.28
    stroke_mm: tuple[float, float] | None = None
    minor_loops_mm: tuple[float, ...] = ()
    warming_K: float = 0.0
    unevenness: float = 0.14
    substeps: int = 8
    breathing: float = 0.0
    kind: ClassVar[str] = "isobaric"

    def __post_init__(self) -> None:
        for name in ("pressures_MPa", "speeds_mm_s"):
            if not getattr(self, name) or min(getattr(self, name)) <= 0:
                raise ValueError(f"{name} = {getattr(self, name)}: at least one, all above zero")
        if self.cycles_per_speed < 1 or self.move_rows < 5 or self.substeps < 1:
            raise ValueError("a protocol needs cycles_per_speed of 1, move_rows of 5 and one substep at least")
        seconds, rows = _listed(self.hold_s), _listed(self.hold_rows)
        if not seconds or min(rows, default=-1) < 0 or len(rows) not in (1, len(seconds)):
            raise ValueError(f"hold_rows = {self.hold_rows}: one number of rows, or one for each of hold_s")
        if any(r and s < 0.5 for s, r in self.holds):
            raise ValueError(f"hold_s = {self.hold_s}: rows in a hold need at least 0.5 s")
        if self.stroke_mm is not None and not self.stroke_mm[0] < self.stroke_mm[1]:
            raise ValueError(f"stroke_mm = {self.stroke_mm}: from, to, where the stroke contracts")
        if min(self.minor_loops_mm, default=1.0) <= 0 or self.gap_s <= 0:
            raise ValueError("minor_loops_mm and gap_s: above zero")

    @property
    def holds(self) -> tuple[tuple[float, int], ...]:
        """Seconds and rows of the holds that follow the half cycles in turn."""
        seconds, rows = _listed(self.hold_s), _listed(self.hold_rows)
        return tuple(zip(seconds, rows * len(seconds), strict=False))

    def run(self, muscle: RigMuscle, rng: np.random.Generator) -> RigRun:
        """The course of a run with the pressures in random order (temperature still flat)."""
        log = _Log(self, muscle.specimen.initial_length_mm)
        order = [float(p) for p in rng.permutation(self.pressures_MPa)]
        at, before = self._stroke(muscle, order[0])[1], order[0]
        for number, pressure in enumerate(order):
            bottom, top = self._stroke(muscle, pressure)
            log.gap(at, top, before, pressure, number)
            for speed in self.speeds_mm_s:
                for _ in range(self.cycles_per_speed):
                    log.start_cycle()
                    for start, end in ((top, bottom), (bottom, top)):
                        log.move(start, end, speed)
                        log.hold(end)
                if self.minor_loops_mm:
                    self._minor_loops(log, bottom, top, speed)
            at, before = top, pressure
        return self._breathed(log.course())

    def _breathed(self, course: RigRun) -> RigRun:
        """With the pressure that falls as the muscle contracts, and recovers within a tenth of a second."""
        if not self.breathing:
            return course
        share = -course.rate * course.length_mm / max(self.speeds_mm_s)
        kept = np.exp(-np.diff(course.time, prepend=course.time[0]) / 0.1)
        slow = fading(kept, (1.0 - kept) * share)
        return replace(course, pressure=course.pressure * (1.0 + self.breathing * slow))

    def heating(self, time: Array) -> Array:
        """Warming (K) at instants (m,) by the heater: up to the middle of the run and down again."""
        return self.warming_K * np.sin(np.pi * (time - time[0]) / (time[-1] - time[0])) ** 2

    def _stroke(self, muscle: RigMuscle, pressure: float) -> tuple[float, float]:
        """Ends of the stroke (mm) at a pressure."""
        if self.stroke_mm is None:
            return 0.0, muscle.stroke_mm(pressure, self.stroke_share)
        bottom, end = self.stroke_mm
        top = muscle.stroke_mm(pressure, end / muscle.specimen.initial_length_mm)
        if top - bottom < 1.0:
            raise TooShort(f"stroke_mm = {self.stroke_mm}: the muscle pulls up to {top:.1f} mm at {pressure:g} MPa")
        return bottom, top

    def _minor_loops(self, log: "_Log", bottom: float, top: float, speed: float) -> None:
        """From the end of the stroke to its middle, the loops there, and back."""
        middle = 0.5 * (bottom + top)
        log.start_cycle()
        log.move(top, middle, speed)
        log.rest(middle)
        for size in self.minor_loops_mm:
            end = min(middle + size, top)
            for _ in range(self.cycles_per_speed):
                log.start_cycle()
                for a, b in ((middle, end), (end, middle)):
                    log.move(a, b, speed)
                    log.rest(b)
        log.move(middle, top, speed)
        log.rest(top)


def _listed(value: T | tuple[T, ...]) -> tuple[T, ...]:
    return value if isinstance(value, tuple) else (value,)


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
    held: int = 0
    pieces: list[Array] = field(default_factory=list)

    def start_cycle(self) -> None:
        self.cycle, self.count = self.cycle + 1, self.count + 1

    def _put(
        self, after: Array, x: Array, v: Array, moving: float, logged: Array, pressure: Array | None = None
    ) -> None:
        p = self.pressure if pressure is None else pressure
        cycle = max(self.cycle, 1)
        piece = np.broadcast_arrays(self.clock + after, x, v, p, moving, cycle, self.count, self.isobar, logged)
        self.pieces.append(np.array(piece))

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
        """The next hold: a little unlogged rest, the rows, a little rest; without rows only the last."""
        seconds, rows = self.protocol.holds[self.held % len(self.protocol.holds)]
        self.held += 1
        k = self.protocol.substeps
        if rows:
            lead = LEAD_S / k * np.arange(1, k)
            s, logged = self._marks(rows)
            self._still(x, lead, 0 * lead)
            span = seconds - LEAD_S - TRAIL_S
            self._still(x, LEAD_S + s * span, logged)
            self.clock += LEAD_S + span
        self.rest(x)

    def rest(self, x: float) -> None:
        """The little rest that ends each hold and parts two moves."""
        k = self.protocol.substeps
        trail = TRAIL_S / k * np.arange(1, k)
        self._still(x, trail, 0 * trail)
        self.clock += TRAIL_S

    def _still(self, x: float, after: Array, logged: Array) -> None:
        self._put(after, x + 0 * after, 0 * after, 0.0, logged)

    def course(self) -> RigRun:
        t, x, v, p, moving, cycle, count, isobar, logged = np.concatenate(self.pieces, axis=1)
        eps, rate, rows = x / self.length_mm, v / self.length_mm, np.flatnonzero(logged > 0)
        flat = np.full_like(t, 23.0)
        return RigRun(t, eps, rate, p, flat, moving, cycle, count, isobar, rows, self.length_mm, eps)


ISOBARIC: dict[str, Protocol] = {
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
    "triangles": Protocol(hold_s=0.0, hold_rows=0, move_rows=50),
    "sines": Protocol(hold_s=0.0, hold_rows=0, move_rows=50, unevenness=1.0),
    "fast_first": Protocol(speeds_mm_s=(50.0, 12.0, 3.0), hold_s=3.0, hold_rows=10),
    "one_cycle": Protocol(cycles_per_speed=1, speeds_mm_s=(1.0, 3.0, 9.0, 27.0), move_rows=60, hold_rows=20),
    "three_pressures": Protocol((0.15, 0.35, 0.55), cycles_per_speed=4),
    "eight_pressures": Protocol((0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6), cycles_per_speed=2),
    "minor_loops": Protocol(cycles_per_speed=1, minor_loops_mm=(4.0, 8.0)),
    "low_stroke": Protocol(stroke_mm=(2.0, 20.0)),
    "breathing": Protocol(breathing=0.02),
    "dense": Protocol(speeds_mm_s=(2.0, 20.0), cycles_per_speed=2, move_rows=160, hold_rows=40),
    "sparse": Protocol(move_rows=16, hold_rows=5),
}
