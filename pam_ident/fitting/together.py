"""One fit to several records: parameters that all of them share, and parameters that are each record's own."""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from ..core import Array, FitError, Param, UsageError
from ..core.progress import tell
from ..model import Model
from ..records import Record
from .covariance import clusters, sums
from .estimate import Estimate, estimates_of
from .fit import Fit, check_held, check_needs, fit
from .length import by_length, determining, evened, problem_of, solved_from
from .problem import Problem, Solution, Whiten, all_rows
from .solve import separated
from .solvers import VariableProjection

_SOLVER = VariableProjection(keep=1)


def fit_together(
    model: Model,
    records: Sequence[Record],
    shared: Collection[str] = (),
    branch: str = "together",
    held: Mapping[str, float] | None = None,
) -> tuple[Fit, ...]:
    """Least-squares fit of a model to several records at once, a Fit each.

    The residual is that of the force, in mm of the length in records in which that answered. It counts in units of
    what the model leaves of its record alone, so that a noisy or strong muscle does not decide for all. Standard errors
    are those of the whole fit; with nothing shared it is the fits of each record alone.

    Args:
        model, records: what to fit to what.
        shared: names of parameters that have one value for all records; any other has one for each.
        branch: together, contraction or extension.
        held: parameters that keep the given values in all records.

    Raises:
        FitError: where all records together hold too few samples.
        DataError: when an effect needs what a record does not hold.
        UsageError: for an unknown parameter, and for an effect that acts on the force itself.

    Example:
        >>> from pam_ident.fitting import fit_together
        >>> from pam_ident.model import Model
        >>> from pam_ident.records import read_record
        >>> from pam_ident.records.datasets import dataset_record
        >>> records = [read_record(dataset_record(name)) for name in ("hidden_effect", "nothing_hidden")]
        >>> one, two = fit_together(Model.build("exponential_law"), records, shared=["mu"])
        >>> print(one.values["mu"] == two.values["mu"], one.values["a0"] == two.values["a0"])
        True False
    """
    held = dict(held or {})
    _check(model, records, shared, held)
    rows = [determining(record, record.branch_rows(branch)) for record in records]
    alone = [_alone(model, record, mask, held) for record, mask in zip(records, rows, strict=True)]
    sizes = _sizes(alone, [False] * len(records))
    parts = [
        separated(model, record.inputs, record.force, one.values if one else {}, _scaled(size, mask)).holding(**held)
        for record, one, mask, size in zip(records, alone, rows, sizes, strict=True)
    ]
    problem = stacked(parts, shared)
    n = sum(int(np.count_nonzero(mask)) for mask in rows)
    if n <= len(problem.params):
        raise FitError(f"{n} samples for {len(problem.params)} parameters; measure more samples, or share more of them")
    tell("fitting together")
    solution = VariableProjection().solve(problem)
    answered = [by_length(record) for record in records]
    if any(answered):
        sizes = _sizes(alone, answered)
        solution, problem = _in_length(model, records, rows, parts, alone, sizes, shared, held, solution)
    known = sums(problem.table(solution.values), _clusters(records, rows))
    estimates, covariance = estimates_of(problem.params, solution.values, {}, known)
    free = [e.name for e in estimates if not e.at_bound]
    weights = [np.full(len(record), 1.0 / size) for record, size in zip(records, sizes, strict=True)]
    found = []
    for k, (record, mask) in enumerate(zip(records, rows, strict=True)):
        values = {p.name: solution.values[_own(p.name, k, shared)] for p in parts[k].params} | held
        plain = Fit(model, record, mask, values, solution.converged, solution.message, weights[k], held)
        given = tuple(_estimate(e, k, estimates, shared) for e in plain.estimates)
        one = replace(plain, given=given, shared=tuple(name for name in model.names if name in shared))
        mine = [free.index(_own(name, k, shared)) for name in one.free]
        found.append(replace(one, joint=covariance and covariance.of(mine)))
    return tuple(found)


def stacked(parts: Sequence[Problem], shared: Collection[str]) -> Problem:
    """Several problems as one, whose parameters are those that are `shared` and `name[k]` of the k-th.

    A shared nonlinear parameter begins at its grid and at the mean of its starts.
    """
    linear, nonlinear = (_union([getattr(part, kind) for part in parts], shared) for kind in ("linear", "nonlinear"))
    where = {p.name: k for k, p in enumerate(linear)}
    edges = np.cumsum([0, *(len(part.target) for part in parts)])
    places = [slice(begin, end) for begin, end in pairwise(edges.tolist())]

    def design(values: Mapping[str, float]) -> tuple[Array, Array]:
        columns, fixed = np.zeros((edges[-1], len(linear))), np.empty(edges[-1])
        for k, (part, place) in enumerate(zip(parts, places, strict=True)):
            own, fixed[place] = part.design({p.name: values[_own(p.name, k, shared)] for p in part.nonlinear})
            columns[place, [where[_own(p.name, k, shared)] for p in part.linear]] = own
        return columns, fixed

    def slopes(values: Mapping[str, float]) -> Array:
        found, where = np.zeros((edges[-1], len(nonlinear))), {p.name: k for k, p in enumerate(nonlinear)}
        for k, (part, place) in enumerate(zip(parts, places, strict=True)):
            assert part.slopes is not None
            own = {p.name: values[_own(p.name, k, shared)] for p in part.nonlinear}
            found[place, [where[_own(p.name, k, shared)] for p in part.nonlinear]] = part.slopes(own)
        return found

    known = not linear and all(part.slopes for part in parts)

    def whiten(rows: Array) -> Array:
        return np.concatenate([part.whiten(rows[place]) for part, place in zip(parts, places, strict=True)])

    start = {_own(name, k, shared): x for k, part in enumerate(parts) for name, x in part.start.items()}
    for k, p in enumerate(nonlinear):
        near = [part.start[p.name] for part in parts if p.name in part.start]
        if p.name in shared and near:
            nonlinear[k] = replace(p, grid=(p.clip(float(np.mean(near))), *p.grid))
            del start[p.name]
    target = np.concatenate([part.target for part in parts])
    return Problem(tuple(linear), tuple(nonlinear), design, target, start, whiten, slopes=slopes if known else None)


