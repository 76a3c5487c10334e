"""Separable least squares with bounds: linear parameters are eliminated, the few curved ones searched.

Golub & Pereyra 1973, SIAM J. Numer. Anal. 10, 413–432 (variable projection).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice, product

import numpy as np

from ..core import Inputs, Param
from ..model import Model

Array = np.ndarray
HUGE = 1e60
"""Residual beyond which a trial point is simply bad: its square must stay a number."""
Whiten = Callable[[Array], Array]
"""Selects rows and decorrelates noise: (n,) or (n, k) → (m,) or (m, k), linear."""


@dataclass(frozen=True)
class Solution:
    """Where the search ended: values by name, and whether it converged with what message."""

    values: dict[str, float]
    converged: bool
    message: str


def bounded_lstsq(columns: Array, target: Array, params: Sequence[Param]) -> Array:
    """x that minimises |columns · x − target| within the parameters' bounds, shape (k,); minimum norm if flat."""
    k = columns.shape[1]
    if k == 0:
        return np.empty(0)
    packed: Array = np.linalg.qr(np.column_stack([columns, target]), mode="r")  # pyright: ignore
    small, goal = packed[:, :k], packed[:, k]
    scale = np.linalg.norm(small, axis=0)
    scale[scale == 0.0] = 1.0
    x = np.linalg.lstsq(small / scale, goal, rcond=1e-12)[0] / scale
    lower, upper = np.array([p.lower for p in params]), np.array([p.upper for p in params])
    if np.all((x >= lower) & (x <= upper)):
        return x
    from scipy.optimize import lsq_linear

    result = lsq_linear(small / scale, goal, (lower * scale, upper * scale), method="bvls", lsmr_tol="auto")
    return np.clip(result.x / scale, lower, upper)


def solve(
    model: Model,
    inputs: Inputs,
    force: Array,
    whiten: Whiten,
    start: Mapping[str, float] | None = None,
    max_starts: int = 24,
    quick: bool = False,
) -> Solution:
    """Least squares of whiten(model − force) over the model's parameters, within their bounds.

    Curved parameters start from `start` where it names them, else from every combination of their grids (at
    most `max_starts`, the two best of which are followed down). `quick` follows one and stops at 1e-8.
    """
    found = _separated(model, inputs, force, force, whiten, dict(start or {}), max_starts, quick)
    if model.separable:
        return found
    for _ in range(2):
        acting = np.clip(model.force(inputs, found.values), -1e6, 1e6)
        found = _separated(model, inputs, force, acting, whiten, found.values, max_starts, quick)
    return found if quick else _polish(model, inputs, force, whiten, found.values)


def _separated(
    model: Model,
    inputs: Inputs,
    force: Array,
    acting: Array,
    whiten: Whiten,
    start: Mapping[str, float],
    max_starts: int,
    quick: bool,
) -> Solution:
    """Least squares while the force that effects are given, `acting` (n,) in N, stays what it is."""
    guess = model.neutral(inputs) | dict(start)
    curved = curved_within_bounds(model, inputs)

    def project(q: Array) -> tuple[dict[str, float], Array]:
        values = dict(zip([p.name for p in curved], map(float, q), strict=True))
        columns, fixed = model.design(inputs, values, acting)
        matrix, target = whiten(columns), whiten(force - fixed)
        if not (np.all(np.isfinite(matrix)) and np.all(np.isfinite(target))):
            return values | {p.name: p.start for p in model.linear}, np.full(len(target), HUGE)
        linear = bounded_lstsq(matrix, target, model.linear)
        values |= {p.name: float(x) for p, x in zip(model.linear, linear, strict=True)}
        return values, np.clip(matrix @ linear - target, -HUGE, HUGE)

    if not curved:
        return Solution(project(np.empty(0))[0], True, "linear")
    return Solution(*_search(project, curved, guess, start, max_starts, quick))


