"""Memory along a record: relaxation in time and elements that slip.

Where the inputs are live, the same recursion takes one step from the last accepted instant, for each muscle apart.
"""

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..core import Inputs
from ..core.recursion import Live, Slot, decaying_sum
from .base import Values, slip

Array = np.ndarray
STROKE_MM = 40.0
"""A usual stroke."""


def relax(inputs: Inputs, drive: Array, tau: float | Array) -> Array:
    """Response q of a Maxwell element, q̇ = ḋ − q/τ, q = 0 at the first sample, shape of `drive` (n,).

    Exact for a drive that is linear between samples; between segments it jumps at once and then rests, as a
    rig does that goes to its next start and settles there. `tau` in s may differ from sample to sample, shape (n,).
    """
    assert inputs.time is not None and inputs.segment is not None
    if inputs.live is not None:
        return _relax_live(inputs.live, inputs, drive, tau + inputs.xp.zeros_like(drive))
    decay = np.diff(inputs.time) / (0.5 * (tau[1:] + tau[:-1]) if isinstance(tau, np.ndarray) else tau)
    lost = -np.expm1(-decay)
    kept = 1.0 - lost
    answer = np.divide(lost, decay, out=np.ones(len(decay)), where=decay > 1e-9)
    jumps = np.flatnonzero(np.diff(inputs.segment))
    answer[jumps] = kept[jumps]
    return decaying_sum(kept, np.diff(drive) * answer)


def integral(inputs: Inputs, values: Array, over: Array) -> Array:
    """Of values (n,) over another quantity (n,), from the first sample on, shape (n,)."""
    if inputs.live is not None:

        def advance(total: Array, value: Array, before: Array) -> Slot:
            return total + 0.5 * (values + value) * (over - before), values, over

        return inputs.live.step((inputs.xp.zeros_like(over), values, over), advance)[0]
    return np.r_[0.0, np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(over))]


def relax_from_none(inputs: Inputs, drive: Array, tau: float, anew: float) -> Array:
    """As `relax`, of a drive that began at the first sample from 0, and between segments went back by the share `anew`
    of its way from there."""
    assert inputs.time is not None and inputs.segment is not None
    first = drive - since_first(inputs, drive)
    carried = relax(inputs, drive, tau) + first * inputs.xp.exp(-since_first(inputs, inputs.time) / tau)
    if inputs.live is not None:
        return carried
    jumps = np.flatnonzero(np.diff(inputs.segment))
    kept, gain = np.exp(-np.diff(inputs.time) / tau), np.zeros(len(carried) - 1)
    kept[jumps] *= 1.0 - anew
    gain[jumps] = anew * (drive[jumps + 1] - carried[jumps + 1])
    return carried + decaying_sum(kept, gain)


def _relax_live(live: Live, inputs: Inputs, drive: Array, tau: Array) -> Array:
    assert inputs.time is not None
    xp, now = inputs.xp, inputs.time

    def advance(q: Array, drive_before: Array, tau_before: Array, time: Array) -> Slot:
        decay = (now - time) / (0.5 * (tau + tau_before))
        answer = xp.where(decay > 1e-9, -xp.expm1(-decay) / xp.maximum(decay, 1e-300), 1.0)
        return q * xp.exp(-decay) + (drive - drive_before) * answer, drive, tau, now

    return live.step((xp.zeros_like(drive), drive, tau, now), advance)[0]


def _moved_live(live: Live, inputs: Inputs, move: Callable[[Array, Array], Array], begun: Array | float = 0.0) -> Array:
    """State that is `begun` at first, and that `move` takes from one instant to the next over the travel in mm."""
    x = inputs.way_mm
    return live.step((begun + inputs.xp.zeros_like(x), x), lambda state, before: (move(state, x - before), x))[0]


def since_first(inputs: Inputs, values: Array) -> Array:
    """Values (n,) less that of the first sample."""
    if inputs.live is None:
        return values - values[0]
    return values - inputs.live.step((values,), lambda first: (first,))[0]


def time_held(inputs: Inputs, held: Array) -> Array:
    """Seconds since the hold began that a sample is part of, by the mask `held`, shape (n,)."""
    assert inputs.time is not None
    if inputs.live is not None:
        xp, now = inputs.xp, inputs.time
        mark = xp.where(held, 1.0, 0.0)

        def advance(begin: Array, before: Array) -> Slot:
            return xp.where(mark > before, now, begin), mark

        return now - inputs.live.step((now, mark), advance)[0]
    return since_begun(inputs.time, np.r_[True, held[1:] & ~held[:-1]])


def since_begun(time: Array, begins: Array) -> Array:
    """Seconds since the last sample at which something begins, by that mask, first sample included, shape (n,)."""
    return time - time[np.maximum.accumulate(np.where(begins, np.arange(len(time)), 0))]


def greatest_so_far(inputs: Inputs, values: Array) -> Array:
    """Greatest of the values (n,) up to each sample, since cycles were last counted anew, the rubber rested."""
    assert inputs.cycle is not None
    if inputs.live is not None:
        return inputs.live.step((values,), lambda most: (inputs.xp.maximum(most, values),))[0]
    anew = np.flatnonzero(np.diff(inputs.cycle) < 0) + 1
    return np.concatenate([np.maximum.accumulate(part) for part in np.split(values, anew)])


