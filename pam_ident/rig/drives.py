"""Tests that drive the pressure: at a locked length, under a dead weight, or while the length is driven too.

What a locked muscle rubs and creeps along is its braid, which shortens a little by what threads and ends give: a way
`slide` of some millimetres a kilonewton beside the contraction.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from .muscle import Array, RigMuscle
from .protocol import ISOBARIC, Protocol, RigRun

Shape = Callable[[Array], Array]
"""Seconds since a piece began, shape (m,) → a share of pressure, stroke or load, 0 to 1."""
LOWEST_MPA, HIGHEST_MPA = (0.18, 0.26), (0.5, 0.6)
GIVE_MM_KN = (1.0, 2.0)
PLACES = (0.0, 0.2, 0.4, 0.6, 0.85)
"""Where the length is locked, as shares of the stroke at the lowest pressure."""
LOADS = (0.2, 0.5, 0.8)
"""Dead weights as shares of what the muscle lifts at the lowest pressure."""
SUBSTEPS = 8
STILL = 1e-7
"""Rate of the slide (1/s) below which nothing moves."""


@dataclass(frozen=True)
class Stretch:
    """Some seconds with as many logged rows; `place` is that of the length, or of the load where that is held.

    A cycle lasts `period` seconds, the first has the number `cycle`.
    """

    seconds: float
    rows: int
    pressure: Shape
    place: Shape
    cycle: int
    period: float = np.inf


Segment = list[Stretch]


@dataclass(frozen=True)
class Drive:
    """A test by its kind (isometric, isotonic, combined, dynamic) and its segments, which `segments` gives by the
    stroke in mm at the lowest pressure; they are parted by gaps without rows."""

    kind: str
    segments: Callable[[float, np.random.Generator], list[Segment]]
    gap_s: float = 20.0

    def run(self, muscle: RigMuscle, rng: np.random.Generator) -> RigRun:
        """The course of a run (temperature still flat)."""
        low, high, give = (rng.uniform(*ends) for ends in (LOWEST_MPA, HIGHEST_MPA, GIVE_MM_KN))
        length, stroke = muscle.specimen.initial_length_mm, muscle.stroke_mm(low)
        loaded = self.kind == "isotonic"
        top = float(muscle.force(np.array([low]), np.zeros(1))[0]) if loaded else stroke / length
        parts, clock, count = [], 0.0, 0
        for number, segment in enumerate(self.segments(stroke, rng)):
            clock += self.gap_s
            begun = count
            for piece in segment:
                t = piece.seconds * np.arange(1, piece.rows * SUBSTEPS + 1) / (piece.rows * SUBSTEPS)
                cycle = piece.cycle + np.floor((t - t[0]) / piece.period)
                p, place = low + (high - low) * piece.pressure(t), top * piece.place(t)
                logged = np.arange(1, len(t) + 1) % SUBSTEPS == 0
                parts.append(np.array([clock + t, p, place, cycle, begun + cycle, number + 0 * t, logged]))
                clock += piece.seconds
                count = int(begun + cycle[-1])
        t, p, place, cycle, count_, isobar, logged = _with_gaps(np.concatenate(parts, axis=1), self.gap_s)
        eps = muscle.contraction(p, place) if loaded else place
        slide = eps + 1e-3 * give * muscle.force(p, eps) / length
        rate = np.gradient(slide, t)
        moving = np.where(np.abs(rate) > STILL, np.sign(rate), 0.0)
        rows, flat = np.flatnonzero(logged > 0), np.full_like(t, 23.0)
        load = place if loaded else None
        return RigRun(t, eps, rate, p, flat, moving, cycle, count_, isobar, rows, length, slide, load)

    def heating(self, time: Array) -> Array:
        """No heater, shape (m,)."""
        return np.zeros_like(time)


def _with_gaps(course: Array, gap_s: float) -> Array:
    """The course with a way to each segment on the fine grid, in the first half of the gap before it."""
    out, share = [], np.linspace(0.0, 1.0, 200, endpoint=False)
    for number in np.unique(course[5]):
        here = course[:, course[5] == number]
        first, before = here[:, 0], (out[-1][:, -1] if out else here[:, 0])
        way = np.clip(2.0 * share, 0.0, 1.0)
        gap = first[:, None] + 0.0 * share
        gap[0] = first[0] - gap_s * (1.0 - share) * (1.0 - 1e-6)
        gap[1:3] = before[1:3, None] + (first[1:3] - before[1:3])[:, None] * way
        gap[6] = 0.0
        out += [gap, here]
    return np.concatenate(out, axis=1)


def at(share: float) -> Shape:
    """Held."""
    return lambda t: share + 0.0 * t


def ramp(start: float, end: float, seconds: float) -> Shape:
    """Straight from start to end."""
    return lambda t: start + (end - start) * np.clip(t / seconds, 0.0, 1.0)


def settle(start: float, end: float, tau: float, since: float = 0.0) -> Shape:
    """As a regulator goes to a new level."""
    return lambda t: end + (start - end) * np.exp(-np.maximum(t - since, 0.0) / tau)


def strokes(period: float) -> Shape:
    """A triangle from 0 to 1 and back."""
    return lambda t: 1.0 - np.abs(2.0 * ((t / period) % 1.0) - 1.0)


def wave(period: float, phase: float = 0.0) -> Shape:
    """A sine."""
    return lambda t: 0.5 - 0.5 * np.cos(2 * np.pi * (t / period + phase))


def chirp(from_Hz: float, to_Hz: float, seconds: float) -> Shape:
    """A sine whose frequency goes from one to the other, evenly on a logarithm."""
    growth = np.log(to_Hz / from_Hz) / seconds
    return lambda t: 0.5 - 0.5 * np.cos(2 * np.pi * from_Hz * np.expm1(growth * t) / growth)


def _ramps(place: Shape) -> Segment:
    pieces, cycle = [], 0
    for seconds in (20.0, 5.0, 1.25):
        for _ in range(2):
            cycle += 1
            for start, end in ((0.0, 1.0), (1.0, 0.0)):
                pieces.append(Stretch(seconds, 40, ramp(start, end, seconds), place, cycle))
                pieces.append(Stretch(3.0, 8, at(end), place, cycle))
    return pieces


def _stairs(place: Shape) -> Segment:
    up = np.linspace(0.0, 1.0, 5).tolist()
    levels = [*up, *up[-2::-1]]
    return [
        piece
        for cycle in (1, 2)
        for a, b in pairwise(levels)
        for piece in (
            Stretch(1.5, 24, settle(a, b, 0.3), place, cycle),
            Stretch(3.5, 10, settle(a, b, 0.3, -1.5), place, cycle),
        )
    ]


def _sweep(place: Shape) -> Segment:
    return [Stretch(100.0, 500, chirp(0.02, 0.5, 100.0), place, 1, 20.0)]


def _at_each(places: tuple[float, ...], segment: Callable[[Shape], Segment]) -> Callable[..., list[Segment]]:
    return lambda stroke, rng: [segment(at(float(place))) for place in rng.permutation(places)]


def _halves(stroke: float) -> Iterator[tuple[float, int]]:
    """Seconds of a stroke at three speeds, and the cycles at each."""
    for speed in (2.0, 10.0, 40.0):
        yield stroke / speed, 4


def _waves(stroke: float, rng: np.random.Generator) -> list[Segment]:
    """Strokes while the pressure waves, now more slowly than they, now faster."""
    return [
        [Stretch(2 * half * n, 100 * n, wave(half * ratio, rng.uniform()), strokes(2 * half), 1, 2 * half)]
        for half, n in _halves(stroke)
        for ratio in (3.3, 0.8)
    ]


def _tide(stroke: float, rng: np.random.Generator) -> list[Segment]:
    """Strokes while the pressure rises all the while, and then falls."""
    return [
        [Stretch(2 * half * n, 100 * n, ramp(a, 1 - a, 2 * half * n), strokes(2 * half), 1, 2 * half)]
        for half, n in _halves(stroke)
        for a in (0.0, 1.0)
    ]


def _switched(stroke: float, rng: np.random.Generator) -> list[Segment]:
    """Strokes in each of which the pressure is switched to another level."""
    out = []
    for half, n in _halves(stroke):
        levels = rng.permutation(np.tile(np.linspace(0.0, 1.0, 5), 4))[: 2 * n + 1].tolist()
        pieces = []
        for k, (a, b) in enumerate(pairwise(levels)):
            way = ramp(0.0, 1.0, half) if k % 2 == 0 else ramp(1.0, 0.0, half)
            pieces.append(Stretch(half, 50, settle(a, b, 0.1 + 0.05 * half, 0.4 * half), way, 1 + k // 2))
        out.append(pieces)
    return out


def _sines(stroke: float, rng: np.random.Generator) -> list[Segment]:
    """Length and pressure in sines of unlike periods."""
    return [
        [Stretch(8 * period, 400, wave(period * ratio, rng.uniform()), wave(period), 1, period)]
        for period in (10.0, 3.0, 1.0)
        for ratio in (1.618, 0.382)
    ]


def _chirps(stroke: float, rng: np.random.Generator) -> list[Segment]:
    """Length and pressure in sweeps against each other."""
    return [
        [Stretch(100.0, 800, chirp(*pressure, 100.0), chirp(*length, 100.0), 1, 25.0)]
        for pressure, length in (((0.5, 0.03), (0.04, 0.7)), ((0.03, 0.4), (0.6, 0.05)), ((0.05, 0.9), (0.02, 0.3)))
    ]


DRIVES = {
    "locked_ramps": Drive("isometric", _at_each(PLACES, _ramps)),
    "locked_stairs": Drive("isometric", _at_each(PLACES, _stairs)),
    "locked_sweep": Drive("isometric", _at_each(PLACES, _sweep)),
    "waves": Drive("combined", _waves),
    "tide": Drive("combined", _tide),
    "switched": Drive("combined", _switched),
    "crossed_sines": Drive("dynamic", _sines),
    "crossed_sweeps": Drive("dynamic", _chirps),
    "weight_ramps": Drive("isotonic", _at_each(LOADS, _ramps)),
    "weight_stairs": Drive("isotonic", _at_each(LOADS, _stairs)),
}

PROTOCOLS: dict[str, Protocol | Drive] = {**ISOBARIC, **DRIVES}
