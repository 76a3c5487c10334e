"""What a diagnosis selects from: a record, a fitted base model, candidates with their signatures, and the noise."""

import math
from collections.abc import Collection, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from ..core import Inputs
from ..core.digits import percent
from ..core.progress import steps, tell
from ..effects import Effect
from ..fitting import Fit
from ..fitting.descent import GIVEN_UP
from ..fitting.solve import solve
from ..model import Model, Term
from ..records import Record
from .follows import Following
from .noise import OTHER_SIZE, Noise, estimate_noise
from .search import Choice, Compressed, FormBlock, Penalty, remainder
from .view import View

Array = np.ndarray
NAME_MARGIN = 12.0
FORM_TOLERANCE = 0.005
"""Share of all that is to be explained which each name must earn: an unforeseen form may leave as much."""
MOST_TOLERANCE = 0.5
"""The same in units of the noise: what stands out that far is named, however large the rest."""
LEAST_CHANGE = 1.0 / 3.0
"""Share of its largest by which what a free form follows must change, lest the form be a surface over the map."""
HOPELESS = 60.0
"""Cost beyond the best at which a set counts for nothing, not even for the probabilities."""
TOO_FLAT, UNSEEN = 0.02, 1.0
"""Share of a signature that is left once the law has followed it, and what that is at the effect's natural limit, rms
in units of the noise, up to which it counts as absorbed."""


def tolerance(excess: float, rows: int) -> float:
    """Whitened squares that an unforeseen form may leave of the `excess` which is to be explained in so many rows."""
    return min(FORM_TOLERANCE * excess, MOST_TOLERANCE * rows)


def labels(terms: Sequence[Term]) -> frozenset[str]:
    """What terms are called."""
    return frozenset(term.label for term in terms)


@dataclass(frozen=True, eq=False)
class FittedSet:
    """A set of terms fitted exactly: values, whitened sum of squares and criterion.

    The fit of one that has no hope of a criterion below `beyond` was given up on its way.
    """

    terms: tuple[Term, ...]
    values: dict[str, float]
    squares: float
    criterion: float
    beyond: float = math.inf

    @property
    def names(self) -> frozenset[str]:
        """Effects of the set."""
        return frozenset(t.effect.name for t in self.terms)

    @property
    def candidates(self) -> frozenset[str]:
        """Effects of the set that a diagnosis may name, patterns left out."""
        return frozenset(t.effect.name for t in self.terms if t.effect.candidate)

    @property
    def exclusion_groups(self) -> frozenset[str]:
        """The exclusion_groups of its effects, of which a set has one each."""
        return frozenset(t.effect.exclusion_group for t in self.terms)

    @property
    def labels(self) -> frozenset[str]:
        """Effects of the set with their forms."""
        return labels(self.terms)

    def without(self, term: Term) -> list[Term]:
        """The set less one of its terms."""
        return [t for t in self.terms if t is not term]