def way_travelled(inputs: Inputs, of_test: bool = False) -> Array:
    """Millimetres gone to and fro up to each sample, since cycles were last counted anew, the rubber rested, or
    since the test began if it is `of_test`, (n,)."""
    assert inputs.cycle is not None
    x = inputs.way_mm
    if inputs.live is not None:
        xp = inputs.xp
        return inputs.live.step((xp.zeros_like(x), x), lambda way, before: (way + xp.abs(x - before), x))[0]
    steps = np.abs(np.diff(x, prepend=x[0]))
    anew = np.diff(inputs.cycle, prepend=inputs.cycle[0]) < (-math.inf if of_test else 0)
    steps[anew] = 0.0
    way = np.cumsum(steps)
    begins = np.maximum.accumulate(np.where(anew, np.arange(len(x)), 0))
    return way - way[begins]


def cycles_of_test(inputs: Inputs) -> Array:
    """Cycles counted from the start of the test, not of the isobar, shape (n,); live there is one run only."""
    assert inputs.cycle is not None and inputs.segment is not None
    if inputs.live is not None:
        return inputs.cycle
    begins = np.r_[True, (np.diff(inputs.cycle) != 0) | (np.diff(inputs.segment) != 0)]
    return np.cumsum(begins)


def acceleration(inputs: Inputs) -> Array:
    """Rate of the velocity in mm/s² within each stroke, 0 in a hold and where a stroke meets one, shape (n,).

    Along a record it is central, and one-sided at a turn, because each stroke is smoothed by itself; live it is that
    since the last instant, which is half a step behind.
    """
    assert inputs.velocity is not None and inputs.time is not None
    v, now, moving = inputs.velocity, inputs.time, slip(inputs)[0] != 0.0
    if inputs.live is not None:
        return _acceleration_live(inputs, inputs.live, v, now, moving)
    both = moving[1:] & moving[:-1]
    one_way = both & (np.diff(inputs.direction) == 0.0)
    if inputs.segment is not None:
        gap = np.diff(inputs.segment) != 0
        both, one_way = both & ~gap, one_way & ~gap
    before, behind = np.r_[False, one_way], np.r_[one_way, False]
    first, last = np.arange(len(v)) - before, np.arange(len(v)) + behind
    within = np.r_[False, both] & np.r_[both, False] & (first < last)
    return np.where(within, (v[last] - v[first]) / np.maximum(now[last] - now[first], 1e-9), 0.0)


def _acceleration_live(inputs: Inputs, live: Live, v: Array, now: Array, moving: Array) -> Array:
    xp, moves = inputs.xp, inputs.xp.where(moving, 1.0, 0.0)

    def advance(v_before: Array, time: Array, moved: Array, rate: Array) -> Slot:
        step = now - time
        later = moves * moved * (v - v_before) / xp.where(step > 0.0, step, 1.0)
        return v, now, moves, xp.where(step > 0.0, later, rate)

    return live.step((v, now, moves, xp.zeros_like(v)), advance)[3]


def in_first_stroke(inputs: Inputs, rested: bool = False) -> Array:
    """1 from the first motion on until its direction changes, else 0, shape (n,); `rested` in each segment anew."""
    way, moved = slip(inputs)[0], slip(inputs)[0] != 0.0
    if inputs.live is not None:
        xp = inputs.xp
        now = xp.where(xp.abs(way) > 0.5, xp.sign(way), 0.0)

        def advance(first: Array, gone: Array) -> Slot:
            begun = xp.where(first != 0.0, first, now)
            return begun, xp.maximum(gone, xp.where(now * begun < 0.0, 1.0, 0.0))

        first, gone = inputs.live.step((now, xp.zeros_like(now)), advance)
        return xp.abs(first) * (1.0 - gone)
    assert inputs.segment is not None
    found, new = np.zeros(len(inputs)), np.diff(inputs.segment) != 0
    for part in np.split(np.arange(len(inputs)), np.flatnonzero(new) + 1) if rested else [np.arange(len(inputs))]:
        begin = part[np.argmax(moved[part])]
        turned = np.flatnonzero(inputs.direction[begin : part[-1] + 1] != inputs.direction[begin])
        found[begin : begin + turned[0] if len(turned) else part[-1] + 1] = float(moved[begin])
    return found


def runs(inputs: Inputs) -> list[slice]:
    """Stretches of one direction within a segment, holds included, in order."""
    turns = np.diff(inputs.direction) != 0.0
    if inputs.segment is not None:
        turns |= np.diff(inputs.segment) != 0
    bounds = [0, *(np.flatnonzero(turns) + 1).tolist(), len(inputs)]
    return [slice(begin, end) for begin, end in itertools.pairwise(bounds)]


def way_since_reversal(inputs: Inputs) -> Array:
    """Millimetres from where the stroke began, which goes on through its holds, shape (n,)."""
    x = inputs.way_mm
    return np.concatenate([np.abs(x[part] - x[part.start]) for part in runs(inputs)])


