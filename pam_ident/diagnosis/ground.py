"""Where patterns are looked for: what sets of effects leave, with many atoms tried on it one by one."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from ..core import Inputs
from ..core.progress import tell
from ..effects import Effect, Form
from .dictionary import Atom, Slopes, atoms_at, closer, grid, same_around_any, signature
from .noise import Noise
from .search import Frame
from .trial import Trial, Verdict

Array = np.ndarray
TOGETHER = 1 << 20
"""Numbers in the columns that are made and whitened in one go: so many stay in the processor's cache."""
ENOUGH, FEW = 1500, 5
"""Samples that show where a pattern that matters is best, and how many such places are judged by all."""
Point = Mapping[str, float]


@dataclass(frozen=True)
class Lead:
    """The best atom of a pattern beyond a set: its gain in whitened squares, how many were tried, where to start."""

    onto: Verdict
    atom: Atom
    gain: float
    tried: int
    start: dict[str, float]


class Ground:
    """What a set leaves, whitened and free of what the set can follow."""

    def __init__(self, trial: Trial, onto: Verdict) -> None:
        self.onto, self.view = onto, trial.view(onto)
        frame = self.view.frame(trial.noise)
        self.precise = _Sight(self.view.record.inputs, self.view.around, frame.rows, trial.noise, 1e-10)
        self.rough = self.precise.rough()


@dataclass(frozen=True)
class _Sight:
    """What atoms are made and judged from; the `ridge`, as a share of an atom's squares, hides what rounding does."""

    inputs: Inputs
    around: Slopes
    frame: Array
    noise: Noise
    ridge: float

    def rough(self) -> "_Sight":
        """In single precision, all but the time, of which little may differ; of many samples by ENOUGH of them.

        These are drawn, lest a period be taken for another, and only where no noise connects the samples; the same
        for all grounds, because they share what is made of them.
        """
        inputs, around, frame, noise = self.inputs, self.around, self.frame, self.noise
        if len(inputs) > ENOUGH and not noise.coloured:
            rows = np.flatnonzero(np.random.default_rng(0).random(len(inputs)) * len(inputs) < ENOUGH)
            inputs, around, noise = inputs.take(rows), around.take(rows), noise.take(rows)
            frame = Frame(frame[:-1, rows].T, frame[-1, rows]).rows  # half a basis is none
        inputs = replace(_single(inputs), time=inputs.time)
        return _Sight(inputs, _single(around), frame.astype(np.float32), noise, 1e-4)


def _single(one: Any) -> Any:
    """The arrays of numbers in a dataclass in single precision."""
    arrays = {f.name: value for f in fields(one) if isinstance(value := getattr(one, f.name), np.ndarray)}
    return replace(one, **{name: value.astype(np.float32) for name, value in arrays.items() if value.dtype == float})


@dataclass(frozen=True)
class _Best:
    """A form at a point of its shapes with its sizes, and its gain."""

    gain: float
    form: Form
    point: Point
    sizes: Array


def scan(effect: Effect, grounds: Sequence[Ground]) -> list[Lead]:
    """On each ground the atom of an effect that explains most, its shapes zoomed in on twice.

    The grids are looked over in single precision, and what is best there is judged in double. What does not depend on
    the model is made and whitened once for all grounds, which share their noise.
    """
    found: list[_Best | None] = [None] * len(grounds)
    tried = 0
    for form in effect.forms:
        points = grid(form)
        tried += len(points)
        parts = [range(len(grounds))] if same_around_any(form) else [range(k, k + 1) for k in range(len(grounds))]
        for part in parts:
            for k, best in zip(part, _found(form, points, [grounds[k] for k in part]), strict=True):
                found[k] = _better(found[k], best)
    return [_zoom(effect, ground, best, tried) for ground, best in zip(grounds, found, strict=True) if best is not None]


