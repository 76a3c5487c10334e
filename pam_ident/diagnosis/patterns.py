"""Shapes that no known effect has: a ripple, a rub in one place, a step in time, a trend, a free curve.

They are written as effects so that they are fitted and priced like the suspects, but they carry no physics and are
never selected by name: they describe what is left. Their columns take arrays (m,) of shapes, too, and are then (n, k m)
of k sizes, all of the first size first; where the contraction is given in single precision, so are they.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..core import Inputs, Param
from ..effects import AddsForce, Effect, Form, ScalesForce, TransformsContraction, TransformsPressure
from ..effects.base import Array, Shape, slip

SOURCE = "a description, not a physical effect"
LENGTHS = 30
FAR = 8.0
"""Standard deviations at which a bell's tail stays what it is, 1e-14."""
PLACES = 16
"""Places from which each of two is sought."""
OVER_PRESSURE, PRESSURE_KNOTS = "over_pressure", 5
SIZE = Param("amplitude", "N", "amplitude", scale=10.0)
AGAINST = Param("against", "N", "amplitude against motion", scale=10.0)
AGAIN = Param("again", "N", "amplitude in the other place", scale=10.0)
LATER = Param("later", "N", "size of the second", scale=10.0)
POWER = Param("power", "1", "power at which it grows", 0.7, 3.0, start=1.0, grid=(1.0, 1.5, 2.2))
COS = Param("cosine", "N", "cosine part", scale=10.0)
SIN = Param("sine", "N", "sine part", scale=10.0)
WAVE = (COS, SIN)
GAIN = Param("gain", "1", "change of the force's scale", -0.9, 2.0, scale=0.01)
SHIFT = Param("shift", "mm", "shift of the length", -20.0, 20.0, scale=0.1)
STRETCH = Param("stretch", "mm", "shift of the length by the end", -20.0, 20.0, scale=0.1)
ZERO = Param("zero", "MPa", "shift of the pressure", -0.3, 0.3, scale=0.002)
SENSE = Param("sense", "1", "change of the pressure's scale by the end", -0.5, 0.5, scale=0.01)
PRESSURE_WAVE = (
    Param("cosine", "MPa", "cosine part", -0.5, 0.5, scale=0.01),
    Param("sine", "MPa", "sine part", -0.5, 0.5, scale=0.01),
)


def _wave(along: Array, period: Array | float) -> Array:
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
        wave = (coarse * _circle(turn * (numbers[:fine] - numbers[0]))[:, None, :]).reshape(len(along), -1)[:, :m]
        found[:, 0], found[:, 1] = np.real(wave), np.imag(wave)
    else:
        phase = turn * numbers
        np.cos(phase, out=found[:, 0])
        np.sin(phase, out=found[:, 1])
    return found.reshape(len(along), -1)


def _like(inputs: Inputs, values: Array | float) -> Array:
    """Values in the precision of the inputs."""
    return np.asarray(values, inputs.contraction.dtype)


def _beyond(inputs: Inputs, shape: Shape) -> Array:
    """Millimetres beyond the places, shape (n, m)."""
    return inputs.displacement_mm[:, None] - _like(inputs, shape["place"])


def _bell(away: Array) -> Array:
    """Gaussian at so many standard deviations; its tail ends before squares lose digits, which is slow."""
    return np.exp(-0.5 * np.minimum(away * away, FAR**2))


def _circle(angle: Array) -> Array:
    return np.cos(angle) + 1j * np.sin(angle)


def _ripple(inputs: Inputs, shape: Shape, force: Array) -> Array:
    return _wave(inputs.displacement_mm, shape["period"])


def _loaded_ripple(inputs: Inputs, shape: Shape, force: Array) -> Array:
    return _ripple(inputs, shape, force) * (force / max(float(np.mean(np.abs(force))), 1e-9))[:, None]


def _odd_ripple(inputs: Inputs, shape: Shape, force: Array) -> Array:
    return _ripple(inputs, shape, force) * slip(inputs)[0][:, None]


def _beat(inputs: Inputs, shape: Shape, force: Array) -> Array:
    assert inputs.time is not None
    return _wave((inputs.time - inputs.time[0]).astype(inputs.contraction.dtype), shape["period"])


