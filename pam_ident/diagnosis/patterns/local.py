"""A force in one place of the stroke, or in two."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from ...core import Inputs, Param
from ...core.digits import number
from ...effects import AddsForce, Form
from ...effects.base import Array, Values, slip
from .base import SIZE, Extent, PatternShape, bell, like

PLACES = 16
"""Places from which each of two is sought."""
WIDEST = 0.15
"""Half width up to which a force is in one place, as a share of the stroke: what is wider is as smooth as a surface."""
AGAINST = Param("against", "N", "amplitude against motion", scale=10.0)
AGAIN = Param("again", "N", "amplitude in the other place", scale=10.0)
POWER = Param("power", "1", "power at which it grows", 0.7, 3.0, start=1.0, grid=(1.0, 1.5, 2.2))


def _beyond(inputs: Inputs, values: Values) -> Array:
    """Millimetres beyond the places, shape (n, m)."""
    return inputs.displacement_mm[:, None] - like(inputs, values["place"])


def _bump(inputs: Inputs, values: Values, force: Array) -> Array:
    return bell(_beyond(inputs, values) / like(inputs, values["width"]))


def _odd_bump(inputs: Inputs, values: Values, force: Array) -> Array:
    return -_bump(inputs, values, force) * slip(inputs)[0][:, None]


def _one_way_bump(inputs: Inputs, values: Values, force: Array) -> Array:
    """Of either size on either branch; on one branch alone where the two coefficients are alike."""
    return np.hstack([_bump(inputs, values, force), _odd_bump(inputs, values, force)])


def _pressed_bump(inputs: Inputs, values: Values, force: Array) -> Array:
    pressed = inputs.pressure / max(float(np.max(inputs.pressure)), 1e-9)
    return _bump(inputs, values, force) * pressed[:, None]


def _pressed_odd_bump(inputs: Inputs, values: Values, force: Array) -> Array:
    return -_pressed_bump(inputs, values, force) * slip(inputs)[0][:, None]


def _two_bumps(inputs: Inputs, values: Values, force: Array) -> Array:
    other = {**values, "place": values["second"]}
    return np.hstack([_bump(inputs, values, force), _bump(inputs, other, force)])


def _box(inputs: Inputs, values: Values, force: Array, soft: float = 0.0) -> Array:
    """Constant within the width; soft edges, a fifth of it wide or more, let place and width be searched."""
    off, width = np.abs(_beyond(inputs, values)), like(inputs, values["width"])
    return 0.5 - 0.5 * np.tanh((off - width) / np.maximum(0.2 * width, like(inputs, soft)))


def _odd_box(inputs: Inputs, values: Values, force: Array, soft: float = 0.0) -> Array:
    return -_box(inputs, values, force, soft) * slip(inputs)[0][:, None]


def _stop(inputs: Inputs, values: Values, force: Array) -> Array:
    return np.maximum(_beyond(inputs, values), 0.0) ** like(inputs, values["power"])


def _edge(inputs: Inputs, values: Values, force: Array, soft: float = 0.0) -> Array:
    """From nothing to constant, soft by a hundredth of the stroke or more so that the place can be searched."""
    soft = max(0.01 * float(np.ptp(inputs.displacement_mm)), soft, 1e-9)
    return 0.5 + 0.5 * np.tanh(_beyond(inputs, values) / like(inputs, soft))


def _forms(span: Extent) -> Sequence[Form]:
    stroke, place, first = span.stroke, span.place(), span.place(PLACES)
    least = max(0.005 * stroke, 0.5 * span.blurred)
    widths = tuple(least + stroke * w for w in (0.01, 0.03, 0.075))
    width = Param("width", "mm", "half width", least, least + WIDEST * stroke, start=widths[1], grid=widths)
    second = replace(first, name="second", doc="where else")
    wide = replace(width, grid=tuple(least + stroke * w for w in (0.045, 0.095)))
    at, soft = (place, width), 0.5 * span.blurred
    return (
        AddsForce("even", "bump", (SIZE,), _bump, at),
        AddsForce("odd", "bump against motion", (SIZE,), _odd_bump, at),
        AddsForce("one_way", "bump that differs by branch", (SIZE, AGAINST), _one_way_bump, at),
        AddsForce("pressed", "bump in proportion to pressure", (SIZE,), _pressed_bump, at),
        AddsForce("pressed_odd", "bump against motion, in proportion to pressure", (SIZE,), _pressed_odd_bump, at),
        AddsForce("two_places", "bumps in two places", (SIZE, AGAIN), _two_bumps, (first, second, wide)),
        AddsForce("box", "step up and down", (SIZE,), partial(_box, soft=soft), at),
        AddsForce("odd_box", "step up and down against motion", (SIZE,), partial(_odd_box, soft=soft), at),
        AddsForce("stop", "force that grows beyond a place", (SIZE,), _stop, (place, POWER)),
        AddsForce("edge", "force that sets in at a place", (SIZE,), partial(_edge, soft=soft), (place,)),
    )


def _words(at: Mapping[str, float], along: str) -> str:
    places = [f"{number(at[key], 3)}" for key in ("place", "second") if key in at]
    return f"a force in {'two places' if places[1:] else 'one place'}, around {' and '.join(places)} mm of contraction"


PATTERN = PatternShape("local", "local force", "local", "displacement", _forms, _words)
