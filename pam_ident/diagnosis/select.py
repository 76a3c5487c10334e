"""From candidates to the set that explains the record: search, exact refits, and second thoughts."""

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from ..effects import AddsForce, Effect
from ..fitting import Fit
from ..fitting.floor import SHAPES, repeats
from ..model import Term
from .adequacy import Adequacy, FreeModel, full_criterion, larger_than_noise
from .follows import Following
from .noise import Noise
from .patterns import catalogue as catalogue_of_patterns
from .patterns import patterns
from .remainder import unlike_noise
from .scan import Remainder, Scanned, scan
from .search import CLOSE, Choice, Compressed, Penalty, beam_search, evaluate
from .selection import FORM_TOLERANCE, HOPELESS, FittedSet, Selection, labels
from .spectrum import beats
from .tails import deviance_saved

MOST = 3
"""Names in an answer, at most."""
SURE = 500.0
"""Criterion by which noise must lose against a name, as fitted without it, to be left aside: where it won at last, it
had lost by 160 at most."""
EXPLAINED = 3.0
"""Whitened squares beyond their number, in standard deviations, up to which nothing is left."""
RIVALS = 3
"""Rivals of other names that are refined."""
NEXT = 4
"""Sets that came next to an answer, by its noise, and are compared by their full likelihood, too, if complete."""
FORMS = 4
"""Forms of an effect that are fitted in place of another."""
PATTERN_TOLERANCE, FAULT_TOLERANCE = 0.04, 0.01
"""The share that an unknown pattern must earn: more than a known effect in an unforeseen form would leave, where it
adds a force as if drawn by hand; as much as two names, where it is a fault of a sensor, with the law's own slopes, or
a ripple, which no smooth form leaves, or takes the place of names with no fewer parameters; and none where these have
more, and it leaves noise alone."""


def investigate(
    base: Fit,
    candidates: Sequence[Effect],
    following: Following | None = None,
    tried: Collection[str] | None = None,
    odds: Mapping[str, float] | None = None,
) -> tuple[Selection, FittedSet]:
    """The answer to a record, with the noise and the effects made to agree.

    Slow noise and an effect can each pass for the other. So where noise is coloured, or a faint answer may be what its
    colour is, the record is judged again against the noise that the law alone would imply, and against that which the
    answer then leaves; the answers, all their parts and what came next to them, fitted against the first or the
    likeliest of these noises, are then compared by their full likelihood, each with its own noise. Nothing of this
    where no noise could take the place of any name: a little colour is what a form leaves that is not exactly right.
    Nor where the answer is no noise, and the free model is likelier than each of its parts with the noise that it
    leaves: noise is then what that leaves. So it may be where what the likeliest leaves does not look like its noise.
    """
    selection = Selection(base, candidates, following, tried, odds=odds)
    fitted = _answer(selection)
    may_be_noise = _may_be_noise(selection, fitted)
    doubtful = may_be_noise or selection.noise_left_by(fitted).coloured
    if not selection.noise.coloured and (not doubtful or _sure(selection, fitted)):
        return selection, fitted
    selections = [(selection, fitted)]

    def select_again(noise: Noise) -> None:
        """Or not, where noise is larger than all that the law leaves, or was taken before."""
        if noise.whole <= base.rmse and not any(noise.like(before.noise) for before, _ in selections):
            again = Selection(base, candidates, noise=noise, before=selection)
            selections.append((again, _answer(again)))

    free = FreeModel.of(selection) if selection.record.inputs.time is not None else None
    if free and free.criterion + CLOSE < (compared := _compared(selections))[0][0]:
        if free.noise.whole < selection.noise.whole:
            select_again(free.noise)
        final, _ = selections[-1]
        if not may_be_noise:
            _, _, likeliest = (compared if final is selection else _compared(selections))[0]
            return final, final.refit(likeliest.terms, likeliest.values)
    select_again(selection.noise_left_by(selection.empty))
    last, answer = selections[-1]
    select_again(last.noise_left_by(answer))
    _, noise, found = _compared(selections)[0]
    final = Selection(base, candidates, noise=noise, before=selection)
    seen = [t for t in found.terms if t.effect.name not in final.excluded]  # by this noise the law may follow one
    fitted = final.refit(seen, found.values)
    if free and free.noise.whole < noise.whole and unlike_noise(final, fitted):
        select_again(free.noise)
        calm = [both for both in selections if both[1].terms and unlike_noise(*both) is None]
        stand = [one for one in (Adequacy(*both, free) for both in calm) if one.complete and not one.wanders]
        best = min(stand, key=lambda one: full_criterion(one.selection, one.fitted)[0], default=None)
        return (best.selection, best.fitted) if best else (final, fitted)
    return final, fitted


