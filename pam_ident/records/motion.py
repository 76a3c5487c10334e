"""Strokes, reversals and holds, found from the motion alone."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from itertools import pairwise

import numpy as np

from ..core import Array
from . import turning
from .roughness import NORMAL_MEDIAN, noise_in_steps
from .slow_turns import without_slow_turns
from .smoothing import LARGEST, chebyshev_slopes, chebyshev_waves, noise_only, smooth_holds, smooth_stroke
from .turning import BAND, NEAR, evened, pivots, quantile, stepped, thinned_holds, with_corners, without_spikes

Read = Callable[[int, int], tuple[Array, Array, Array, Array]]
"""Time in s, position in mm, nominal pressure in MPa and what answers, such as the force, of some rows, begin … end."""
FEWEST_HELD, SOFT = 6, 3
"""Samples of a hold whose level is known, and of those at either end that may lie off it."""
TURN = 6
"""Order of the curve that describes a smooth drive around a turn, and samples of that on either side at least."""
CLEARLY, SURELY = 4.0, 3.0
"""How many times as much corners miss what goes on from the strokes as what goes on from the rests, in squares over a
segment, from which the muscle still rested there; and the standard deviations by which the answer must not have turned
with the direction: a stroke may bend by more than friction turns."""


@dataclass(frozen=True)
class Motion:
    """Per sample, shape (n,): velocity in mm/s (0 in a hold), direction ±1, moving, the number of the
    stroke a sample belongs to, that stroke's median speed in mm/s, the position in mm with the sensor's
    noise taken out where a smooth stroke or a hold describes it to the noise, and the numbers of its segment (from 0)
    and of its cycle there (from 1)."""

    velocity: Array
    direction: Array
    moving: Array
    stroke: Array
    stroke_speed: Array
    position: Array
    segment: Array
    cycle: Array


def find_motion(time: Array, x: Array, level: Array, answer: Array | None = None) -> Motion:
    """Cut a displacement track (n,), mm over s, at nominal pressures `level`, into segments, strokes, holds and cycles.

    A reversal counts when it goes beyond the noise and 0.4 % of the range; a hold is a stretch that
    stays within the noise for far longer than the stroke around it would take to cross it. What answers (n,), such as
    the force, tells whether the sample at a hold's end still rests.
    """
    pause = long_pause(float(np.quantile(np.diff(time), 0.95)) if len(time) > 1 else 0.0)
    answers = np.zeros(len(x)) if answer is None else answer

    def read(begin: int, end: int) -> tuple[Array, Array, Array, Array]:
        return time[begin:end], x[begin:end], level[begin:end], answers[begin:end]

    parts = [part for _, part in follow(len(x), read, noise_in_steps(x, time), float(np.ptp(x)), pause)]
    return Motion(*(np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(Motion)))


def moving_on(motion: Motion, time: Array, x: Array, noise: float) -> Motion:
    """The motion of a track (n,), mm over s, that does not rest where one curve describes what seems to be a rest, and
    half as much of the track before and behind, to a `noise` in mm: a smooth drive turns there, or slows down."""
    parts = {field.name: getattr(motion, field.name).copy() for field in fields(Motion)}
    edges = np.flatnonzero(np.diff(motion.moving, prepend=True, append=True))
    for begin, end in edges.reshape(-1, 2):
        wide = max((end - begin) // 2, TURN)
        around = np.arange(max(begin - wide, 0), min(end + wide, len(x)))
        around = around[motion.segment[around] == motion.segment[begin]]
        if around[0] == begin or around[-1] == end - 1:  # nobody saw it come to rest, or begin
            continue
        waves = chebyshev_waves(time[around], TURN)
        curve = np.linalg.lstsq(waves, x[around], rcond=None)[0]
        if not noise_only(x[around] - waves @ curve, noise, TURN + 1):
            continue
        rows = slice(begin, end)
        parts["moving"][rows], inside = True, slice(begin - around[0], end - around[0])
        slope = chebyshev_slopes(waves, curve, float(np.ptp(time[around])))[inside]
        parts["velocity"][rows], parts["position"][rows] = slope, (waves @ curve)[inside]
        turned = np.maximum.accumulate(slope * motion.direction[end] > 0.0)
        for name in ("direction", "stroke", "stroke_speed"):
            parts[name][rows] = np.where(turned, parts[name][end], parts[name][begin - 1])
    return Motion(**parts)


def long_pause(usual: float) -> float:
    """Step of the clock in s from which a new segment begins, where `usual` is the 0.95 quantile of all steps."""
    return max(5.0 * usual, 2.0)


def follow(n: int, read: Read, noise: float, span: float, pause: float) -> Iterator[tuple[bool, Motion]]:
    """The motion of a track of `n` samples piece by piece, and whether a segment begins with it: a new one at each
    change of isobar and each step of the clock beyond `pause`. `noise` and `span` in mm are those of the whole track.

    Each second reversal of a segment begins a cycle; the rest before the first stroke is part of the first.
    """
    count, segment, heading, reversals, moved = 0, -1, 0.0, 0, False
    for fresh, time, x, answer in pieces(n, read, reversal(noise, span), pause):
        if fresh:
            segment, reversals, moved = segment + 1, 0, False
        direction, moving, stroke = np.zeros(len(x)), np.zeros(len(x), bool), np.zeros(len(x), int)
        track = np.zeros(len(x)), direction, moving, stroke, np.zeros(len(x)), x.copy()
        found = Motion(*track, np.full(len(x), segment), np.ones(len(x)))
        count = move_piece(found, time, x, noise, span, count)
        if not moving.any():  # as where the pressure goes to another level: it still leans the way it came
            direction[:] = heading
        _rest_longer(found, x, answer, noise)
        turned = np.diff(direction, prepend=heading) != 0.0
        if not moved:
            turned[: int(np.argmax(moving)) + 1] = False
        turns = reversals + np.cumsum(turned)
        found.cycle[:] += turns // 2
        heading, reversals, moved = float(direction[-1]), int(turns[-1]), moved or bool(moving.any())
        yield fresh, found


def pieces(n: int, read: Read, threshold: float, pause: float) -> Iterator[tuple[bool, Array, Array, Array]]:
    """Time, position and what answers, shape (m,), of pieces of no more than PIECE samples each, cut at a turn where a
    segment is longer, and whether a segment begins with it."""
    most, begin, fresh = turning.PIECE, 0, True
    while begin < n:
        end = min(begin + 2 * most, n)
        time, x, level, answer = read(begin, end)
        breaks = np.flatnonzero((np.diff(level) != 0.0) | (np.diff(time) > pause)) + 1
        at = 0
        for stop in [*breaks.tolist(), len(x)]:
            while stop - at > most:
                late = (turn for turn in pivots(x[at : at + most], threshold) if most // 2 <= turn < most - 1)
                cut = at + next(late, most)  # the first turn in the second half
                yield fresh, time[at:cut], x[at:cut], answer[at:cut]
                at, fresh = cut, False
            if stop < len(x) or end == n:
                yield fresh, time[at:stop], x[at:stop], answer[at:stop]
                at, fresh = stop, True
        begin += at


def reversal(noise: float, span: float) -> float:
    """Way in mm against the heading from which a track has turned, for its noise and range in mm."""
    return max(BAND * noise, 0.004 * span)


def move_piece(into: Motion, time: Array, x: Array, noise: float, span: float, count: int) -> int:
    """Find the strokes and holds of a piece (n,) of a track, number them from `count` + 1, and write them into `into`,
    whose arrays (n,) are zero and x; the number of the last. `noise` and `span` in mm are those of the whole track."""
    direction, moving, stroke, speed = into.direction, into.moving, into.stroke, into.stroke_speed
    even, calm = evened(time, x, noise)
    least = reversal(calm, span)
    turns = without_spikes(even, pivots(even, least), span) if span else [0, len(x) - 1]
    held = thinned_holds(time, x, turns, noise, span, even, calm)
    if held.any():
        turns, held = without_slow_turns(time, x, turns, held, with_corners(time, x, held, noise), noise)
        held = stepped(x, held, noise)
    for begin, end in pairwise(turns):
        inside = np.arange(begin, end + 1)
        inside = inside[~held[begin : end + 1] & ~moving[begin : end + 1]]
        parts = np.split(inside, np.flatnonzero(np.diff(inside) > 1) + 1)  # at stairs, or a rest that ends at its turn
        ways = [abs(_level(even, held, p[-1], end) - _level(even, held, p[0], begin)) if len(p) else 0.0 for p in parts]
        enough = least if len(parts) > 1 else BAND * calm  # all of a piece moves, if it is more than noise
        strokes = [p for p, way in zip(parts, ways, strict=True) if len(p) > 1 and way >= enough]
        strokes += _jumps(even, held, begin, end, least)
        for part in sorted(strokes, key=lambda rows: rows[0]):
            count += 1
            rows = _square_ends(time, x, part, moving, noise)
            if len(part) > 1:
                into.position[rows], slope = smooth_stroke(time[rows], x[rows], noise)
            else:
                near = [part[0] - 1, min(part[0] + 1, end)]
                slope = np.diff(x[near]) / np.diff(time[near])
            into.velocity[rows], moving[rows], stroke[rows] = slope, True, count
            direction[rows] = np.sign(even[end] - even[begin])
            speed[rows] = quantile(np.abs(slope), 0.5)
    _carry(direction, moving, stroke, speed)
    _soft_ends(into, time, x, noise)
    smooth_holds(into.position, time, x, np.flatnonzero(~moving), noise)
    return count


def _level(x: Array, held: Array, k: int, towards: int) -> float:
    """Position in mm from which a part of a track (n,) moves, or to which, at its sample `k`: that of the rest beside
    it, `towards` another sample, if there is one."""
    step = 1 if towards > k else -1
    beside = np.arange(k + step, k + step * (min(abs(towards - k), NEAR) + 1), step)
    rest = beside[: len(beside) if held[beside].all() else int(np.argmin(held[beside]))]
    return float(x[rest].mean() if len(rest) else x[k])


def _jumps(x: Array, held: Array, begin: int, end: int, least: float) -> list[Array]:
    """Strokes from one hold, or a turn, to the next with a single sample between them, or none: then the first of the
    next, as one sample (1,) each; by `least` mm and more, between two turns."""
    k = np.arange(begin + 1, end + 1)
    starts, after = held[k - 1] | (k == begin + 1), np.minimum(k + 1, end)
    arrived = starts & held[k] & (np.abs(x[k] - x[k - 1]) >= least)
    between = starts & ~held[k] & held[after] & (np.abs(x[after] - x[k - 1]) >= least)
    return [k[[one]] for one in np.flatnonzero(arrived | between)]


def _soft_ends(into: Motion, time: Array, x: Array, noise: float) -> None:
    """Give the samples at the ends of a hold that are off its level to the strokes beside it: there a drive speeds up,
    or brakes, and the muscle slides as it does in the stroke, if not as fast."""
    moving = into.moving
    edges = np.r_[0, np.flatnonzero(np.diff(moving)) + 1, len(x)].tolist()
    for begin, end in pairwise(edges):
        if moving[begin] or end - begin < FEWEST_HELD:
            continue
        off = np.abs(x[begin:end] - quantile(x[begin:end], 0.5))
        away = off > LARGEST * max(quantile(off, 0.5) / NORMAL_MEDIAN, noise)
        for rows, stroke in ((range(begin, end), begin - 1), (range(end - 1, begin - 1, -1), end)):
            for k in rows[:SOFT] if 0 <= stroke < len(x) else ():
                if not away[k - begin]:
                    break
                near = max(k - 1, 0), min(k + 1, len(x) - 1)
                moving[k] = True
                into.velocity[k] = (x[near[1]] - x[near[0]]) / max(time[near[1]] - time[near[0]], 1e-12)
                for track in (into.direction, into.stroke, into.stroke_speed):
                    track[k] = track[stroke]


def _rest_longer(found: Motion, x: Array, answer: Array, noise: float) -> None:
    """Give the sample with which strokes begin, at a hold's level, back to the holds, where what answers (n,) goes on
    there as it does at rest: its line from the hold misses it by less than its line from the stroke.

    A clock that ticks through a hold takes its last sample before the muscle moves; a record made by a formula may have
    it move there already. Friction turns between the two, and a position does not tell which it is.
    """
    moving = found.moving
    first = np.flatnonzero(moving[1:] & ~moving[:-1]) + 1
    first = first[(first > 1) & (first + 2 < len(x))]
    inside = ~moving[first - 2] & moving[first + 1] & moving[first + 2]
    still = np.abs(x[first] - x[first - 1]) <= 5.0 * noise
    corners = first[inside & still & (np.abs(x[first + 1] - x[first]) > 6.0 * noise)]
    if len(corners) < 3:
        return
    rest, stroke = (answer[corners] - 2.0 * answer[corners + k] + answer[corners + 2 * k] for k in (-1, 1))
    turned = found.direction[corners] * rest
    chance = SURELY * float(np.std(turned)) / math.sqrt(len(corners))
    if CLEARLY * float(rest @ rest) < float(stroke @ stroke) and abs(float(np.mean(turned))) <= chance:
        moving[corners], found.velocity[corners] = False, 0.0
        for track in (found.direction, found.stroke, found.stroke_speed, found.position):
            track[corners] = track[corners - 1]


def _square_ends(time: Array, x: Array, inside: Array, taken: Array, noise: float) -> Array:
    """Indices of a stroke with its ends set right: a sample at a corner belongs to the stroke whose line runs
    through it, which the distance from the stroke's own extrapolation tells where one step exceeds the noise."""
    if len(inside) < 6:
        return np.r_[inside, inside[-1] + 1] if _arrives(time, x, inside, taken, noise) else inside
    first, last = int(inside[0]), int(inside[-1])
    tolerance = 3.0 * noise + 0.02 * abs(x[last] - x[first]) / len(inside)

    def three(near: int) -> tuple[float, ...]:
        """Times and positions of three samples in numbers of Python, which are quicker than arrays so small."""
        return (*time[near : near + 3].tolist(), *x[near : near + 3].tolist())

    def off(at: int, near: int) -> float:
        """Distance of a sample from the line through the three from `near` on."""
        t0, t1, t2, x0, x1, x2 = three(near)
        t, y = (t0 + t1 + t2) / 3.0, (x0 + x1 + x2) / 3.0
        spread = (t0 - t) ** 2 + (t1 - t) ** 2 + (t2 - t) ** 2  # 0 where a clock is coarser than the rows
        slope = ((t0 - t) * x0 + (t1 - t) * x1 + (t2 - t) * x2) / spread if spread > 0.0 else 0.0
        return abs(x.item(at) - y - slope * (time.item(at) - t))

    def bend(near: int) -> float:
        """What a parabola through three samples adds to their line at the next, and more: by the clock, because
        steps that differ as the clock does are no bend."""
        t0, t1, t2, x0, x1, x2 = three(near)
        if not t0 < t1 < t2:
            return 0.0
        return 2.0 * abs((x2 - x1) / (t2 - t1) - (x1 - x0) / (t1 - t0)) * (t2 - t0)

    # Up to two samples at an end belong to what is before or behind it. With this stroke's branch and speed they were
    # named a rub or hysteresis where the law is steep.
    for _ in range(2):
        near = last - 3
        if last - first > 6 and off(last, near) > 2.0 * tolerance + bend(near):
            last -= 1
        near = first + 1
        if last - first > 6 and off(first, near) > 2.0 * tolerance + bend(near):
            first += 1
    # A neighbour at the level of an end is the hold already, and that end the corner.
    for _ in range(2):
        if last + 1 < len(x) and not taken[last + 1] and _steps(x, (last - 1, last, last + 1), tolerance, noise):
            near = last - 2
            last += off(last + 1, near) < tolerance + bend(near)
        if first > 0 and not taken[first - 1] and _steps(x, (first + 1, first, first - 1), tolerance, noise):
            first -= off(first - 1, first) < tolerance + bend(first)
    return np.arange(first, last + 1)