def _even_bump(inputs: Inputs, shape: Shape, force: Array) -> Array:
    return _bell(_beyond(inputs, shape) / _like(inputs, shape["width"]))


def _odd_bump(inputs: Inputs, shape: Shape, force: Array) -> Array:
    return -_even_bump(inputs, shape, force) * slip(inputs)[0][:, None]


def _one_way_bump(inputs: Inputs, shape: Shape, force: Array) -> Array:
    """Of either size on either branch; on one branch alone where the two sizes are alike."""
    return np.hstack([_even_bump(inputs, shape, force), _odd_bump(inputs, shape, force)])


def _pressed_bump(inputs: Inputs, shape: Shape, force: Array) -> Array:
    pressed = inputs.pressure / max(float(np.max(inputs.pressure)), 1e-9)
    return _even_bump(inputs, shape, force) * pressed[:, None]


def _pressed_odd_bump(inputs: Inputs, shape: Shape, force: Array) -> Array:
    return -_pressed_bump(inputs, shape, force) * slip(inputs)[0][:, None]


def _two_bumps(inputs: Inputs, shape: Shape, force: Array) -> Array:
    other = {**shape, "place": shape["second"]}
    return np.hstack([_even_bump(inputs, shape, force), _even_bump(inputs, other, force)])


def _box(inputs: Inputs, shape: Shape, force: Array) -> Array:
    """Constant within the width, with soft edges a fifth of it wide, so that place and width can be searched."""
    off, width = np.abs(_beyond(inputs, shape)), _like(inputs, shape["width"])
    return 0.5 - 0.5 * np.tanh((off - width) / (0.2 * width))


def _odd_box(inputs: Inputs, shape: Shape, force: Array) -> Array:
    return -_box(inputs, shape, force) * slip(inputs)[0][:, None]


def _stop(inputs: Inputs, shape: Shape, force: Array) -> Array:
    return np.maximum(_beyond(inputs, shape), 0.0) ** _like(inputs, shape["power"])


def _edge(inputs: Inputs, shape: Shape, force: Array) -> Array:
    """From nothing to constant, soft by a hundredth of the stroke so that the place can be searched."""
    soft = _like(inputs, max(0.01 * float(np.ptp(inputs.displacement_mm)), 1e-9))
    return 0.5 + 0.5 * np.tanh(_beyond(inputs, shape) / soft)


def _force_step(inputs: Inputs, shape: Shape, force: Array) -> Array:
    assert inputs.time is not None
    return _like(inputs, inputs.time[:, None] >= shape["moment"])


def _two_steps(inputs: Inputs, shape: Shape, force: Array) -> Array:
    second = {"moment": shape["moment"] + shape["length"]}
    return np.hstack([_force_step(inputs, shape, force), _force_step(inputs, second, force)])


def _burst(inputs: Inputs, shape: Shape, force: Array) -> Array:
    assert inputs.time is not None
    return _bell(_like(inputs, (inputs.time[:, None] - np.asarray(shape["moment"])) / np.asarray(shape["length"])))


def _length_step(inputs: Inputs, shape: Shape, force: Array) -> Array:
    return _force_step(inputs, shape, force) / inputs.specimen.initial_length_mm


def _hats(values: Array, knots: int) -> Array:
    at = np.linspace(values.min(), values.max(), knots)
    return np.maximum(0.0, 1.0 - np.abs(values[:, None] - at) / max(at[1] - at[0], 1e-12))


def _passed(inputs: Inputs) -> Array:
    """Share of the record's time that has passed, shape (n, 1)."""
    assert inputs.time is not None
    passed = inputs.time - inputs.time[0]
    return _like(inputs, passed / max(float(passed[-1]), 1e-9))[:, None]


def _length_trend(inputs: Inputs, shape: Shape, force: Array) -> Array:
    return _passed(inputs) / inputs.specimen.initial_length_mm


def _pressure_trend(inputs: Inputs, shape: Shape, force: Array) -> Array:
    return _passed(inputs) * inputs.pressure[:, None]


def _even_trend(inputs: Inputs, shape: Shape, force: Array) -> Array:
    return _passed(inputs)


