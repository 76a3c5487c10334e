"""Which names of an answer stand by held-out data and by nature, and the fit with these."""

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from operator import itemgetter

from ..core.param import Param, Range
from ..fitting import Fit, fit
from ..fitting.estimate import Estimate, impossible
from ..model import Model, Term
from .adequacy import Adequacy, FreeModel
from .heldout import SHORT, fit_quickly, heldout_rmse, in_best_forms
from .nouns import Pattern
from .search import CLOSE
from .select import RIVALS
from .selection import FittedSet, Selection
from .steady import looked_at


def allowed_by_nature(
    base: Fit, heldout: float, selection: Selection, fitted: FittedSet, instead: Callable[[FittedSet], bool]
) -> tuple[FittedSet, tuple[Fit, float, list[Term], dict[str, Fit]]]:
    """A set, and what `_possible` finds of it. In place of one with a value that nature does not allow it is the best
    without, of those that may stand `instead` and that the record does not tell from it, all its names confirmed but
    those that are too small in the first, too."""
    least = selection.noise.too_small * selection.noise.whole**2

    def found(one: FittedSet) -> tuple[Fit, float, list[Term], dict[str, Fit]]:
        named = [t for t in one.terms if t.effect.candidate]
        named.sort(key=lambda t: -selection.weight(one, t))
        return _possible(base, heldout, named, one, least)

    first = found(fitted)
    _, _, stand, ruled_out = first
    if ruled_out:
        wrong = _ruled_out(ruled_out, fitted)
        near = [v for v in selection.cache.values() if v.terms and v.criterion < fitted.criterion + CLOSE]
        close = [v for v in near if instead(v) and not any(_outside(e, v.values) for e in wrong)]
        small = fitted.candidates.difference(ruled_out, (t.effect.name for t in stand))
        for one in [*sorted(close, key=lambda v: v.criterion)[:RIVALS], *_in_other_forms(selection, fitted, ruled_out)]:
            other = found(one)
            if not other[-1] and one.candidates <= small.union(t.effect.name for t in other[-2]):
                return one, other
    return fitted, first


def _outside(estimate: Estimate, values: Mapping[str, float]) -> bool:
    """Whether nature does not allow an estimate's value among others."""
    end = estimate.range
    return end is not None and not end.low <= values.get(estimate.name, end.low) <= end.high


def _in_other_forms(selection: Selection, fitted: FittedSet, wrong: Collection[str]) -> list[FittedSet]:
    """A set with each of some names in each other form, those that explain as much, best first; of a single name those
    that are complete, too: a form that nature does not allow is none, so what it leaves is no measure for the others,
    but two names together can imitate much."""
    found, alone = [], len(fitted.terms) == 1 and selection.record.inputs.time is not None
    for term in (t for t in fitted.terms if t.effect.name in wrong):
        others = [Term(term.effect, form) for form in term.effect.forms if form is not term.form]
        found += [selection.refit([*fitted.without(term), one], fitted.values) for one in others]

    def may_be(one: FittedSet) -> bool:
        if one.squares < fitted.squares + CLOSE:
            return True
        return alone and one.criterion < math.inf and Adequacy(selection, one, FreeModel.of(selection)).complete

    return sorted(filter(may_be, found), key=lambda v: v.criterion)


def _possible(
    base: Fit, heldout: float, named: list[Term], fitted: FittedSet, least: float
) -> tuple[Fit, float, list[Term], dict[str, Fit]]:
    """What `_confirmed` finds once every name has gone whose value nature does not allow, and the fits with those."""
    ruled_out: dict[str, Fit] = {}
    while True:
        best, after, named = _confirmed(base, heldout, named, fitted, least)
        best = _as_nature_allows(best, _beyond_nature(best, fitted))
        wrong = {e.name.partition(".")[0] for e in _beyond_nature(best, fitted)} & {t.effect.name for t in named}
        if not wrong:
            return best, after, named, ruled_out
        ruled_out |= dict.fromkeys(sorted(wrong), best)
        named = [t for t in named if t.effect.name not in wrong]


def _as_nature_allows(best: Fit, wrong: list[Estimate]) -> Fit:
    """The fit within nature's ranges, what ends there held, where that is as likely: of κ and τ of a fast lag, say,
    only the product shows, and of a swing that is far longer than the record only its bend."""
    ranges = {e.name: e.range for e in wrong if e.range}
    if not ranges:
        return best
    named = {name.partition(".")[0] for name in ranges}
    terms = tuple(_within(t, ranges) if t.effect.name in named else t for t in best.model.terms)
    start = {k: v for k, v in best.values.items() if k.partition(".")[0] not in named}
    law = {k: min(max(best.values[k], r.low), r.high) for k, r in ranges.items() if "." not in k}
    inside = fit(replace(best.model, terms=terms), best.record, start=start, held=law)
    ends = law | {e.name: e.value for e in inside.estimates if e.name in ranges and e.at_bound}
    held = fit(best.model, best.record, start=inside.values, held=ends)
    less_likely = 2.0 * len(best.record) * math.log(held.rmse / best.rmse)
    return held if less_likely < CLOSE else best