def curved_within_bounds(model: Model, inputs: Inputs) -> list[Param]:
    """Curved parameters; the radius is kept within 15 % of the specimen's."""
    r0 = inputs.specimen.initial_radius_mm
    return [replace(p, lower=0.85 * r0, upper=1.15 * r0, start=r0) if p.name == "r0" else p for p in model.curved]


def _search(
    project: Callable[[Array], tuple[dict[str, float], Array]],
    curved: Sequence[Param],
    guess: Mapping[str, float],
    given: Mapping[str, float],
    max_starts: int,
    quick: bool,
) -> tuple[dict[str, float], bool, str]:
    from scipy.optimize import least_squares

    grids = [(guess[p.name],) if p.name in given or not p.grid else p.grid for p in curved]
    lower, upper = np.array([p.lower for p in curved]), np.array([p.upper for p in curved])
    starts = [np.clip(np.array(s), lower, upper) for s in islice(product(*grids), max_starts)]
    if len(starts) > 1:
        starts.sort(key=lambda q: float(np.sum(project(q)[1] ** 2)))
    inside = 1e-9 * np.minimum(np.where(np.isfinite(upper - lower), upper - lower, 1.0), 1.0)
    results = []
    for q in starts[: 1 if quick else 2]:
        results.append(
            least_squares(
                lambda x: project(x)[1],
                np.clip(q, lower + inside, upper - inside),
                bounds=(lower, upper),
                x_scale=[
                    max(p.scale, abs(x)) if p.scale != 1.0 else max(abs(x), 1e-3)
                    for p, x in zip(curved, q, strict=True)
                ],
                ftol=2e-6 if quick else 1e-13,
                xtol=1e-5 if quick else 1e-11,
                gtol=1e-13,
                max_nfev=25 if quick else 200,
            )
        )
    best = min(results, key=lambda r: r.cost)
    return project(best.x)[0], bool(best.status > 0), str(best.message)


def _polish(model: Model, inputs: Inputs, force: Array, whiten: Whiten, start: Mapping[str, float]) -> Solution:
    """All parameters at once, for models in which the force acts back on itself."""
    from scipy.optimize import least_squares

    params = [*model.linear, *curved_within_bounds(model, inputs)]
    names = [p.name for p in params]
    scale = np.array([max(abs(start[p.name]), p.scale) for p in params])
    lower, upper = (np.array([getattr(p, side) for p in params]) / scale for side in ("lower", "upper"))
    target = whiten(force)

    def residual(x: Array) -> Array:
        force = whiten(model.force(inputs, dict(zip(names, x * scale, strict=True))))
        return np.nan_to_num(np.clip(force - target, -HUGE, HUGE), nan=HUGE)

    begin = np.clip(np.array([start[n] for n in names]) / scale, lower + 1e-9, upper - 1e-9)
    result = least_squares(
        residual,
        begin,
        bounds=(lower, upper),
        ftol=1e-12,
        xtol=1e-10,
        gtol=1e-12,
        max_nfev=60,
    )
    values = {n: float(v) for n, v in zip(names, result.x * scale, strict=True)}
    return Solution(values, bool(result.status > 0), str(result.message))


def jacobian(model: Model, inputs: Inputs, values: Mapping[str, float], force: Array) -> Array:
    """dF/dparameter in N per unit at `values`, shape (n, len(params)); curved ones by central differences."""
    columns: list[Array] = []
    if model.separable:
        columns.append(model.design(inputs, values, force)[0])
    for p in model.curved if model.separable else model.params:
        step = 1e-5 * max(abs(values[p.name]), p.scale if p.scale != 1.0 else 1e-3)
        high, low = p.clip(values[p.name] + step), p.clip(values[p.name] - step)
        up = model.force(inputs, {**values, p.name: high})
        down = model.force(inputs, {**values, p.name: low})
        columns.append(((up - down) / (high - low))[:, None])
    return np.hstack(columns) if columns else np.empty((len(inputs), 0))