def _zoom(effect: Effect, ground: Ground, best: _Best, tried: int) -> Lead:
    inputs, around = ground.view.record.inputs, ground.view.around
    atom = atoms_at(effect, best.form, [best.point], inputs, around)[0]
    for _ in range(2):
        points = closer(atom)
        if points:
            best = _better(best, _found(best.form, points, [ground])[0])
            atom = atoms_at(effect, best.form, [best.point], inputs, around)[0]
    start = dict(ground.onto.values) | {f"{effect.name}.{k}": v for k, v in best.point.items()}
    start |= {f"{effect.name}.{p.name}": p.clip(float(x)) for p, x in zip(atom.sizes, best.sizes, strict=True)}
    return Lead(ground.onto, atom, best.gain, tried, start)


def _better(one: "_Best | None", other: _Best) -> _Best:
    return other if one is None or other.gain > one.gain else one


def _found(form: Form, points: Sequence[Point], grounds: Sequence[Ground]) -> list[_Best]:
    """On each ground the best of some points: the FEW that look best are judged by all samples in double precision."""
    if len(points) <= FEW:
        return _best(form, points, grounds)
    gains: list[list[Array]] = [[] for _ in grounds]
    for _, k, found, _ in _tried(form, points, [ground.rough for ground in grounds]):
        gains[k].append(found)
    leading = [np.argsort(-np.concatenate(found))[:FEW] for found in gains]
    return [
        _best(form, [points[i] for i in places], [ground])[0] for places, ground in zip(leading, grounds, strict=True)
    ]


def _best(form: Form, points: Sequence[Point], grounds: Sequence[Ground]) -> list[_Best]:
    """On each ground the point of a form with the largest gain in whitened squares."""
    found: list[_Best | None] = [None] * len(grounds)
    for some, k, gains, sizes in _tried(form, points, [ground.precise for ground in grounds]):
        i = int(np.argmax(gains))
        found[k] = _better(found[k], _Best(float(gains[i]), form, some[i], sizes[i]))
    return [best for best in found if best is not None]


def _tried(
    form: Form, points: Sequence[Point], sights: Sequence[_Sight]
) -> Iterator[tuple[Sequence[Point], int, Array, Array]]:
    """Points in order, some at a time, with the number of a sight, and in it their gains (m,) and sizes (m, ·)."""
    noise, width = sights[0].noise, len(form.sizes)
    many = max(1, TOGETHER // (len(sights[0].inputs) * width))
    for begin in range(0, len(points), many):
        tell("looking for patterns")
        some = points[begin : begin + many]
        shapes: dict[str, Any] = {p.name: np.array([point[p.name] for point in some]) for p in form.shapes}
        matrix = noise.whiten(signature(form, sights[0].inputs, shapes, sights[0].around))
        own = _grams(matrix, width)
        size = np.trace(own, axis1=1, axis2=2)
        bad = ~np.isfinite(size)
        ridge = np.where(bad, 1.0, sights[0].ridge * size + 1e-300)
        for k, sight in enumerate(sights):
            seen = (sight.frame @ matrix).astype(float)
            gram, product = own - _grams(seen[:-1], width), seen[-1].reshape(width, -1).T
            gram[bad], product[bad] = 0.0, 0.0
            gram += ridge[:, None, None] * np.eye(width)
            sizes = np.linalg.solve(gram, product[:, :, None])[:, :, 0]
            yield some, k, np.sum(product * sizes, axis=1), sizes


def _grams(matrix: Array, width: int) -> Array:
    """Gram matrices (m, width, width) of the columns i, m + i, 2 m + i, … of a matrix (n, width · m)."""
    parts = matrix.reshape(len(matrix), width, matrix.shape[1] // width)
    found = np.empty((parts.shape[2], width, width))
    for i in range(width):
        for j in range(i + 1):
            found[:, i, j] = found[:, j, i] = np.einsum("nm,nm->m", parts[:, i], parts[:, j])
    return found