def _union(each: Sequence[Sequence[Param]], shared: Collection[str]) -> list[Param]:
    """Of a shared one the widest bounds."""
    found: dict[str, Param] = {}
    for k, p in ((k, p) for k, params in enumerate(each) for p in params):
        name = _own(p.name, k, shared)
        if name not in found or p.upper > found[name].upper:
            found[name] = replace(p, name=name)
    return list(found.values())


def _own(name: str, k: int, shared: Collection[str]) -> str:
    return name if name in shared else f"{name}[{k}]"


def _check(model: Model, records: Sequence[Record], shared: Collection[str], held: Mapping[str, float]) -> None:
    if len(records) < 2:
        raise UsageError(f"{len(records)} record to fit together; give two or more")
    for name in shared:
        if name not in model.names:
            raise UsageError(f"no parameter {name!r} to share in {model.law.name}; it has {', '.join(model.names)}")
        if name in held:
            raise UsageError(f"{name} is held and shared; a held parameter has one value for all")
    if not model.separable:
        raise UsageError("an effect of the model acts on the force itself; records are fitted together without it")
    check_held(model, held)
    for record in records:
        check_needs(model, record)


def _alone(model: Model, record: Record, rows: Array, held: Mapping[str, float]) -> Fit | None:
    """The fit to one record; None where it holds too little for one."""
    try:
        return fit(model, record, rows, detail=False, held=held)
    except FitError:
        return None


def _in_length(
    model: Model,
    records: Sequence[Record],
    rows: Sequence[Array],
    by_force: Sequence[Problem],
    alone: Sequence[Fit | None],
    sizes: Sequence[float],
    shared: Collection[str],
    held: Mapping[str, float],
    near: Solution,
) -> tuple[Solution, Problem]:
    """The solution in which records whose length answered count by that, begun `near` that of the force and at each
    record's own; and the problem that errors of the parameters come from."""

    def problem(even: Sequence[Whiten], by_weight: bool = False) -> Problem:
        parts = []
        for k, (record, mask) in enumerate(zip(records, rows, strict=True)):
            part = replace(by_force[k].curved(), whiten=_scaled(sizes[k], mask))
            if by_length(record):
                whiten = _scaled(sizes[k], slice(None), even[k])
                part = problem_of(model, record, mask, whiten, by_weight).holding(**held)
            parts.append(part)
        return stacked(parts, shared)

    own = {_own(name, k, shared): x for k, one in enumerate(alone) for name, x in (one.values if one else {}).items()}
    found = solved_from(problem([all_rows] * len(records)), [near.values, {**near.values, **own}], _SOLVER)
    even = [
        evened(model, record, mask, {n: found.values.get(_own(n, k, shared), held.get(n, 0.0)) for n in model.names})
        if by_length(record)
        else all_rows
        for k, (record, mask) in enumerate(zip(records, rows, strict=True))
    ]
    found = solved_from(problem(even), [found.values], _SOLVER)
    return found, problem(even, by_weight=True)


def _scaled(size: float, rows: Array | slice, even: Whiten = all_rows) -> Whiten:
    """Some rows, `even`, in units of a size."""
    return lambda m: even(m[rows]) / size


def _sizes(alone: Sequence[Fit | None], answered: Sequence[bool]) -> list[float]:
    """What a residual of each record is measured by, in N, or in mm where the length has `answered`; the median of
    those alike where a record cannot tell it."""
    own = [one and _size(one, length) for one, length in zip(alone, answered, strict=True)]
    found = []
    for size, length in zip(own, answered, strict=True):
        known = [s for s, kind in zip(own, answered, strict=True) if s and kind == length]
        found.append(max(size or float(np.median(known)), 1e-9 * max(known)) if known else 1.0)
    return found


def _size(one: Fit, length: bool) -> float:
    errors = one.length_errors if length else one.errors
    assert errors is not None
    return errors.rmse * math.sqrt(one.n / (one.n - len(one.model.params) + len(one.held)))


def _clusters(records: Sequence[Record], rows: Sequence[Array]) -> Array | None:
    """Runs along which residuals may be correlated, none of which belongs to two records; None for tables alone."""
    each = [clusters(record, mask) for record, mask in zip(records, rows, strict=True)]
    if all(one is None for one in each):
        return None
    begin, found = 0, []
    for one, mask in zip(each, rows, strict=True):
        numbers = np.arange(np.count_nonzero(mask)) if one is None else one - one.min()
        found.append(begin + numbers)
        begin += int(numbers.max()) + 1
    return np.concatenate(found)


def _estimate(plain: Estimate, k: int, estimates: Sequence[Estimate], shared: Collection[str]) -> Estimate:
    """What all records say of a parameter of the k-th; `plain` where it was held."""
    found = next((e for e in estimates if e.name == _own(plain.name, k, shared)), None)
    if found is None:
        return plain
    own = f"[{k}]"
    verdict = replace(
        found.verdict,
        text=found.verdict.text.replace(own, ""),
        partners=tuple(name.removesuffix(own) for name in found.verdict.partners),
    )
    return replace(found, name=plain.name, verdict=verdict)