def _arrives(time: Array, x: Array, inside: Array, taken: Array, noise: float) -> bool:
    """Whether the row behind a stroke of few rows, at a rest's level, lies on their line by the clock: it was read as
    the stroke ended."""
    after = int(inside[-1]) + 1
    if len(inside) < 2 or after >= len(x) or taken[after]:
        return False
    t = time[inside] - time[inside].mean()
    spread = float(t @ t)
    if not spread > 0.0:
        return False
    slope, ahead = float(t @ x[inside]) / spread, float(time[after] - time[inside].mean())
    sure = noise * math.sqrt(1.0 + 1.0 / len(inside) + ahead**2 / spread)
    return abs(x[after] - x[inside].mean() - slope * ahead) < 3.0 * sure < abs(x[after] - x[after - 1])


def _steps(x: Array, at: tuple[int, int, int], tolerance: float, noise: float) -> bool:
    """Whether the last step of a stroke and the one beyond its end both exceed the noise, in one direction: behind a
    turning point the next stroke begins, however round the turn."""
    inner, end, outer = (x.item(k) for k in at)
    onward = outer - end if end > inner else end - outer
    return abs(end - inner) > 1.5 * tolerance and onward > 4.0 * noise


def _carry(direction: Array, moving: Array, stroke: Array, speed: Array) -> None:
    """Give each hold to the stroke before it; a hold that begins a piece to the opposite branch of the next."""
    active = np.flatnonzero(moving)
    if not len(active):
        return
    previous = np.searchsorted(active, np.arange(len(moving)), side="right") - 1
    source = active[np.maximum(previous, 0)]
    direction[:], stroke[:], speed[:] = direction[source], stroke[source], speed[source]
    # The record begins at rest at the start of a stroke, to which the muscle came from the other side.
    direction[: active[0]] *= -1.0
