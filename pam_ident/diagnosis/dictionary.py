"""Every suspect's signature: how the force would change if a little of the effect were there."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from ..core import Inputs, Param
from ..effects import AddsForce, Effect, Form, ScalesForce, TransformsPressure
from ..model import Model, Term

Array = np.ndarray


@dataclass(frozen=True)
class Atom:
    """One effect in one form at fixed shapes: `columns` (n, sizes) in N per unit of size, around a fitted model."""

    effect: str
    term: Term
    shapes: dict[str, float]
    columns: Array
    sizes: tuple[Param, ...]

    @property
    def free(self) -> int:
        """Parameters it adds to a model."""
        return len(self.sizes) + len(self.shapes)


@dataclass(frozen=True)
class Slopes:
    """Force of a fitted model in N and its slopes over contraction ratio and pressure (MPa), shape (n,) each."""

    force: Array
    contraction: Array
    pressure: Array

    def take(self, rows: Array) -> "Slopes":
        """Those at some samples, by index (m,)."""
        return Slopes(self.force[rows], self.contraction[rows], self.pressure[rows])


def slopes(model: Model, inputs: Inputs, values: Mapping[str, float]) -> Slopes:
    """By central differences; histories are left as they are, for the shift is the same at every sample."""
    dc, dp = 1e-5, 1e-5
    force = model.force(inputs, values)

    def moved(**change: Array) -> Array:
        return model.force(replace(inputs, **change), values)

    over_c = moved(contraction=inputs.contraction + dc) - moved(contraction=inputs.contraction - dc)
    over_p = moved(pressure=inputs.pressure + dp) - moved(pressure=inputs.pressure - dp)
    return Slopes(force, over_c / (2 * dc), over_p / (2 * dp))


def atoms_at(
    effect: Effect, form: Form, points: Iterable[Mapping[str, float]], inputs: Inputs, around: Slopes
) -> list[Atom]:
    """One form at some values of its shapes; points where it is not finite are left out."""
    found = []
    for shapes in points:
        columns = signature(form, inputs, shapes, around)
        if np.all(np.isfinite(columns)):
            found.append(Atom(effect.name, Term(effect, form), dict(shapes), columns, form.sizes))
    return found


def closer(atom: Atom, points: int = 41) -> list[dict[str, float]]:
    """Shapes around an atom's own, one shape at a time, as far as the neighbours on its grid."""
    found = []
    for p in atom.term.form.shapes:
        grid = np.unique(np.r_[p.grid, p.lower, p.upper])
        here = atom.shapes[p.name]
        below, above = grid[grid < here - 1e-12], grid[grid > here + 1e-12]
        low, high = below[-1] if len(below) else here, above[0] if len(above) else here
        found += [{**atom.shapes, p.name: float(v)} for v in np.linspace(low, high, points)]
    return found


def signature(form: Form, inputs: Inputs, shapes: Mapping[str, float], around: Slopes) -> Array:
    """dF/dsize at the neutral size, shape (n, sizes), in N per unit."""
    columns = form.columns(inputs, shapes, around.force)
    if isinstance(form, AddsForce):
        return columns
    if isinstance(form, ScalesForce):
        return columns * around.force[:, None]
    if isinstance(form, TransformsPressure):
        return columns * around.pressure[:, None]
    return columns * around.contraction[:, None]


def same_around_any(form: Form) -> bool:
    """Whether a form's signature does not depend on the model that it is taken around."""
    return isinstance(form, AddsForce) and not form.uses_force


def grid(form: Form) -> list[dict[str, float]]:
    """All combinations of the values from which a form's shapes are searched."""
    names = [p.name for p in form.shapes]
    return [dict(zip(names, point, strict=True)) for point in product(*(p.grid or (p.start,) for p in form.shapes))]
