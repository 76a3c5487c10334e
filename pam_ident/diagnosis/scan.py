"""Where patterns are looked for: what sets of effects leave, with many regressors tried on it one by one."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from ..core import Inputs
from ..core.progress import tell
from ..effects import Effect, Form
from .dictionary import Regressor, Slopes, closer, grid, regressors_at, same_around_any, signature
from .noise import Noise
from .search import Frame
from .selection import FittedSet, Selection

Array = np.ndarray
TOGETHER = 1 << 20
"""Numbers in the columns that are made and whitened in one go: so many stay in the processor's cache."""
ENOUGH, FEW = 1500, 5
"""Samples that show where a pattern that matters is best, and how many such places are judged by all."""
Point = Mapping[str, float]


@dataclass(frozen=True)
class Scanned:
    """The best regressor of a pattern beyond a set: its gain in squares, how many were tried, where to start."""

    onto: FittedSet
    regressor: Regressor
    gain: float
    tried: int
    start: dict[str, float]


class Remainder:
    """What a set leaves, whitened and free of what the set can follow."""

    def __init__(self, selection: Selection, onto: FittedSet) -> None:
        self.onto, self.view = onto, selection.view(onto)
        frame = self.view.frame(selection.noise)
        self.precise = _Samples(self.view.record.inputs, self.view.around, frame.rows, selection.noise, 1e-10)
        self.rough = self.precise.rough()


@dataclass(frozen=True)
class _Samples:
    """What regressors are made and judged from; the `ridge`, a share of a regressor's squares, hides rounding."""

    inputs: Inputs
    around: Slopes
    frame: Array
    noise: Noise
    ridge: float

    def rough(self) -> "_Samples":
        """In single precision, all but the time, of which little may differ; of many samples by ENOUGH of them.

        These are drawn, lest a period be taken for another, and only where no noise connects the samples; the same
        for all remainders, because they share what is made of them.
        """
        inputs, around, frame, noise = self.inputs, self.around, self.frame, self.noise
        if len(inputs) > ENOUGH and not noise.coloured:
            rows = np.flatnonzero(np.random.default_rng(0).random(len(inputs)) * len(inputs) < ENOUGH)
            inputs, around, noise = inputs.take(rows), around.take(rows), noise.take(rows)
            frame = Frame(frame[:-1, rows].T, frame[-1, rows]).rows  # half a basis is none
        inputs = replace(_single(inputs), time=inputs.time)
        return _Samples(inputs, _single(around), frame.astype(np.float32), noise, 1e-4)


def _single(one: Any) -> Any:
    """The arrays of numbers in a dataclass in single precision."""
    arrays = {f.name: value for f in fields(one) if isinstance(value := getattr(one, f.name), np.ndarray)}
    return replace(one, **{name: value.astype(np.float32) for name, value in arrays.items() if value.dtype == float})


@dataclass(frozen=True)
class _Best:
    """A form at a point of its nonlinear parameters with its coefficients, and its gain."""

    gain: float
    form: Form
    point: Point
    coefficients: Array


def scan(effect: Effect, remainders: Sequence[Remainder]) -> list[Scanned]:
    """On each remainder the regressor of an effect that explains most, its nonlinear parameters zoomed in on twice.

    The grids are looked over in single precision, and what is best there is judged in double. What does not depend on
    the model is made and whitened once for all remainders, which share their noise.
    """
    found: list[_Best | None] = [None] * len(remainders)
    tried = 0
    for form in effect.forms:
        points = grid(form, remainders[0].view.record.inputs)
        tried += len(points)
        parts = [range(len(remainders))] if same_around_any(form) else [range(k, k + 1) for k in range(len(remainders))]
        for part in parts:
            for k, best in zip(part, _found(form, points, [remainders[k] for k in part]), strict=True):
                found[k] = _better(found[k], best)
    return [
        _zoom(effect, remainder, best, tried)
        for remainder, best in zip(remainders, found, strict=True)
        if best is not None
    ]


