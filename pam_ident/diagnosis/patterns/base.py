"""What a pattern is, and what several of them are made of.

Columns of a pattern take arrays (m,) of values, too, and are then (n, k m) of k linear parameters, all of the first one
first; where the contraction is given in single precision, so are they.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ...core import Inputs, Param
from ...effects import Effect, Form
from ...effects.base import Array, Values

BLURRED = 6.0
"""Standard deviations of the position's error within which a shape over displacement is the sensor's: rows that rest at
one place are seen beside it, each with the force that its own error makes."""
FAR = 8.0
"""Standard deviations at which a bell's tail stays what it is, 1e-14."""
SINCE = 0.02
"""Share of the record that must lie before a moment, and after it."""
SINCE_REVERSAL = "the way since a reversal"
"""A coordinate that a table has not, nor a test at few lengths."""
SIZE = Param("amplitude", "N", "amplitude", scale=10.0)
GAIN = Param("gain", "1", "change of the force's scale", -0.9, 2.0, scale=0.01)
ZERO = Param("zero", "MPa", "shift of the pressure", -0.3, 0.3, scale=0.002)
WAVE = (Param("cosine", "N", "cosine part", scale=10.0), Param("sine", "N", "sine part", scale=10.0))


@dataclass(frozen=True)
class Extent:
    """What a record covers: displacement from `low` over `stroke` (mm), time from `first`, the first motion, over
    `duration` (s, 0 without time), the periods in s, `beats`, that a spectrum of what is left shows, and below how many
    mm the position is `blurred`."""

    inputs: Inputs
    low: float
    stroke: float
    first: float
    duration: float
    beats: tuple[float, ...] = ()
    blurred: float = 0.0

    @classmethod
    def of(cls, inputs: Inputs, beats: tuple[float, ...] = (), error_mm: float = 0.0) -> "Extent":
        """The span of a record's inputs, whose position has an error."""
        x, time = inputs.displacement_mm, inputs.time
        first, duration = 0.0, 0.0
        if time is not None:
            moves = 0 if inputs.moving is None else int(np.argmax(inputs.moving))  # what is before is not looked at
            first, duration = float(time[moves]), max(float(time[-1] - time[moves]), 1e-9)
        stroke = max(float(np.ptp(x)), 1e-9)
        return cls(inputs, float(x.min()), stroke, first, duration, beats, min(BLURRED * error_mm, 0.25 * stroke))

    def place(self, count: int = 40) -> Param:
        """Somewhere along the stroke but for its blurred ends, looked for at so many places.

        The ends themselves lie half as far within the outermost readings, where the sensor errs most.
        """
        low, span = self.low + 1.5 * self.blurred, self.stroke - 3.0 * self.blurred
        return Param("place", "mm", "where", low, low + span, low + span / 2, grid=steps(low, span, count))

    def moment(self, count: int = 150) -> Param:
        """Some time of the record, looked for at so many moments; not so near its ends that it could be an offset."""
        begin, span = self.first + SINCE * self.duration, (1.0 - 2.0 * SINCE) * self.duration
        return Param("moment", "s", "when", begin, begin + span, begin + span / 2, grid=steps(begin, span, count))


@dataclass(frozen=True)
class PatternShape:
    """A pattern: its `name`, the `kind` and `coordinate` it has in an answer, its forms over a record's span, and
    `words`, which describes it by its values and the coordinate; `elsewhere` has the coordinate of forms along another.
    """

    name: str
    title: str
    kind: str
    coordinate: str
    forms: Callable[[Extent], Sequence[Form]]
    words: Callable[[Mapping[str, float], str], str]
    elsewhere: Mapping[str, str] = field(default_factory=dict)

    def along(self, form: Form) -> str:
        """The coordinate of a form."""
        return self.elsewhere.get(form.name, self.coordinate)

    def in_forms(self, forms: tuple[Form, ...]) -> Effect:
        """It in some of its forms, to be fitted like an effect."""
        return Effect(self.name, self.title, "a description, not a physical effect", forms, test="", candidate=False)


def steps(low: float, span: float, count: int) -> tuple[float, ...]:
    """The middles of so many equal parts."""
    return tuple(float(v) for v in low + span * (np.arange(count) + 0.5) / count)


def searched(name: str, unit: str, doc: str, grid: Iterable[float]) -> Param:
    """A parameter that is looked for from a grid, with bounds a little beyond its ends."""
    values = tuple(map(float, grid))
    return Param(name, unit, doc, min(values) * 0.8, max(values) * 1.25, start=values[0], grid=values)


def knots(count: int) -> tuple[Param, ...]:
    """Sizes of a free curve."""
    return tuple(Param(f"knot_{k}", "N", "free curve", scale=10.0) for k in range(count))


def hats(values: Array, count: int) -> Array:
    """Straight lines between `count` even knots over values (n,), shape (n, count)."""
    at = np.linspace(values.min(), values.max(), count)
    return np.maximum(0.0, 1.0 - np.abs(values[:, None] - at) / max(at[1] - at[0], 1e-12))


def like(inputs: Inputs, values: Array | float) -> Array:
    """Values of any shape in the precision of the inputs."""
    return np.asarray(values, inputs.contraction.dtype)


def bell(away: Array) -> Array:
    """Gaussian at so many standard deviations, of any shape; its tail ends before squares lose digits, which is
    slow."""
    return np.exp(-0.5 * np.minimum(away * away, FAR**2))


def after(inputs: Inputs, values: Values) -> Array:
    """1 from a moment on, before it 0, shape (n, m)."""
    assert inputs.time is not None
    return like(inputs, inputs.time[:, None] >= values["moment"])


def wave(along: Array, period: Array | float) -> Array:
    """Cosine and sine of 2π along/period, along (n,): (n, 2), or (n, 2 m) of m periods, cosines first.

    Of wave numbers in even steps few are turned, by the angles of a coarse and of a fine step, into all others.
    """
    numbers = 1.0 / np.atleast_1d(period)
    even = len(numbers) > 8 and np.ptp(np.diff(numbers)) < 1e-9 * np.max(np.abs(np.diff(numbers)))
    numbers = numbers.astype(along.dtype)
    turn, m = 2.0 * np.pi * along[:, None], len(numbers)
    found = np.empty((len(along), 2, m), along.dtype)
    if even:
        fine = math.isqrt(m)
        coarse = _circle(turn * numbers[::fine])[:, :, None]
        waves = (coarse * _circle(turn * (numbers[:fine] - numbers[0]))[:, None, :]).reshape(len(along), -1)[:, :m]
        found[:, 0], found[:, 1] = np.real(waves), np.imag(waves)
    else:
        phase = turn * numbers
        np.cos(phase, out=found[:, 0])
        np.sin(phase, out=found[:, 1])
    return found.reshape(len(along), -1)


def _circle(angle: Array) -> Array:
    return np.cos(angle) + 1j * np.sin(angle)