def first_bend(values: Values) -> float:
    """How far a contact was bent at the first sample; not at all where nobody says."""
    return values.get("z_0", 0.0)


def on_the_way(inputs: Inputs, width_mm: float) -> float:
    """A travel in mm as the record's way counts it: nobody measures how far the braid of a locked muscle slides, so
    there it is one of STROKE_MM from end to end."""
    return width_mm * inputs.reach_mm / STROKE_MM if inputs.locked and inputs.live is None else width_mm


def stop_operator(
    inputs: Inputs, width_mm: float, rested: bool = False, least: Array | float = -1.0, begun: float = 0.0
) -> Array:
    """Deflection of an elastic element that slips at ±width, divided by the width, shape (n,), within ±1.

    Prandtl's stop operator driven by the displacement; it is `begun` at the first sample, `rested` in each segment
    anew. Below 0 it slips at `least`, a number or (n,), times the width.
    """
    if inputs.live is not None:
        return _moved_live(inputs.live, inputs, lambda z, dx: inputs.xp.clip(z + dx / width_mm, least, 1.0), begun)
    width_mm = on_the_way(inputs, width_mm)
    way = _one_way(inputs)
    states = []
    state = begun
    limits = np.broadcast_to(least, len(way.run))
    begin = np.flatnonzero(np.diff(way.run, prepend=-1))
    first, last = limits[begin].tolist(), limits[np.r_[begin[1:] - 1, len(way.run) - 1]].tolist()
    for (jump, length, begins), low, lower in zip(way.steps, first, last, strict=True):
        state = begun if rested and begins else min(max(state + jump / width_mm, low), 1.0)
        states.append(state)
        state = min(max(state + length / width_mm, lower), 1.0)
    return np.clip(np.array(states)[way.run] + way.travel / width_mm, least, 1.0)


def dahl_operator(inputs: Inputs, width_mm: float, begun: float = 0.0) -> Array:
    """Dahl's friction state, dz/dx = (1 − z sgn ẋ)/width: exponential return after each reversal, within ±1; it is
    `begun` at the first sample."""
    if inputs.live is not None:
        return lugre_operator(inputs, width_mm, 1.0, begun)
    width_mm = on_the_way(inputs, width_mm)
    way = _one_way(inputs)
    states = []
    state = begun

    def after(moved: float) -> float:
        goal = math.copysign(1.0, moved)
        return goal + (state - goal) * math.exp(-abs(moved) / width_mm)

    for jump, length, _ in way.steps:
        state = after(jump)
        states.append(state)
        state = after(length)
    goal = np.sign(way.travel)
    return goal + (np.array(states)[way.run] - goal) * np.exp(-np.abs(way.travel) / width_mm)


def lugre_operator(inputs: Inputs, width_mm: float, level: Array | float, begun: Array | float = 0.0) -> Array:
    """The same for a contact of the strength `level`, a number or (n,), at which it bends by width · level: in ± level.

    LuGre's friction (Canudas de Wit et al. 1995) without its rates, the level that of the sample to which it moves.
    """
    xp = inputs.xp

    def kept(dx: Array) -> Array:
        return xp.exp(-xp.abs(dx) / (width_mm * level))

    if inputs.live is not None:

        def move(z: Array, dx: Array) -> Array:
            goal = xp.sign(dx) * level
            return goal + (z - goal) * kept(dx)

        return _moved_live(inputs.live, inputs, move, begun)
    width_mm = on_the_way(inputs, width_mm)
    way = _one_way(inputs)
    moved = np.diff(way.travel, prepend=0.0)
    moved[np.flatnonzero(np.diff(way.run, prepend=-1))] = [jump for jump, *_ in way.steps]
    decay = kept(moved)
    gained = (1.0 - decay) * np.sign(moved) * level
    gained[0] += decay[0] * begun
    return decaying_sum(decay, gained)[1:]


@dataclass(frozen=True)
class _Way:
    """The path cut into one-way runs: `run` and signed `travel` (mm) since its first sample, shape (n,) each, and
    for each run the jump to its first sample and its whole length in mm, signed, and whether it begins a segment."""

    run: Array
    travel: Array
    steps: tuple[tuple[float, float, bool], ...]


@lru_cache(maxsize=8)
def _one_way(inputs: Inputs) -> _Way:
    x = inputs.way_mm
    travel, run, steps = np.empty(len(x)), np.empty(len(x), int), []
    last = x[0]
    segment = np.zeros(len(x)) if inputs.segment is None else inputs.segment
    for k, part in enumerate(runs(inputs)):
        sign = inputs.direction[part.start]
        travel[part] = sign * np.maximum.accumulate(np.maximum(sign * (x[part] - x[part.start]), 0.0))
        run[part] = k
        begins = bool(segment[part.start] != segment[max(part.start - 1, 0)])
        steps.append((float(x[part.start] - last), float(travel[part.stop - 1]), begins))
        last = x[part.stop - 1]
    return _Way(run, travel, tuple(steps))