class Selection:
    """All that is computed once for a diagnosis. `base` is the model as the user gave it, fitted.

    Of the candidates only those `tried`, by name, may be part of an answer, all where that is None. A selection of the
    same record against another `noise` takes over from the selection `before` what no noise changes.
    """

    def __init__(
        self,
        base: Fit,
        candidates: Sequence[Effect],
        following: Following | None = None,
        tried: Collection[str] | None = None,
        noise: Noise | None = None,
        before: "Selection | None" = None,
        odds: Mapping[str, float] | None = None,
    ) -> None:
        self.base = base
        if before is not None:
            following, tried = before.following, before.tried
        self.following: Following = following or Following(base.record, base.model, base.values)
        self.tried = tried
        self.record: Record = base.record
        self.excluded: dict[str, tuple[str, str]] = {}
        self.candidates: list[Effect] = []
        for effect in candidates:
            lacking = effect.missing(self.record.inputs)
            if lacking:
                self.excluded[effect.name] = ("not_excited", f"the record holds no {', no '.join(lacking)}")
            else:
                self.candidates.append(effect)
        if before is None:
            view = View(self.record, base.model, base.values)
            regressors = [a for effect in steps(self.candidates, "taking signatures") for a in view.regressors(effect)]
        else:
            view, regressors = before.law, before.regressors
        self.law, self.regressors = view, regressors
        self.of_best: list[tuple[Noise, int]] = [] if before is None else before.of_best
        self.noise: Noise = noise or self._noise(view)
        data = view.compress(regressors, self.noise)
        self._drop_unseen(data)
        absorbed = [e for e in self.candidates if self.excluded.get(e.name, ("",))[0] == "absorbed_by_law"]
        self.candidates = [e for e in self.candidates if e.name not in self.excluded]
        self.seen = data.only([k for k, a in enumerate(regressors) if a.effect not in self.excluded])
        others = [e for e in self.candidates if tried is not None and e.name not in tried]
        self.candidates = [e for e in self.candidates if e not in others]
        names, possible = {e.name for e in self.candidates}, self.following.possible
        general, close = {e.special_case_of for e in self.candidates}, possible.issuperset
        alike = [e for e in others if e.special_case_of in names or e.name in general or close(e.follows[:1])]
        self.rivals = [*absorbed, *alike]
        self.data = data.only([k for k, a in enumerate(regressors) if a.effect in names])
        self.empty = self._law_alone()
        self.excess = self._excess()
        base_penalty = 2.0 * np.log(max(len(candidates), 2)) + NAME_MARGIN
        self.penalty = Penalty(
            float(np.log(max(len(self.record), 10))),
            float(base_penalty),
            tolerance(self.excess, len(self.record)),
            before.penalty.odds if before else dict(odds or {}),
        )
        self.cache: dict[tuple[str, ...], FittedSet] = {(): self.empty}
        self.known: dict[tuple[str, ...], FittedSet] = {} if before is None else before.known
        self.blocks: dict[str, FormBlock] = {}
        self.noises: dict[FittedSet, Noise] = {}
        self.plain: dict[tuple[object, ...], Array] = {} if before is None else before.plain
        self.refits = 0

    def _law_alone(self) -> FittedSet:
        """The base model by itself; where noise is slow, it has taken the plain fit along, and is fitted anew."""
        model, values = self.base.model, self.base.values
        squares = self.squares(model, values)
        if self.noise.coloured:
            found = solve(model, self.record.inputs, self.record.force, self.noise.whiten, values, quick=True)
            fitted = self.squares(model, found.values)
            if fitted < squares:
                values, squares = found.values, fitted
        return FittedSet((), values, squares, squares)

    def _excess(self) -> float:
        """Whitened squares beyond the noise that the law alone leaves, without the effects already in the model."""
        alone = self.empty.squares
        if self.base.model.terms:
            law = replace(self.base.model, terms=())
            found = solve(law, self.record.inputs, self.record.force, self.noise.whiten, quick=True)
            alone = max(alone, self.squares(law, found.values))
        return max(alone - len(self.record), 0.0)

    @property
    def weighed(self) -> list[Effect]:
        """Candidates, and what could stand in their place though it is not tried."""
        return [*self.candidates, *self.rivals]

    def aside(self) -> "Selection":
        """The same, where what is fitted counts for no odds of what was tried."""
        other = copy(self)
        other.cache, other.known = dict(self.cache), dict(self.known)
        return other

    def residual(self, model: Model, values: Mapping[str, float]) -> Array:
        """What a model leaves, in N (n,)."""
        return self.record.force - model.force(self.record.inputs, values)

    def squares(self, model: Model, values: Mapping[str, float]) -> float:
        """Whitened sum of squares of a model."""
        left = self.noise.whiten(self.residual(model, values))
        return float(left @ left)

    def refit(
        self,
        terms: Sequence[Term],
        start: Mapping[str, float] | None = None,
        penalty: float | None = None,
        best: float = math.inf,
    ) -> FittedSet:
        """Fit a set exactly, noise whitened, and remember it by its labels; `penalty` overrides its own.

        What has no hope of a criterion near the `best` so far is given up.
        """
        key = tuple(sorted(f"{t.effect.name}:{t.form.name}" for t in terms))
        if penalty is None and key in self.cache and best <= self.cache[key].beyond:
            return self.cache[key]
        self.refits += 1
        tell("weighing sets of effects", self.refits)
        model = self.base.model.adding(*terms)
        begin = self.base.values | dict(start or {})
        if key in self.known:
            begin |= self.known[key].values  # not far from it, whatever the noise
        if penalty is None:
            penalty = self.penalty.total(terms)
        enough = best + HOPELESS - penalty
        inputs, force = self.record.inputs, self.record.force
        solution = solve(model, inputs, force, self.noise.whiten, begin, quick=True, enough=enough)
        squares = self.squares(model, solution.values)
        beyond = math.inf if solution.message != GIVEN_UP else best
        fitted = FittedSet(tuple(terms), solution.values, squares, squares + penalty, beyond)
        known = self.cache.get(key)
        if known is not None and known.squares < squares:  # another start led further
            fitted = replace(known, criterion=known.squares + penalty)
        if any(stands(term, inputs, fitted.values) for term in terms):
            fitted = replace(fitted, criterion=math.inf)
        self.cache[key] = fitted
        if beyond == math.inf:
            self.known.setdefault(key, fitted)
        return fitted

    def in_best_forms(self, fitted: FittedSet) -> FittedSet:
        """The best set of the same names that was fitted."""
        return self.best_of(fitted.names) or fitted

    def best_of(self, names: Collection[str]) -> FittedSet | None:
        """The best set of some names that was fitted, if any was."""
        return min((v for v in self.cache.values() if v.names == names), key=lambda v: v.criterion, default=None)

    @property
    def best_static(self) -> FittedSet:
        """The best set of effects that follow pressure and contraction alone, of those that were fitted."""
        known = [v for v in self.cache.values() if all(t.effect.candidate and t.effect.static for t in v.terms)]
        return min(known, key=lambda v: v.criterion)

    def weight(self, fitted: FittedSet, term: Term) -> float:
        """How much the mean square error of a plain fit grows when a term is left out, as a share of what is left."""
        whole, fewer = (self.plain_square(terms, fitted.values) for terms in (fitted.terms, fitted.without(term)))
        return (fewer - whole) / max(whole, 1e-18)

    def part(self, fitted: FittedSet, term: Term) -> float:
        """Share of the squares that a set explains which only a term does, all others in their best forms."""
        others = [t for t in fitted.terms if t.effect is not term.effect]
        rest = self.in_best_forms(self.refit(others, fitted.values))
        fewer, whole, alone = (self.plain_square(v.terms, v.values) for v in (rest, fitted, self.empty))
        return (fewer - whole) / max(alone - whole, 1e-18)

    def plain_residual(self, terms: Sequence[Term], start: Mapping[str, float]) -> Array:
        """What a set leaves, in N (n,), fitted without whitening."""
        key = (labels(terms), *sorted(start.items()))
        if key not in self.plain:
            clean = ~self.noise.outlier
            model = self.base.model.adding(*terms)
            found = solve(model, self.record.inputs, self.record.force, lambda m: m[clean], start, quick=True)
            self.plain[key] = self.residual(model, found.values)
        return self.plain[key]

    def plain_square(self, terms: Sequence[Term], start: Mapping[str, float]) -> float:
        """The mean square of that in N², outliers aside."""
        return float(np.mean(self.plain_residual(terms, start)[~self.noise.outlier] ** 2))

    def refit_choice(self, data: Compressed, choice: Choice, onto: FittedSet, best: float = math.inf) -> FittedSet:
        """Fit the set `onto` with what a search found on compressed data, from where the search left it, as `refit`."""
        start = dict(onto.values)
        for a, coefficients in zip(choice.regressors, choice.coefficients, strict=True):
            regressor = data.regressors[a]
            start |= {f"{regressor.effect}.{k}": v for k, v in regressor.point.items()}
            start |= {
                f"{regressor.effect}.{p.name}": p.clip(p.neutral + float(x))
                for p, x in zip(regressor.linear, coefficients, strict=True)
            }
        return self.refit([*onto.terms, *(data.regressors[a].term for a in choice.regressors)], start, best=best)

    def beyond(self, fitted: FittedSet, effects: Sequence[Effect], record: Record | None = None) -> Compressed:
        """Signatures of further effects around a set, free of what the set itself can follow; `record` may stand in."""
        model = self.base.model.adding(*fitted.terms)
        view = self.view(fitted) if record is None else View(record, model, fitted.values)
        regressors = [a for e in effects for a in view.regressors(e)]
        return view.singly(regressors, self.noise, self.blocks if record is None else None)

    @lru_cache(maxsize=4)  # noqa: B019 - a selection lives as long as one diagnosis
    def view(self, fitted: FittedSet) -> View:
        """A set's model with its slopes."""
        return View(self.record, self.base.model.adding(*fitted.terms), fitted.values, self.law.kept)

    def noise_left_by(self, fitted: FittedSet) -> Noise:
        """Noise as it must be if a set is the whole truth."""
        if fitted not in self.noises:
            view = self.view(fitted)
            self.noises[fitted] = self.noise_in(view.residual, view, len(fitted.values), self.noise.outlier)
        return self.noises[fitted]

    def _noise(self, view: View) -> Noise:
        """Noise is what the law, surfaces over all drivers and free curves over contraction still leave.

        What an unsure track makes of the force they follow, too. So it is looked for in what surfaces over the
        likeliest drivers leave, and is noise where hardly more is left beside it.
        """
        following = self.following
        free = [] if self.record.inputs.time is None else [following.in_newtons(following.surfaces.matrix)]
        columns = np.hstack([view.law, *free, _free_curves(self.record)])
        many = columns.shape[1] >= len(self.record) // 2
        if many and self.record.inputs.time is None:
            return self.noise_of_best(None)[0]
        left, taken = remainder(view.law if many else columns, view.residual)
        rich = self.noise_in(left, view, taken)
        if rich.shared or following.unsure is None:
            return rich
        best, _ = self.noise_of_best(rich.outlier)
        return best if best.shared and best.sigma**2 <= (1.0 + OTHER_SIZE) * rich.sigma**2 else rich

    def noise_of_best(self, outlier: Array | None) -> tuple[Noise, int]:
        """Noise in what the law and surfaces over the likeliest drivers leave, and how many columns these have.

        It is found once for a record, and so are the samples that are an `outlier` (n,).
        """
        if not self.of_best:
            following, surfaces = self.following, self.following.surfaces
            _, freedom = surfaces.of(following.best)
            left = following.in_newtons(following.left - surfaces.explained(following.best))
            noise = self.noise_in(left, self.law, len(self.base.values) + freedom, outlier)
            self.of_best.append((noise, freedom))
        return self.of_best[0]

    @property
    def criterion_of_best(self) -> float:
        """Deviance of these surfaces with the noise they leave, plus their penalty."""
        noise, freedom = self.noise_of_best(self.noise.outlier)
        return noise.deviance + self.penalty.per_parameter * freedom

    def noise_in(
        self, left: Array, view: View, taken: float, outlier: Array | None = None, white: bool = False
    ) -> Noise:
        """Noise in what (n,) a model of `taken` parameters leaves, in N, where the force is as steep as in a view."""
        unsure, specimen = self.following.unsure, self.record.specimen
        slope = unsure.slope(view.around, specimen) if unsure else view.around.contraction / specimen.initial_length_mm
        return estimate_noise(self.record, left, slope, taken, outlier, white, unsure)

    def _drop_unseen(self, data: Compressed) -> None:
        """Note effects that the law absorbs or the record does not excite."""
        n = np.sqrt(len(self.record))
        for effect in self.candidates:
            left, seen, most = 0.0, 0.0, 0.0
            for a in [i for i, regressor in enumerate(data.regressors) if regressor.effect == effect.name]:
                columns = data.columns([a])
                left = max(left, float(np.max(data.left[columns])))
                sizes, limits = np.array([(p.scale, p.largest) for p in data.regressors[a].linear]).T
                seen = max(seen, float(np.max(data.before[columns] * sizes)) / n)
                most = max(most, float(np.max(data.before[columns] * data.left[columns] * limits)) / n)
            if seen * 30.0 < 0.3:
                self.excluded[effect.name] = ("not_excited", "its signature stays far below the noise in this record")
            elif left < TOO_FLAT and most < UNSEEN:
                self.excluded[effect.name] = (
                    "absorbed_by_law",
                    f"the {self.base.model.law.title} follows it to {percent(1 - left)}",
                )


