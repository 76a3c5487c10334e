"""The answer to a record by the effects that are tried, and which of its names stand where it is incomplete."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from ..effects import Effect
from ..fitting import Fit
from ..model import Term
from .adequacy import EVEN, MAY_LEAVE, Adequacy, FreeModel, needless, unknown_instead
from .confounding import groups
from .follows import Following
from .patterns import catalogue as patterns
from .probability import probabilities
from .remainder import remainder_of
from .search import CLOSE
from .select import best_forms, in_spite_of, investigate
from .selection import HOPELESS, FittedSet, Selection


@dataclass(frozen=True)
class Selected:
    """A set and what it was selected from, and the set beside the free model where it is incomplete."""

    selection: Selection
    fitted: FittedSet
    lacking: Adequacy | None


def answer_of(
    alone: Fit,
    candidates: list[Effect],
    known: list[Effect],
    following: Following,
    tried: list[str],
    odds: Mapping[str, float] | None,
) -> Selected:
    """The answer of the effects `tried`, complete or not."""
    selection, fitted = investigate(alone, candidates, following, tried, odds=odds)
    fitted = _likely(selection, fitted)
    instead = unknown_instead(selection, fitted, following, known)
    likely = [t for t in fitted.terms if instead.get(t.effect.name, 0.0) < EVEN]
    if len(likely) < len(fitted.terms):
        fitted = selection.refit(likely, fitted.values)
    whole = all(t.effect.candidate for t in fitted.terms)
    remains = whole and bool(fitted.terms) and remainder_of(selection, fitted) is not None
    lacking = Adequacy.lacking(selection, fitted, remains)
    return Selected(selection, fitted if lacking or remains else _as_followed(selection, fitted), lacking)


def _as_followed(selection: Selection, fitted: FittedSet) -> FittedSet:
    """Of a complete set and those, as complete, with one name exchanged that the record does not tell from it, the one
    of which most names follow first what the likeliest drivers hold: at one speed dry friction, no damping."""
    if selection.record.inputs.time is None:
        return fitted
    free = FreeModel.of(selection)
    chosen, shared = selection.following.chosen, len(fitted.terms) - 1
    alike = [v for v in selection.cache.values() if len(v.terms) - 1 == shared <= len(v.names & fitted.names)]
    close = [v for v in alike if v.criterion < fitted.criterion + CLOSE and v.names == v.candidates]

    def order(one: FittedSet) -> tuple[int, float]:
        return -sum(not chosen.isdisjoint(_first(t)) for t in one.terms), one.criterion

    better = sorted((v for v in close if order(v)[0] < order(fitted)[0]), key=order)
    return next((v for v in better if Adequacy(selection, v, free).complete), fitted)


def _first(term: Term) -> tuple[str, ...]:
    """What a term follows first: a pattern its coordinate."""
    return term.effect.follows[:1] if term.effect.candidate else (patterns()[term.effect.name].along(term.form),)


def likelier_instead(answer: Selected, others: list[Effect]) -> list[str]:
    """Of others that were not tried, by name, those that explain more in the place of a name, or of all.

    Strokes from end to end lead over the same places each way: curves over the place, in each direction, then imitate
    what builds up along the way. Surfaces do not tell which of these the force follows; written forms do.
    """
    selection, fitted = answer.selection, answer.fitted
    written = [replace(effect, forms=effect.written) for effect in others if effect.written]
    if not written:
        return []
    aside = selection.aside()
    most, found = fitted.criterion, set()
    smaller = dict.fromkeys([(), *(tuple(fitted.without(term)) for term in fitted.terms)])  # each once, in order
    for fewer in smaller:
        rest = aside.refit(fewer, fitted.values)
        data = selection.beyond(rest, written)
        for choice in best_forms(data, selection.penalty, range(len(data.regressors))):
            near = choice.criterion < most + HOPELESS
            if near and aside.refit_choice(data, choice, rest, most).criterion < most - CLOSE:
                found.update(data.regressors[k].effect for k in choice.regressors)
    return sorted(found)


def standing(answer: Selected, candidates: list[Effect], lacking: Adequacy) -> tuple[Selection, Adequacy]:
    """Of an incomplete answer the names that stand, and what they are selected from.

    Of those that what is left does not overturn, one for each driver: two together can imitate much.
    """
    share = lacking.comes_back
    if answer.fitted.terms and share > answer.selection.noise.too_small:
        selection, fitted = in_spite_of(answer.selection, candidates, answer.fitted, lacking.residual, share)
        heaviest = {t.effect.follows[:1]: t for t in sorted(fitted.terms, key=lambda t: selection.weight(fitted, t))}
        fitted = selection.refit(list(heaviest.values()), fitted.values)
        firm = replace(lacking, fitted=fitted)
        if all(t.effect.candidate for t in fitted.terms) and firm.unexplained[1] < MAY_LEAVE[-1]:
            return selection, firm
    return answer.selection, lacking.standing()


def _likely(selection: Selection, fitted: FittedSet) -> FittedSet:
    """The set without what is likelier out than in, all fits weighed, or needless beside the drivers of the others; the
    likeliest name stays."""
    named = [t for t in fitted.terms if t.effect.candidate]
    if len(named) < 2:
        return fitted
    chance = probabilities(selection, groups(selection, fitted))
    for term in sorted(named, key=lambda t: chance[t.effect.name])[:-1]:
        others = [t for t in fitted.terms if t.effect is not term.effect]
        rest = selection.in_best_forms(selection.refit(others, fitted.values))
        if chance[term.effect.name] < 0.5 or needless(selection, term.effect, rest):
            fitted = rest
    return fitted
