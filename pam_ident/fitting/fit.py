"""Fit a model to a record."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..core import Array, DataError, FitError, Inputs, UsageError
from ..core.progress import tell
from ..effects import in_words
from ..model import Model
from ..records import Record
from . import readings
from .covariance import Covariance, Sums, clusters, student, sums
from .estimate import Estimate, estimates_of
from .identifiability import StandIn, at_its_pressures, stand_ins
from .length import Lengths, by_length, determining, problem_of, solve_length
from .readings import Errors, in_memory, least, on_disk, with_memory
from .solve import Solution, jacobian, solve, table
from .solvers import Solver
from .weigh import PLAIN, Weighing

if TYPE_CHECKING:
    from ..records.long import LongRecord

MOST_TURNS = 40
"""How often parameters and weights may be renewed in turn."""
OTHER_WEIGHTS = "hang other weights, or fit records under several together (`--shared all`)"
BY_READINGS = "by readings of all rows"


@dataclass(frozen=True)
class Fit:
    """A model with the values that a record gives it.

    Args:
        model, record: what was fitted to what.
        rows: mask of the samples that were fitted, shape (n,); `force` and `residual` cover all n.
        values: the parameters by name, each in its unit.
        converged, message: whether the search ended at a minimum, and how.
        weights: what the residuals that were minimised were multiplied by, shape (n,), 1/N; None for ones.
        held: parameters that were not fitted, with their values.
        weighing: how the weights were found.
        sums: what errors of the parameters come from, when somebody looks at them; None where they were not asked for.
        given: estimates that were found otherwise, such as from profiles.
        of_all: of a record on disk the errors of all its rows, of which `record` and `rows` are then a sample.
        shared, joint: parameters that were fitted to other records, too, and the covariance that all of them give.

    `valid` needs convergence and every parameter identified, but for those by which an effect acts in states that the
    record does not hold, such as what friction keeps in holds; `problems` says in words what is wrong.

    Example:
        >>> from pam_ident.fitting import fit
        >>> from pam_ident.model import Model
        >>> from pam_ident.records import read_record
        >>> from pam_ident.records.datasets import dataset_record
        >>> found = fit(Model.build("martens_boblan"), read_record(dataset_record("dmsp20_300")))
        >>> first = found.estimates[0]
        >>> print(f"{first.name} = {first.value:.0f} ± {first.stderr:.0f} {first.unit}; {found.max_error:.1f} N off")
        A = 562 ± 16 mm^2; 7.7 N off
    """

    model: Model
    record: Record
    rows: Array
    values: dict[str, float]
    converged: bool
    message: str
    weights: Array | None = None
    held: Mapping[str, float] = field(default_factory=dict)
    weighing: Weighing = PLAIN
    sums: Sums | None = None
    given: tuple[Estimate, ...] | None = None
    of_all: Errors | None = None
    shared: tuple[str, ...] = ()
    joint: Covariance | None = None

    @property
    def estimates(self) -> tuple[Estimate, ...]:
        """What is known of each parameter, in the model's order."""
        return self._estimated[0] if self.given is None else self.given

    @property
    def covariance(self) -> Covariance | None:
        """Covariance of the `free` parameters; None where no errors were asked for, or there are none to have."""
        return self._estimated[1] if self.joint is None else self.joint

    @cached_property
    def _estimated(self) -> tuple[tuple[Estimate, ...], Covariance | None]:
        largest = float(np.max(self.record.force, initial=0.0))
        params = [p.where_measured(largest) for p in self.model.bounded(self.record.inputs)]
        return estimates_of(params, self.values, self.held, self.sums)

    @cached_property
    def force(self) -> Array:
        """The model's force in N at every sample of the record, shape (n,)."""
        return self.model.force(self.record.inputs, self.values)

    @cached_property
    def residual(self) -> Array:
        """Measured minus modelled force in N, shape (n,)."""
        return self.record.force - self.force

    @cached_property
    def errors(self) -> Errors:
        """What the fitted rows leave, in N."""
        return self.of_all or Errors.of(self.residual[self.rows], self.record.force[self.rows])

    @cached_property
    def lengths(self) -> Lengths | None:
        """What the model says of the length, where that answered and was fitted; None where the force was."""
        return Lengths.of(self.model, self.record, self.values) if by_length(self.record) else None

    @cached_property
    def length_errors(self) -> Errors | None:
        """What the fitted rows leave of the length, in mm; None where the force was fitted."""
        if self.lengths is None:
            return None
        return Errors.of(self.lengths.residual[self.rows], self.record.inputs.displacement_mm[self.rows])

    @property
    def n(self) -> int:
        """How many rows were fitted."""
        return self.of_all.n if self.of_all else int(self.rows.sum())

    @property
    def rmse(self) -> float:
        """Root mean square of the residual over the fitted rows, N."""
        return self.errors.rmse

    @property
    def max_error(self) -> float:
        """Largest absolute residual over the fitted rows, N."""
        return self.errors.largest

    @property
    def r2(self) -> float:
        """Coefficient of determination over the fitted rows, of what was fitted."""
        return (self.length_errors or self.errors).r2

    @property
    def undetermined(self) -> list[str]:
        """Names of the parameters that the record does not determine."""
        acting = {p.name for t in self.model.terms for p in t.qualified(t.form.linear)}
        unknown = [e for e in self.estimates if not e.identified]
        return [e.name for e in unknown if e.verdict.kind != "dead" or e.name not in acting]

    @property
    def problems(self) -> list[str]:
        """Why the fit is not valid; empty when it is."""
        found = [] if self.converged else [f"the search did not converge ({self.message})"]
        if loose := self.undetermined:
            more = OTHER_WEIGHTS if self.lengths else "drop an effect, or vary more on the rig"
            found.append(f"the record does not determine {', '.join(loose)}; {more}")
        return found

    @property
    def impossible(self) -> tuple[Estimate, ...]:
        """The fitted parameters whose values nature does not allow."""
        return tuple(e for e in self.estimates if e.name not in self.held and e.possible is False)

    @property
    def at_bounds(self) -> list[str]:
        """In words, which parameters stand at a bound; of a free form's coefficients how many."""
        stuck = [e for e in self.estimates if e.verdict.kind == "at_bound"]
        found = []
        for term in self.model.terms:
            names = [p.name for p in term.qualified(term.form.linear)] if term.form.free else []
            if at := sum(e.name in names for e in stuck):
                what = f"coefficients of {in_words(term.effect.name)}, free form, stand at a bound"
                found.append(f"{at} of {len(names)} {what}")
            stuck = [e for e in stuck if e.name not in names]
        return [*found, *(f"{e.words} stands {e.verdict.text}" for e in stuck)]

    @cached_property
    def shares(self) -> dict[str, float]:
        """Root mean square force in N that each effect makes over the fitted rows, by label."""
        found = {}
        for term in self.model.terms:
            rest = replace(self.model, terms=tuple(other for other in self.model.terms if other is not term))
            off = self.force - rest.force(self.record.inputs, self.values)
            found[term.label] = float(np.sqrt(np.mean(off[self.rows] ** 2)))
        return found

    @cached_property
    def free(self) -> tuple[str, ...]:
        """Names of the parameters that were fitted and do not stand at a bound, in the order of `covariance`."""
        return tuple(e.name for e in self.estimates if e.name not in self.held and not e.at_bound)

    @property
    def stand_ins(self) -> tuple[StandIn, ...]:
        """Scales and zeros of the sensors that the record's own fitted parameters take up without trace in it."""
        fixed = {*self.held, *self.shared}
        fitted = [k for k, e in enumerate(self.estimates) if e.name not in fixed]
        matrix = jacobian(self.model, self.record.inputs, self.values, self.record.force)[:, fitted]
        names = [self.estimates[k].name for k in fitted]
        return stand_ins(self.model, self.record.inputs, self.values, matrix, names)

    def band(self, inputs: Inputs) -> tuple[Array, Array, Array]:
        """Force in N at `inputs` with the 95 % interval of the fitted curve: force, low, high, shape (n,) each.

        To first order in the parameters; noise of a new reading is not in it. NaN where no errors were asked for.
        """
        force = self.model.force(inputs, self.values)
        half = self._half_width(jacobian(self.model, inputs, self.values, force))
        return force, force - half, force + half

    def half_width(self, samples: Array) -> Array:
        """Half the width in N of the fitted curve's 95 % interval at some samples (indices, (m,)) of the record."""
        return self._half_width(jacobian(self.model, self.record.inputs, self.values, self.record.force)[samples])

    def _half_width(self, slopes: Array) -> Array:
        if self.covariance is None:
            return np.full(len(slopes), math.nan)
        index = [k for k, e in enumerate(self.estimates) if e.name in self.free]
        stderr, dof = self.covariance.error(slopes[:, index])
        return student(dof) * stderr

    @property
    def valid(self) -> bool:
        """Converged, and every parameter identified."""
        return not self.problems