def _zoom(effect: Effect, remainder: Remainder, best: _Best, tried: int) -> Scanned:
    inputs, around = remainder.view.record.inputs, remainder.view.around
    regressor = regressors_at(effect, best.form, [best.point], inputs, around)[0]
    for _ in range(2):
        points = closer(regressor, inputs)
        if points:
            best = _better(best, _found(best.form, points, [remainder])[0])
            regressor = regressors_at(effect, best.form, [best.point], inputs, around)[0]
    start = dict(remainder.onto.values) | {f"{effect.name}.{k}": v for k, v in best.point.items()}
    start |= {
        f"{effect.name}.{p.name}": p.clip(float(x)) for p, x in zip(regressor.linear, best.coefficients, strict=True)
    }
    return Scanned(remainder.onto, regressor, best.gain, tried, start)


def _better(one: "_Best | None", other: _Best) -> _Best:
    return other if one is None or other.gain > one.gain else one


def _found(form: Form, points: Sequence[Point], remainders: Sequence[Remainder]) -> list[_Best]:
    """On each remainder the best of some points: the FEW that look best are judged by all samples, precisely."""
    if len(points) <= FEW:
        return _best(form, points, remainders)
    gains: list[list[Array]] = [[] for _ in remainders]
    for _, k, found, _ in _tried(form, points, [remainder.rough for remainder in remainders]):
        gains[k].append(found)
    leading = [np.argsort(-np.concatenate(found))[:FEW] for found in gains]
    return [
        _best(form, [points[i] for i in places], [remainder])[0]
        for places, remainder in zip(leading, remainders, strict=True)
    ]


def _best(form: Form, points: Sequence[Point], remainders: Sequence[Remainder]) -> list[_Best]:
    """On each remainder the point of a form with the largest gain in whitened squares."""
    found: list[_Best | None] = [None] * len(remainders)
    for some, k, gains, coefficients in _tried(form, points, [remainder.precise for remainder in remainders]):
        i = int(np.argmax(gains))
        found[k] = _better(found[k], _Best(float(gains[i]), form, some[i], coefficients[i]))
    return [best for best in found if best is not None]


def _tried(
    form: Form, points: Sequence[Point], remainders: Sequence[_Samples]
) -> Iterator[tuple[Sequence[Point], int, Array, Array]]:
    """Points in order, some at a time, with the number of a remainder, gains (m,) and coefficients (m, ·) on it."""
    noise, width = remainders[0].noise, len(form.linear)
    many = max(1, TOGETHER // (len(remainders[0].inputs) * width))
    for begin in range(0, len(points), many):
        tell("looking for patterns")
        some = points[begin : begin + many]
        point: dict[str, Any] = {p.name: np.array([one[p.name] for one in some]) for p in form.nonlinear}
        matrix = noise.whiten(signature(form, remainders[0].inputs, point, remainders[0].around))
        own = _grams(matrix, width)
        size = np.trace(own, axis1=1, axis2=2)
        bad = ~np.isfinite(size)
        ridge = np.where(bad, 1.0, remainders[0].ridge * size + 1e-300)
        for k, samples in enumerate(remainders):
            seen = (samples.frame @ matrix).astype(float)
            gram, product = own - _grams(seen[:-1], width), seen[-1].reshape(width, -1).T
            gram[bad], product[bad] = 0.0, 0.0
            gram += ridge[:, None, None] * np.eye(width)
            coefficients = np.linalg.solve(gram, product[:, :, None])[:, :, 0]
            yield some, k, np.sum(product * coefficients, axis=1), coefficients


def _grams(matrix: Array, width: int) -> Array:
    """Gram matrices (m, width, width) of the columns i, m + i, 2 m + i, … of a matrix (n, width · m)."""
    parts = matrix.reshape(len(matrix), width, matrix.shape[1] // width)
    found = np.empty((parts.shape[2], width, width))
    for i in range(width):
        for j in range(i + 1):
            found[:, i, j] = found[:, j, i] = np.einsum("nm,nm->m", parts[:, i], parts[:, j])
    return found
