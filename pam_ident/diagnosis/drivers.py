"""What a force may follow, and the states of each: no physics and no catalogue enter."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre

from ..core import Inputs
from ..effects._history import (
    acceleration,
    cycles_of_test,
    relax,
    since_begun,
    since_first,
    time_held,
    way_since_reversal,
    way_travelled,
)
from ..effects.base import slip

Array = np.ndarray


@dataclass(frozen=True)
class Driver:
    """What a force may follow: its word and words (`in_motion` where nothing rests, if they are others), and its states
    (n, k), None where the record does not hold it.

    States are times polynomials of pressure and contraction; `orders` are these two, from the simplest surface to the
    richest, and `some` says which of the states are taken together.
    """

    what: str
    text: str
    states: Callable[[Inputs], Array | None]
    some: tuple[tuple[int, ...], ...] = ((0,),)
    orders: tuple[tuple[int, int], ...] = ((0, 0), (1, 0), (0, 1), (0, 3), (1, 1), (2, 3))
    in_motion: str = ""


def polynomials(values: Array, most: int) -> Array:
    """Legendre polynomials of 0 … `most` over values (n,), fewer where few values are different, shape (n, orders)."""
    low, high = float(values.min()), float(values.max())
    order = min(most, len(np.unique(np.round((values - low) / max(high - low, 1e-12), 2))) - 1)
    return legendre.legvander((2.0 * values - low - high) / max(high - low, 1e-12), order)


def _direction(inputs: Inputs) -> Array | None:
    return np.column_stack(slip(inputs)) if inputs.has("branch") else None


def _speed(inputs: Inputs) -> Array | None:
    if inputs.velocity is None:
        return None
    return _rates(np.abs(inputs.velocity), slip(inputs)[0])


def _pressure_rate(inputs: Inputs) -> Array | None:
    if inputs.pressure_rate is None or inputs.locked:  # in a locked muscle it is the speed of the braid
        return None
    return _rates(np.abs(inputs.pressure_rate), np.sign(inputs.pressure_rate))


def _rates(size: Array, sign: Array) -> Array:
    """What grows with a rate of some size, by its sign, each (n,), and with the size alone, shape (n, 4)."""
    v = size / max(float(np.median(size[sign != 0.0])) if np.any(sign) else 1.0, 1e-9)
    return np.column_stack([v * sign, np.sqrt(v) * sign, np.log1p(10.0 * v) * sign, v])


def _acceleration(inputs: Inputs) -> Array | None:
    if inputs.velocity is None or inputs.time is None:
        return None
    rate = acceleration(inputs)
    return rate[:, None] / max(float(np.sqrt(np.mean(rate**2))), 1e-9)


def _way(inputs: Inputs) -> Array | None:
    if inputs.moving is None:
        return None
    way = way_since_reversal(inputs)
    share = way[:, None] / (max(float(way.max()), 1e-9) * np.array([0.02, 0.06, 0.18]))
    return np.exp(-share) * inputs.direction[:, None]


def _rest(inputs: Inputs) -> Array | None:
    if inputs.time is None or inputs.segment is None or inputs.moving is None:
        return None
    held = time_held(inputs, ~inputs.moving) * ~inputs.moving
    resting = [np.log1p(held / tau) * inputs.direction for tau in (0.3, 10.0)]
    longest = float(np.clip(0.1 * np.ptp(inputs.time), 2.0, 100.0))  # what takes longer is the clock's
    relaxed = [relax(inputs, inputs.way, float(tau)) for tau in np.geomspace(0.5, longest, 6)]
    since = since_begun(inputs.time, np.diff(inputs.segment, prepend=-1) != 0)
    pressed = [np.log1p(since / tau) for tau in (1.0, 10.0)]
    return np.column_stack(relaxed + resting + pressed)


def _cycle(inputs: Inputs) -> Array | None:
    if inputs.cycle is None:
        return None
    count, test = inputs.cycle - inputs.cycle.min(), np.zeros(len(inputs))
    if inputs.segment is not None:
        test = cycles_of_test(inputs) - 1.0
    if not count.any() and not test.any():
        return None
    way, on = (way_travelled(inputs, of_test) / max(inputs.reach_mm, 1e-9) for of_test in (False, True))
    counted, anew = float(count.any()), float((on != way).any())  # or they are constant, or the same again
    states = [counted * np.exp(-count), counted / (1.0 + count), np.log1p(way), np.exp(-way), np.exp(-0.25 * way)]
    if inputs.segment is not None:
        states += [np.exp(-0.5 * test), 1.0 / (1.0 + test), anew * np.exp(-on), anew * np.exp(-0.25 * on)]
    return np.column_stack(states)


def _clock(inputs: Inputs) -> Array | None:
    if inputs.time is None or np.ptp(inputs.time) <= 0.0:
        return None
    since = (inputs.time - inputs.time[0]) / np.ptp(inputs.time)
    settling = [np.exp(-since / tau) for tau in (0.01, 0.04, 0.15)]
    return np.column_stack([polynomials(inputs.time, 4)[:, 1:], *settling])


def _wanders(values: Array) -> bool:
    """Whether values (n,) are more than what a sensor reads of one that stays (von Neumann 1941)."""
    spread = float(np.var(values))
    return spread > 0.0 and float(np.mean(np.diff(values) ** 2)) < spread


def _temperature(inputs: Inputs) -> Array | None:
    if inputs.temperature is None or not _wanders(inputs.temperature):
        return None
    warmer = since_first(inputs, inputs.temperature)
    states = warmer[:, None] * polynomials(warmer, 2)
    if inputs.time is None or inputs.segment is None:
        return states
    lags = [warmer - relax(inputs, warmer, tau) for tau in BEHIND]
    return np.column_stack([states, *lags])


MAP = ((0, 0), (1, 0), (0, 1), (1, 2), (0, 5), (2, 2), (1, 4), (4, 2), (3, 4), (2, 7), (4, 7))
RATES = ((0,), (0, 1, 2), (0, 1, 2, 3))
ONE_OR_ALL = ((0,), (1,), (2,), (0, 1, 2))
COUNTED = (*((k,) for k in range(9)), (0, 1, 2), (2, 3, 4), (2, 5, 6), (7, 8), tuple(range(9)))
RELAXED = ((0, 2, 4), (1, 3, 5), (0, 1, 2, 3, 4, 5), (6, 7), (8, 9), (0, 1, 2, 3, 4, 5, 6, 7, 8, 9))
DRIFTED = ((0,), (0, 1), (0, 1, 2, 3), (0, 4, 5, 6), (0, 1, 2, 3, 4, 5, 6))
BEHIND = (10.0, 40.0, 160.0)
"""Times in s by which the wall may follow the sensor of its temperature."""
WARMED = ((0,), (0, 1, 2), (3,), (4,), (5,), (0, 3, 4, 5))
DRIVERS = (
    Driver("map", "pressure and contraction, alike on both branches", lambda i: np.ones((len(i), 1)), orders=MAP),
    Driver("direction", "the direction of motion", _direction, ((0,), (0, 1))),
    Driver("speed", "the speed", _speed, RATES),
    Driver("pressure_rate", "the rate of the pressure", _pressure_rate, RATES),
    Driver("acceleration", "the acceleration", _acceleration, orders=((0, 0),)),
    Driver("way", "the way since the last reversal", _way, ONE_OR_ALL),
    Driver("rest", "rest and relaxation", _rest, RELAXED, in_motion="relaxation"),
    Driver("cycle", "the cycle and the distance travelled", _cycle, COUNTED),
    Driver("clock", "the clock", _clock, DRIFTED, ((0, 0),)),
    Driver("temperature", "the temperature", _temperature, WARMED),
)