def fit(
    model: Model,
    record: Record,
    rows: Array | None = None,
    start: Mapping[str, float] | None = None,
    detail: bool = True,
    *,
    held: Mapping[str, float] | None = None,
    weighing: Weighing = PLAIN,
    white: bool = False,
    solver: Solver | None = None,
) -> Fit:
    """Least-squares fit of a model to a record, with the errors of its parameters: of the force, or of the length where
    that answered (an isotonic test), without the rows at its mechanical limit. Parameters of the law that one pressure
    does not tell from others are held at 0.

    Args:
        model, record: what to fit to what.
        rows: mask of the samples to fit, shape (n,); by default all.
        start: values to begin at, by name; by default the model's own.
        detail: whether errors of the parameters are wanted.
        held: parameters that keep the given values.
        weighing: what samples weigh, and how far outliers count.
        white: whether residuals are taken as independent; else errors allow for correlation along the strokes.
        solver: what searches, in place of variable projection (Golub & Pereyra 1973, SIAM J. Numer. Anal. 10, 413–432).

    Raises:
        FitError: when the record cannot identify the law at all.
        DataError: when an effect needs what the record does not hold.
        UsageError: when a parameter to hold is unknown or out of its bounds.

    Example:
        >>> from pam_ident.fitting import fit
        >>> from pam_ident.model import Model
        >>> from pam_ident.records import read_record
        >>> from pam_ident.records.datasets import dataset_record
        >>> found = fit(Model.build("martens_boblan"), read_record(dataset_record("dmsp20_300")))
        >>> print(f"{found.rmse:.2f} N rms, valid: {found.valid}")
        3.21 N rms, valid: True
    """
    held = dict(held or {})
    rows = determining(record, np.ones(len(record), bool) if rows is None else rows)
    check(model, record, rows, held)
    model = at_its_pressures(model, record, rows)
    held = model.law.pinned | held
    tell("fitting")
    runs = clusters(record, rows) if detail and not white else None
    if by_length(record):
        if weighing != PLAIN:
            raise UsageError("weights and losses are for residuals in force; leave them out where the length answered")
        found, even = solve_length(model, record, rows, start or {}, held, solver)
        one = Fit(model, record, rows, found.values, found.converged, found.message, held=held)
        if not detail:
            return one
        known = problem_of(model, record, rows, even, by_weight=True).table(found.values)
        return replace(one, sums=sums(known, runs))
    if weighing == PLAIN and solver is None and pays_in_chunks(model, record, rows):
        index, first = np.flatnonzero(rows), bool(model.terms)
        every = in_memory(record, index, first, detail and not white)
        search, end, known, done = least(model, record, index, every, start or {}, held)
        if done:
            return Fit(model, record, rows, search.values(end), True, BY_READINGS, held=held, sums=known)
    solution, weights = _in_turns(model, record, rows, start or {}, held, weighing, solver)
    one = Fit(model, record, rows, solution.values, solution.converged, solution.message, weights, held, weighing)
    if not detail:
        return one
    known = table(model, record.inputs, one.values, record.force, picker(rows, weights))
    known[:, -1] *= math.sqrt(weighing.inflation(known[:, -1]))
    return replace(one, sums=sums(known, runs))