def in_spite_of(
    selection: Selection,
    candidates: Sequence[Effect],
    fitted: FittedSet,
    left: np.ndarray,
    share: float,
) -> tuple[Selection, FittedSet]:
    """The answer that is not overturned by what a set leaves, `left` (n,) in N, of whose squares repeats share that
    `share`.

    It is no noise, so forms are not exactly right, those of rivals no more than its own. What they miss is the same in
    every repeat: it has SHAPES degrees of freedom in each group of repeats, and over these the variance that a
    difference between two sets must stand out from (overdispersion: McCullagh & Nelder 1989, section 4.5). Of sets that
    it does not tell apart that with the fewest names is taken.
    """
    outlier = selection.noise.outlier
    white = selection.noise_in(left, selection.law, len(fitted.values), outlier, white=True)
    freedom = SHAPES * max(len(repeats(selection.record, ~outlier)), 1)
    over = math.sqrt(1.0 + share / max(1.0 - share, 1e-3) * len(left) / freedom)
    noise = replace(white, sigma=over * white.sigma, whole=min(white.whole, selection.noise.whole))
    again = Selection(selection.base, candidates, noise=noise, before=selection)
    found = _answer(again)
    return again, min(_as_good(again, found), key=lambda v: (len(v.terms), v.criterion), default=found)


def _may_be_noise(selection: Selection, fitted: FittedSet) -> bool:
    """Whether slow noise could explain all that a set does."""
    if not selection.noise_left_by(selection.empty).coloured:
        return False
    return full_criterion(selection, selection.empty)[0] < full_criterion(selection, fitted)[0] + SURE


def _compared(selections: Sequence[tuple[Selection, FittedSet]]) -> list[tuple[float, Noise, FittedSet]]:
    """All answers, all their parts and complete sets next to them by their full criterion, least first, each with the
    noise that it leaves."""
    sets = {labels(terms): (terms, v.values) for _, v in reversed(selections) for terms in _subsets(v.terms)}
    every = [selection for selection, _ in selections]
    fits = [_likeliest(every, terms, start) for terms, start in sets.values()]
    rivals: list[tuple[Selection, FittedSet]] = []
    for selection in every if selections[0][0].record.inputs.time is not None else ():
        named = [v for v in selection.cache.values() if v.names == v.candidates]
        for near in sorted(named, key=lambda v: v.criterion)[:NEXT]:
            if labels(near.terms) not in sets:
                sets[labels(near.terms)] = near.terms, near.values
                rivals.append(_likeliest(every, near.terms, near.values))
    fits += [one for one in rivals if Adequacy(*one, FreeModel.of(one[0])).complete]
    noises = [(selection, found) for selection, found in fits if not larger_than_noise(selection, found)]
    weighed = [(*full_criterion(selection, found), found) for selection, found in noises or fits]
    largest = selections[0][0].base.rmse
    possible = [item for item in weighed if item[1].whole <= largest or not item[2].terms]
    return sorted(possible or weighed, key=lambda item: item[0])


def _sure(selection: Selection, fitted: FittedSet) -> bool:
    """Whether a set is far likelier than without any one of its terms, each with the noise that it leaves."""
    criterion, _ = full_criterion(selection, fitted)
    fewer = [selection.refit(fitted.without(term), fitted.values) for term in fitted.terms]
    return bool(fewer) and all(full_criterion(selection, rest)[0] > criterion + SURE for rest in fewer)


def _likeliest(
    selections: Sequence[Selection], terms: Sequence[Term], start: Mapping[str, float]
) -> tuple[Selection, FittedSet]:
    """The likelier fit of a set, against the first noise of some selections' or that by which it is then likeliest; and
    that selection. Against slow noise a fit may leave to it what the set can explain."""
    first_of = selections[0]
    first = first_of.refit(terms, start)
    left = first_of.residual(first_of.base.model.adding(*terms), first.values)

    def deviance(selection: Selection) -> float:
        white = selection.noise.whiten(left)
        return float(white @ white) + selection.noise.volume

    best = min(selections, key=deviance)
    fits = [(best, best.refit(terms, first.values)), (first_of, first)]
    return min(fits, key=lambda one: full_criterion(*one)[0])


def _subsets(terms: Sequence[Term]) -> list[tuple[Term, ...]]:
    return [some for size in range(len(terms) + 1) for some in combinations(terms, size)]


def _answer(selection: Selection) -> FittedSet:
    """The best set of effects, or of effects and a pattern."""
    fitted = _refined(selection, _fitted_leaders(selection))
    return find_pattern(selection, fitted) or fitted


def _beyond_noise(selection: Selection, squares: float) -> float:
    """Whitened squares beyond those of noise, in their standard deviations."""
    n = len(selection.record)
    return (squares - n) / float(np.sqrt(2.0 * n))