def _within(term: Term, ranges: Mapping[str, Range]) -> Term:
    """A term whose parameters are searched within some ranges, by name."""

    def bounded(p: Param) -> Param:
        found = ranges.get(f"{term.effect.name}.{p.name}")
        if found is None:
            return p
        low, high = max(p.lower, found.low), min(p.upper, found.high)
        return replace(p, lower=low, upper=high, start=min(max(p.start, low), high))

    form = term.form
    linear, nonlinear = tuple(map(bounded, form.linear)), tuple(map(bounded, form.nonlinear))
    return replace(term, form=replace(form, linear=linear, nonlinear=nonlinear))


def _beyond_nature(fit: Fit, fitted: FittedSet) -> list[Estimate]:
    """Estimates that nature does not allow, nor their value by the steady inputs: a noisy gauge bends an estimate."""
    return [e for e in fit.impossible if e.name not in fitted.values or _outside(e, fitted.values)]


def _ruled_out(ruled_out: Mapping[str, Fit], fitted: FittedSet) -> list[Estimate]:
    """The estimates of effects that nature does not allow, by name with the fit that holds them."""
    found = ((name, e) for name, one in ruled_out.items() for e in _beyond_nature(one, fitted))
    return [e for name, e in found if e.name.startswith(f"{name}.")]


def impossible_alone(base: Fit, best: Fit, fitted: FittedSet, ruled_out: Mapping[str, Fit]) -> Pattern | None:
    """What only values that nature does not allow would explain, and those of the model itself."""
    wrong = [*_beyond_nature(best, fitted), *_ruled_out(ruled_out, fitted)]
    said = {e.name: impossible(e) for e in wrong}
    share = max([0.0, *((best.rmse**2 - one.rmse**2) / max(base.rmse**2, 1e-18) for one in ruled_out.values())])
    return Pattern("other", "contraction", None, "", share, "; ".join(said.values())) if said else None


def _confirmed(
    base: Fit, heldout: float, named: list[Term], fitted: FittedSet, least: float
) -> tuple[Fit, float, list[Term]]:
    """Fit, held-out error and names once every name has gone of which less than `least` (N²) of the mean square error
    comes, as steady inputs round the corners of a drive; in a short table every name without which held-out data are
    predicted better, and these choose the forms, too. In time what a cycle leaves to be foretold at an end of the
    record says nothing of a name.
    """
    table = base.record.inputs.time is None and len(base.record) <= SHORT and not math.isnan(heldout)

    def attempt(terms: list[Term]) -> tuple[float, Fit, list[Term]]:
        if not terms:
            return heldout, base, terms
        terms = in_best_forms(base, terms) if table else terms
        found = _onto(base, terms, fitted)
        return heldout_rmse(found.model, base.record, found), found, terms

    if not table:
        named = _large_enough(base, named, fitted, least)
    after, best, named = attempt(named)
    while named and table and not after < heldout:
        attempts = [attempt([t for t in named if t is not gone]) for gone in named]
        after, best, named = min(attempts, key=itemgetter(0))
    return best, after, named


def _large_enough(base: Fit, named: list[Term], fitted: FittedSet, least: float) -> list[Term]:
    """The names that are left once every one has gone of which less than `least` (N²) of the mean square error comes,
    by quick fits."""
    record = looked_at(base.record)

    def left(terms: list[Term]) -> float:
        return fit_quickly(base.model.adding(*terms), record, base.values | _start(fitted, terms))[1] ** 2

    whole = left(named)
    while named:
        error, gone = min(((left([t for t in named if t is not one]), one) for one in named), key=itemgetter(0))
        if error - whole >= least:
            break
        whole, named = error, [t for t in named if t is not gone]
    return named


def _onto(base: Fit, terms: list[Term], fitted: FittedSet) -> Fit:
    """A base fit with some terms of a set."""
    return fit_onto(base, base.model.adding(*terms), _start(fitted, terms)) if terms else base


def fit_onto(base: Fit, model: Model, start: Mapping[str, float]) -> Fit:
    """Fit of a model that holds more than a `base` fit, begun at `start`; where that ends worse, at the base's values.

    Raises FitError and DataError as `fit` does.
    """
    found = fit(model, base.record, start=start)
    return found if found.rmse <= base.rmse else fit(model, base.record, start=base.values)


def _start(fitted: FittedSet, named: list[Term]) -> dict[str, float]:
    names = {f"{t.effect.name}." for t in named}
    return {k: v for k, v in fitted.values.items() if "." not in k or any(k.startswith(n) for n in names)}
