"""Memory along a record: relaxation in time and elements that slip."""

import itertools
import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..core import Inputs
from ..core.recursion import decaying_sum

Array = np.ndarray


def relax(inputs: Inputs, drive: Array, tau: float | Array) -> Array:
    """Response q of a Maxwell element, q̇ = ḋ − q/τ, q = 0 at the first sample, shape of `drive` (n,).

    Exact for a drive that is linear between samples; between segments it jumps at once and then rests, as a
    rig does that goes to its next start and settles there. `tau` in s may differ from sample to sample, shape (n,).
    """
    assert inputs.time is not None and inputs.segment is not None
    decay = np.diff(inputs.time) / (0.5 * (tau[1:] + tau[:-1]) if isinstance(tau, np.ndarray) else tau)
    answer = np.where(decay > 1e-9, -np.expm1(-decay) / np.maximum(decay, 1e-300), 1.0)
    answer = np.where(np.diff(inputs.segment) != 0, np.exp(-decay), answer)
    gain = np.diff(drive) * answer
    return decaying_sum(np.exp(-decay), gain)


def runs(inputs: Inputs) -> list[slice]:
    """Stretches of one direction within a segment, holds included, in order."""
    turns = np.diff(inputs.direction) != 0.0
    if inputs.segment is not None:
        turns |= np.diff(inputs.segment) != 0
    bounds = [0, *(np.flatnonzero(turns) + 1).tolist(), len(inputs)]
    return [slice(begin, end) for begin, end in itertools.pairwise(bounds)]


def stop_operator(inputs: Inputs, width_mm: float) -> Array:
    """Deflection of an elastic element that slips at ±width, divided by the width, shape (n,), within ±1.

    Prandtl's stop operator driven by the displacement; the element starts at rest.
    """
    way = _one_way(inputs)
    states = []
    state = 0.0
    for jump, length in way.steps:
        state = min(max(state + jump / width_mm, -1.0), 1.0)
        states.append(state)
        state = min(max(state + length / width_mm, -1.0), 1.0)
    return np.clip(np.array(states)[way.run] + way.travel / width_mm, -1.0, 1.0)


def dahl_operator(inputs: Inputs, width_mm: float) -> Array:
    """Dahl's friction state, dz/dx = (1 − z sgn ẋ)/width: exponential return after each reversal, within ±1."""
    way = _one_way(inputs)
    states = []
    state = 0.0

    def after(moved: float) -> float:
        goal = math.copysign(1.0, moved)
        return goal + (state - goal) * math.exp(-abs(moved) / width_mm)

    for jump, length in way.steps:
        state = after(jump)
        states.append(state)
        state = after(length)
    goal = np.sign(way.travel)
    return goal + (np.array(states)[way.run] - goal) * np.exp(-np.abs(way.travel) / width_mm)


@dataclass(frozen=True)
class _Way:
    """The path cut into one-way runs: `run` and signed `travel` (mm) since its first sample, shape (n,) each, and
    for each run the jump to its first sample and its whole length in mm, signed."""

    run: Array
    travel: Array
    steps: tuple[tuple[float, float], ...]


@lru_cache(maxsize=8)
def _one_way(inputs: Inputs) -> _Way:
    x = inputs.displacement_mm
    travel, run, steps = np.empty(len(x)), np.empty(len(x), int), []
    last = x[0]
    for k, part in enumerate(runs(inputs)):
        sign = inputs.direction[part.start]
        travel[part] = sign * np.maximum.accumulate(np.maximum(sign * (x[part] - x[part.start]), 0.0))
        run[part] = k
        steps.append((float(x[part.start] - last), float(travel[part.stop - 1])))
        last = x[part.stop - 1]
    return _Way(run, travel, tuple(steps))