def _stiffness_trend(inputs: Inputs, shape: Shape, force: Array) -> Array:
    return _passed(inputs) * inputs.contraction[:, None]


def _time_curve(inputs: Inputs, shape: Shape, force: Array) -> Array:
    assert inputs.time is not None
    return _hats(inputs.time, 8)[:, 1:]


def _even_curve(inputs: Inputs, shape: Shape, force: Array) -> Array:
    return _hats(inputs.contraction, 9)


def _odd_curve(inputs: Inputs, shape: Shape, force: Array) -> Array:
    return -_hats(inputs.contraction, 9) * slip(inputs)[0][:, None]


def _pressed_curve(inputs: Inputs, shape: Shape, force: Array) -> Array:
    return _hats(inputs.contraction, 9) * inputs.pressure[:, None]


def _over_pressure(inputs: Inputs, shape: Shape, force: Array) -> Array:
    return _hats(inputs.pressure, PRESSURE_KNOTS)[:, 1:]


def _sizes(count: int) -> tuple[Param, ...]:
    return tuple(Param(f"knot_{k}", "N", "free curve", scale=10.0) for k in range(count))


def patterns(inputs: Inputs, beats: Sequence[float] = ()) -> tuple[Effect, ...]:
    """The patterns that a record of these inputs can show, with grids as fine as its stroke and duration ask.

    `beats` are periods in s that a spectrum shows, tried beside the slow ones. A table of few lengths shows no pattern:
    any curve over contraction passes through its lengths.
    """
    x = inputs.displacement_mm
    if len(np.unique(np.round(x, 3))) < LENGTHS:
        return ()
    low, stroke = float(x.min()), max(float(np.ptp(x)), 1e-9)
    wave_numbers = np.arange(1.0, max(2.0, stroke / 1.0), 0.25)[::-1]
    periods = tuple(float(stroke / k) for k in wave_numbers if stroke / k < 0.5 * stroke)
    period = _span("period", "mm", "period over displacement", periods or (0.25 * stroke,))
    place = Param("place", "mm", "where", low, low + stroke, start=low + stroke / 2, grid=_steps(low, stroke, 40))
    width = Param(
        "width",
        "mm",
        "half width",
        stroke * 0.005,
        stroke,
        start=stroke * 0.05,
        grid=tuple(stroke * w for w in (0.015, 0.035, 0.08)),
    )
    first = replace(place, grid=_steps(low, stroke, PLACES))
    second = replace(first, name="second", doc="where else")
    wide = replace(width, grid=tuple(stroke * w for w in (0.05, 0.1)))
    over_pressure = AddsForce(OVER_PRESSURE, "free curve over pressure", _sizes(PRESSURE_KNOTS - 1), _over_pressure)
    found = [
        _pattern(
            "local",
            "local force",
            ("contraction",),
            [
                AddsForce("even", "bump", (SIZE,), _even_bump, (place, width)),
                AddsForce("odd", "bump against motion", (SIZE,), _odd_bump, (place, width)),
                AddsForce("one_way", "bump that differs by branch", (SIZE, AGAINST), _one_way_bump, (place, width)),
                AddsForce("pressed", "bump in proportion to pressure", (SIZE,), _pressed_bump, (place, width)),
                AddsForce(
                    "pressed_odd",
                    "bump against motion, in proportion to pressure",
                    (SIZE,),
                    _pressed_odd_bump,
                    (place, width),
                ),
                AddsForce("two_places", "bumps in two places", (SIZE, AGAIN), _two_bumps, (first, second, wide)),
                AddsForce("box", "step up and down", (SIZE,), _box, (place, width)),
                AddsForce("odd_box", "step up and down against motion", (SIZE,), _odd_box, (place, width)),
                AddsForce("stop", "force that grows beyond a place", (SIZE,), _stop, (place, POWER)),
                AddsForce("edge", "force that sets in at a place", (SIZE,), _edge, (place,)),
            ],
        ),
        _pattern(
            "periodic",
            "ripple over displacement",
            ("contraction",),
            [
                AddsForce("even", "ripple", WAVE, _ripple, (period,)),
                AddsForce("loaded", "ripple in proportion to force", WAVE, _loaded_ripple, (period,), uses_force=True),
                AddsForce("odd", "ripple against motion", WAVE, _odd_ripple, (period,)),
            ],
        ),
        _pattern(
            "other",
            "free curve over contraction",
            ("contraction",),
            [
                AddsForce("even", "free curve", _sizes(9), _even_curve),
                AddsForce("odd", "free curve against motion", _sizes(9), _odd_curve),
                AddsForce("pressed", "free curve in proportion to pressure", _sizes(9), _pressed_curve),
                *([over_pressure] if len(np.unique(np.round(inputs.pressure, 2))) >= PRESSURE_KNOTS else []),
            ],
        ),
    ]
    if inputs.time is not None:
        first, duration = float(inputs.time[0]), max(float(np.ptp(inputs.time)), 1e-9)
        moment = Param(
            "moment",
            "s",
            "when",
            first,
            first + duration,
            start=first + duration / 2,
            grid=_steps(first, duration, 150),
        )
        early = replace(moment, grid=_steps(first, duration, 75))
        length = Param("length", "s", "how long", 0.0, duration, start=duration / 8, grid=_steps(0.0, duration / 2, 12))
        lasting = _span("length", "s", "how long", tuple(duration * w for w in (0.08, 0.03, 0.012)))
        slow = _span("period", "s", "period in time", tuple(duration / np.arange(3.0, 400.0, 0.4)))
        beating: list[Form] = [AddsForce("even", "beat", WAVE, _beat, (slow,))]
        if beats:
            seen = _span("period", "s", "period in time", tuple(sorted(beats, reverse=True)))
            beating += [
                AddsForce("seen", "beat", WAVE, _beat, (seen,)),
                TransformsPressure("pressure", "beat of the pressure", PRESSURE_WAVE, _beat, (seen,)),
            ]
        found += [
            _pattern(
                "step",
                "step in time",
                ("time",),
                [
                    AddsForce("force", "step of the force", (SIZE,), _force_step, (moment,)),
                    AddsForce("two", "two steps of the force", (SIZE, LATER), _two_steps, (early, length)),
                    ScalesForce("gain", "step of the force's scale", (GAIN,), _force_step, (moment,)),
                    TransformsContraction("length", "step of the length", (SHIFT,), _length_step, (moment,)),
                    TransformsPressure("pressure", "step of the pressure", (ZERO,), _force_step, (moment,)),
                ],
            ),
            _pattern(
                "burst",
                "force for a while",
                ("time",),
                [AddsForce("bell", "bell over time", (SIZE,), _burst, (moment, lasting))],
            ),
            _pattern("beat", "beat in time", ("time",), beating),
            _pattern(
                "trend",
                "trend in time",
                ("time",),
                [
                    AddsForce("even", "free curve", _sizes(7), _time_curve),
                    ScalesForce("gain", "trend of the force's scale", (GAIN,), _even_trend),
                    AddsForce("stiffness", "trend of the stiffness", (SIZE,), _stiffness_trend),
                    TransformsContraction("length", "trend of the length", (STRETCH,), _length_trend),
                    TransformsPressure("pressure", "trend of the pressure's scale", (SENSE,), _pressure_trend),
                    TransformsPressure("zero", "trend of the pressure's zero", (ZERO,), _even_trend),
                ],
            ),
        ]
    return tuple(found)


def _steps(low: float, span: float, count: int) -> tuple[float, ...]:
    return tuple(float(v) for v in low + span * (np.arange(count) + 0.5) / count)


def _span(name: str, unit: str, doc: str, grid: tuple[float, ...]) -> Param:
    return Param(name, unit, doc, min(grid) * 0.8, max(grid) * 1.25, start=grid[0], grid=tuple(map(float, grid)))


def _pattern(name: str, title: str, coordinate: tuple[str, ...], forms: list[Form]) -> Effect:
    return Effect(
        name, title, SOURCE, tuple(forms), test="", needs=tuple(c for c in coordinate if c == "time"), candidate=False
    )


KINDS = {"beat": "periodic", "burst": "local"}
"""Pattern names whose kind in the answer is another word."""