def stands(term: Term, inputs: Inputs, values: Mapping[str, float]) -> bool:
    """Whether what a form follows hardly changes in a record: a softening that does not fade is a constant force, and
    times a free surface could follow any static error."""
    if not term.form.nonlinear or term.effect.static or term.form.uses_force:
        return False
    state = term.columns(inputs, values, np.zeros(len(inputs)))[:, 0]
    return float(np.ptp(state)) < LEAST_CHANGE * float(np.max(np.abs(state)))


def _free_curves(record: Record) -> Array:
    """Curves over contraction for each branch, constant and in proportion to pressure; over pressure in a table."""
    inputs = record.inputs
    if inputs.time is None:
        along = inputs.pressure if record.block_kind == "length" else inputs.contraction
        places = np.unique(np.column_stack([record.block, inputs.direction]), axis=0)
        masks = [(record.block == block) & (inputs.direction == sign) for block, sign in places]
        terms = 3 if 3 * len(masks) < len(record) // 2 - 8 else 2
        return np.hstack([np.vander(along, terms) * rows[:, None] for rows in masks])
    x = inputs.contraction
    knots = np.linspace(x.min(), x.max(), 13)
    hats = np.maximum(0.0, 1.0 - np.abs(x[:, None] - knots) / (knots[1] - knots[0]))
    moving = np.ones(len(record)) if inputs.moving is None else inputs.moving.astype(float)
    sets = []
    for sign in (1.0, -1.0):
        branch = hats * ((inputs.direction == sign) * moving)[:, None]
        sets += [branch, branch * inputs.pressure[:, None]]
    return np.hstack(sets)