def pays_in_chunks(model: Model, record: Record, rows: Array) -> bool:
    """Whether readings of very many `rows` (mask (n,)) in chunks pay and are open: to a model without memory."""
    if np.count_nonzero(rows) < readings.FROM or not model.separable or not model.params:
        return False
    some = slice(None, None, len(record) // readings.SAMPLES[-1] | 1)
    return not with_memory(model, record.inputs.take(some), record.force[some])


def fit_long(model: Model, record: "LongRecord", branch: str, held: Mapping[str, float] | None = None) -> Fit:
    """Least-squares fit to a branch of a record on disk, as `fit` makes it of one in memory.

    Raises what `fit` does, and UsageError for an effect that remembers what was before a sample.
    """
    held, sample = dict(held or {}), record.sample(readings.SAMPLES[-1])
    rows = sample.branch_rows(branch)
    check(model, sample, rows, held)
    model = at_its_pressures(model, sample, rows)
    held = model.law.pinned | held
    memory = with_memory(model, sample.inputs, sample.force)
    if memory:
        raise UsageError(
            f"{sample.source}: {memory[0].label} remembers what was before, and the record is read in chunks; leave it "
            "out, or fit a part of the record that fits into memory"
        )
    both = np.ptp(np.sign(sample.inputs.direction[rows])) == 2.0
    every = on_disk(record, branch, bool(both), bool(model.terms))
    search, end, known, done = least(model, sample, np.flatnonzero(rows), every, {}, held, exact=True)
    values, errors = search.values(end), search.errors(end)
    return Fit(model, sample, rows, values, done, BY_READINGS, held=held, sums=known, of_all=errors)


def _in_turns(
    model: Model,
    record: Record,
    rows: Array,
    start: Mapping[str, float],
    held: Mapping[str, float],
    weighing: Weighing,
    solver: Solver | None,
) -> tuple[Solution, Array | None]:
    """Solve and weigh in turn until the weights settle; once where all samples count the same."""
    weighing.check(record)
    weights, values = None, start
    for _ in range(MOST_TURNS):
        pick = picker(rows, weights)
        solution = solve(model, record.inputs, record.force, pick, values, held=held, solver=solver)
        values = solution.values
        renewed = weighing.weights(model, record, rows, values)
        if renewed is None or (weights is not None and np.allclose(renewed, weights, rtol=1e-6)):
            return solution, renewed
        weights = renewed
    return Solution(dict(values), False, "the weights did not settle"), weights


def picker(rows: Array, weights: Array | None) -> Callable[[Array], Array]:
    """Selects rows and weighs them: (n,) or (n, k) → (m,) or (m, k)."""
    if weights is None:
        return lambda m: m[rows]
    chosen = weights[rows]
    return lambda m: m[rows] * (chosen if m.ndim == 1 else chosen[:, None])


def fit_branches(model: Model, record: Record, branch: str) -> dict[str, Fit]:
    """Fits by branch, as `branch_names` has them."""
    return {name: fit(model, record, record.branch_rows(name)) for name in branch_names(branch)}


def branch_names(branch: str) -> tuple[str, ...]:
    """`separate` is contraction and extension, any other word that branch alone."""
    return ("contraction", "extension") if branch == "separate" else (branch,)


def check(model: Model, record: Record, rows: Array, held: Mapping[str, float]) -> None:
    """Refuse a fit to `rows` (mask, shape (n,)) that cannot be asked for.

    Raises FitError, DataError and UsageError where `fit` does.
    """
    check_held(model, held)
    if np.count_nonzero(rows) <= len(model.params):
        raise FitError(
            f"{record.source or record.name}: {int(rows.sum())} samples for {len(model.params)} parameters of "
            f"{model.law.name}; measure more samples or choose a law with fewer parameters"
        )
    check_needs(model, record)


def check_held(model: Model, held: Mapping[str, float]) -> None:
    """Raises UsageError for a parameter to hold that is unknown or out of its bounds."""
    known = {p.name: p for p in model.params}
    for name, value in held.items():
        if name not in known:
            raise UsageError(f"no parameter {name!r} to hold in {model.law.name}; it has {', '.join(known)}")
        if not known[name].lower <= value <= known[name].upper:
            raise UsageError(f"{name} = {value:g} is outside its bounds {known[name].lower:g} to {known[name].upper:g}")


def check_needs(model: Model, record: Record) -> None:
    """Raises DataError where an effect needs what the record does not hold."""
    for term in model.terms:
        lacking = term.effect.missing(record.inputs)
        if lacking:
            raise DataError(
                f"{record.source or record.name}: {term.effect.name} needs {', '.join(lacking)}, which the record does "
                "not hold; log it on the rig, or leave the effect out"
            )