def _fitted_leaders(selection: Selection) -> list[FittedSet]:
    """The leading sets of up to MOST effects in a compressed search, and the law alone, fitted, best first."""
    pool: list[FittedSet] = []
    for choice in _leaders(selection, beam_search(selection.data, selection.penalty, MOST)):
        second = sorted(v.criterion for v in [selection.empty, *pool])[:2][-1]
        pool.append(selection.refit_choice(selection.data, choice, selection.empty, second))
    return sorted([selection.empty, *pool], key=lambda v: v.criterion)


def _refined(selection: Selection, leaders: Sequence[FittedSet]) -> FittedSet:
    """The best set that the first leaders can be made into: the next, and those that come close."""
    first, *others = *leaders, selection.empty
    best = _refine(selection, first)
    rivals = [v for k, v in enumerate(others) if k == 0 or v.criterion < first.criterion + HOPELESS]
    for rival in rivals[:RIVALS]:
        # What a rival has beyond the first is tried on the first, too.
        if not first.terms or not first.exclusion_groups <= rival.exclusion_groups:
            best = min(best, _refine(selection, rival), key=lambda v: v.criterion)
    return best


def _leaders(selection: Selection, choices: Sequence[Choice]) -> list[Choice]:
    """The best choice of each of the leading sets of names, the best single effects always among them."""
    kept: dict[frozenset[str], Choice] = {}
    count = {1: 0, 2: 0, 3: 0}
    limit = {1: 5, 2: 4, 3: 3}
    for choice in choices:
        names = frozenset(selection.data.regressors[a].effect for a in choice.regressors)
        size = len(names)
        if names and names not in kept and count[size] < limit[size]:
            kept[names] = choice
            count[size] += 1
    return list(kept.values())


def _refine(selection: Selection, fitted: FittedSet) -> FittedSet:
    """Drop, exchange the form of, and add effects as long as that makes the set cheaper."""
    for _ in range(4):
        fewer = [selection.refit(fitted.without(term), fitted.values, best=fitted.criterion) for term in fitted.terms]
        rivals = [*fewer, *_in_other_forms(selection, fitted, fewer), *_special_cases(selection, fitted)]
        if len(fitted.terms) < MOST:
            rivals += _additions(selection, fitted)
        best = min(rivals, key=lambda v: v.criterion, default=fitted)
        if best.criterion >= fitted.criterion - 1e-6:
            rivals = [one for rest in fewer if rest.terms for one in _additions(selection, rest)]
            best = min(rivals, key=lambda v: v.criterion, default=fitted)
        if best.criterion >= fitted.criterion - 1e-6:
            return fitted
        fitted = best
    return fitted


def _in_other_forms(selection: Selection, fitted: FittedSet, fewer: Sequence[FittedSet]) -> list[FittedSet]:
    """The set with each term in another form, or one of its exclusion group: of each effect those FORMS that explain
    most of what the others, `fewer` by that term, leave."""
    found = []
    for term, rest in zip(fitted.terms, fewer, strict=True):
        alike = {
            e.name: e for e in (term.effect, *selection.candidates) if e.exclusion_group == term.effect.exclusion_group
        }
        data = selection.beyond(rest, list(alike.values()))
        others = [k for k, one in enumerate(data.regressors) if one.term.form is not term.form]
        found += [
            selection.refit_choice(data, choice, rest, fitted.criterion)
            for choice in best_forms(data, selection.penalty, others)
        ]
    return found


def _special_cases(selection: Selection, fitted: FittedSet) -> list[FittedSet]:
    """The set with a term exchanged for another effect that follows the same first, in a form of fewer parameters with
    the same nonlinear ones, from where they stand: a search that begins elsewhere may not find that it does as well."""
    found = []
    for term in fitted.terms:
        rest, name, own = fitted.without(term), term.effect.name, {p.name for p in term.form.nonlinear}
        taken = {t.effect.exclusion_group for t in rest}
        alike = [e for e in selection.candidates if e.follows[:1] == term.effect.follows[:1] and e.name != name]
        others = [e for e in alike if e.exclusion_group not in taken]
        for effect, form in ((e, f) for e in others for f in e.forms if len(f.params) < len(term.form.params)):
            names = {p.name for p in form.nonlinear}
            if names and names <= own:
                start = {f"{effect.name}.{p}": fitted.values[f"{name}.{p}"] for p in names}
                terms = [*rest, Term(effect, form)]
                found.append(selection.refit(terms, fitted.values | start, best=fitted.criterion))
    return found


def best_forms(data: Compressed, penalty: Penalty, regressors: Iterable[int]) -> list[Choice]:
    """Some regressors, each by itself, best first: of each effect in those FORMS that explain most."""
    taken: dict[str, set[str]] = {}
    found = []
    for choice in sorted(evaluate(data, penalty, [(k,) for k in regressors]), key=lambda choice: choice.criterion):
        term = data.regressors[choice.regressors[0]].term
        forms = taken.setdefault(term.effect.name, set())
        if term.label not in forms and len(forms) < FORMS:
            forms.add(term.label)
            found.append(choice)
    return found


