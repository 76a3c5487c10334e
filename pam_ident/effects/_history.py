"""Memory along a record: relaxation in time and elements that slip."""

from collections.abc import Callable

import numpy as np

from ..core import Inputs
from ..core.recursion import decaying_sum

Array = np.ndarray


def relax(inputs: Inputs, drive: Array, tau: float) -> Array:
    """Response q of a Maxwell element, q̇ = ḋ − q/τ, q = 0 at the first sample, shape of `drive` (n,).

    Exact for a drive that is linear between samples; between segments it jumps at once and then rests, as a
    rig does that goes to its next start and settles there.
    """
    assert inputs.time is not None and inputs.segment is not None
    decay = np.diff(inputs.time) / tau
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
    return [slice(begin, end) for begin, end in zip(bounds[:-1], bounds[1:], strict=True)]


def stop_operator(inputs: Inputs, width_mm: float) -> Array:
    """Deflection of an elastic element that slips at ±width, divided by the width, shape (n,), within ±1.

    Prandtl's stop operator driven by the displacement; the element starts at rest.
    """
    return _slide(inputs, lambda state, moved: np.clip(state + moved / width_mm, -1.0, 1.0))


def dahl_operator(inputs: Inputs, width_mm: float) -> Array:
    """Dahl's friction state, dz/dx = (1 − z sgn ẋ)/width: exponential return after each reversal, within ±1."""

    def step(state: float, moved: Array) -> Array:
        goal = np.sign(moved)
        return goal + (state - goal) * np.exp(-np.abs(moved) / width_mm)

    return _slide(inputs, step)


def _slide(inputs: Inputs, step: Callable[[float, Array], Array]) -> Array:
    """Carry a rate-independent state from reversal to reversal; `step(state, moved)` is exact for one-way travel."""
    x = inputs.displacement_mm
    out = np.empty(len(x))
    state, last = 0.0, x[0]
    for run in runs(inputs):
        sign = inputs.direction[run.start]
        state = float(step(state, np.array([x[run.start] - last]))[0])
        travel = np.maximum.accumulate(np.maximum(sign * (x[run] - x[run.start]), 0.0))
        out[run] = step(state, sign * travel)
        state, last = float(out[run.stop - 1]), x[run.stop - 1]
    return out