def _additions(selection: Selection, fitted: FittedSet) -> list[FittedSet]:
    data = selection.beyond(
        fitted, [e for e in selection.candidates if e.exclusion_group not in fitted.exclusion_groups]
    )
    choices = [c for c in beam_search(data, selection.penalty, 1) if c.regressors and c.gain > selection.penalty.least]
    return [selection.refit_choice(data, c, fitted, fitted.criterion) for c in choices[:2]]


def find_pattern(selection: Selection, fitted: FittedSet) -> FittedSet | None:
    """The set with the best pattern added, when that earns its penalty; names the pattern makes needless are dropped.

    The pattern is looked for on what the set leaves and, lest the set has mopped it up, on what the law leaves.
    """
    scans: list[tuple[float, float, Scanned]] = []
    remainders = [Remainder(selection, start) for start in {v.names: v for v in (fitted, selection.empty)}.values()]
    time = selection.record.inputs.time
    lines = (
        [] if time is None else [period for remainder in remainders for period in beats(time, remainder.view.residual)]
    )
    unsure = selection.following.unsure
    known = min(sum(len(t.form.params) for t in v.terms) for v in (fitted, *_as_good(selection, fitted)))
    for effect in patterns(selection.record.inputs, lines, unsure.sensor_mm if unsure else 0.0):
        for scanned in scan(effect, remainders):
            penalty = _pattern_penalty(selection, scanned, known)
            scans.append((scanned.onto.criterion - scanned.gain + penalty, penalty, scanned))
    scans.sort(key=lambda item: item[0])
    best = fitted
    for criterion, penalty, scanned in scans[:4]:
        if criterion < best.criterion + CLOSE + FORM_TOLERANCE * selection.excess:
            found = _with_pattern(selection, scanned, penalty)
            if found.criterion < best.criterion:
                best = found
    return best if best.criterion < fitted.criterion and _outlives_tails(selection, best, fitted) else None


def _outlives_tails(selection: Selection, found: FittedSet, fitted: FittedSet) -> bool:
    """Whether a set with a pattern is better than one without by what is not the noise's tails, too, nor one sample or
    two.

    A pattern may be as short as a few samples, and of all places it is tried at the one where noise was far off.
    """
    read = ~selection.noise.outlier
    before, after = (selection.noise.whiten(selection.view(v).residual)[read] for v in (fitted, found))
    others = np.argsort(before**2 - after**2)[:-2]
    saved = deviance_saved(before[others], after[others])
    return saved - (fitted.squares - found.squares) > found.criterion - fitted.criterion


def _as_good(selection: Selection, fitted: FittedSet) -> list[FittedSet]:
    """Sets of names, looked at before, that a set is no likelier than."""
    named = [v for v in selection.cache.values() if v.terms and v.names == v.candidates]
    return [v for v in named if v.criterion < fitted.criterion + CLOSE]


def _pattern_penalty(selection: Selection, scanned: Scanned, known: int) -> float:
    """What a pattern must earn, beside names of so many parameters, `known`."""
    search = 2.0 * float(np.log(max(scanned.tried, 2)))
    more = scanned.regressor.free - known if not scanned.onto.terms else 1
    term = scanned.regressor.term
    fault = not isinstance(term.form, AddsForce) or catalogue_of_patterns()[term.effect.name].kind == "periodic"
    simpler = more < 0 and _beyond_noise(selection, scanned.onto.criterion - scanned.gain) < EXPLAINED
    tolerance = (FAULT_TOLERANCE if fault or more <= 0 else PATTERN_TOLERANCE) * selection.excess
    if simpler:
        tolerance = selection.penalty.tolerance
    return CLOSE + search + tolerance + selection.penalty.per_parameter * scanned.regressor.free


def _with_pattern(selection: Selection, scanned: Scanned, penalty: float) -> FittedSet:
    """Fit a pattern with the set it was found beyond, then without each of the set's names in turn.

    A name must earn as much as the pattern: what an unknown effect has beyond a pattern's shape is no effect's."""
    terms = list(scanned.onto.terms)
    fitted = selection.refit([*terms, scanned.regressor.term], scanned.start, penalty + selection.penalty.total(terms))
    for gone in list(terms):
        fewer = [t for t in terms if t is not gone]
        paid = penalty + selection.penalty.total(fewer)
        rival = selection.refit([*fewer, scanned.regressor.term], fitted.values, paid)
        if rival.criterion < fitted.criterion + PATTERN_TOLERANCE * selection.excess:
            terms, fitted = fewer, rival
    return fitted
