"""Which effect is missing, how sure that is, and what is left."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial

from ..core import UsageError
from ..core.threads import one_blas_thread
from ..effects import Effect, catalogue, get_effect
from ..fitting import Fit, fit
from ..fitting.carried import driven, nearer
from ..model import Model
from ..records import Record
from .adequacy import EVEN, unknown_instead
from .answer import Selected, answer_of, likelier_instead, standing
from .confirmed import allowed_by_nature
from .experiment import after_pattern, next_experiment
from .follows import Following
from .heldout import heldout_rmse
from .nouns import Diagnosis
from .outcome import Outcome
from .selection import FittedSet
from .sentence import could_be_tried
from .steady import steadied

ANOTHER_RIG = " It takes a rig that drives the length while the pressure is held."


@one_blas_thread()
def diagnose(
    model: Model,
    record: Record,
    extra: tuple[Effect, ...] = (),
    without: tuple[str, ...] = (),
    only: tuple[str, ...] = (),
    odds: Mapping[str, float] | None = None,
    also: tuple[str, ...] = (),
    detail: bool = True,
    noise_N: float = math.inf,
    start: Mapping[str, float] | None = None,
) -> Diagnosis:
    """Which effects of the catalogue a model lacks on a record, or that it lacks none, or one that is not known.

    Candidates are judged on the record's steady inputs, against noise whose size and colour are estimated with them;
    the fits in the answer are to the record as measured.

    Args:
        model: a law, with the effects that are known already.
        record: what it is held against.
        extra: effects of the user's own, tried beside the catalogue's.
        without: names of effects, or of forms (`name:form`), that are not tried, because the rig cannot have them.
        only: names of the only effects, or forms, that are tried; all where none is named.
        odds: prior odds of effects by name, above 0, over those that any other has: 10 for one that the rig is known
            to have, 0.1 for one that would surprise.
        also: names of effects, or forms, that are tried beside the candidates; `only` may name these, too.
        detail: whether errors of every candidate, the next experiment and what else to try are wanted, which choose
            nothing.
        noise_N: the record's noise in N as it was told before, with fewer effects in the model: none larger is told.
        start: values of the model's parameters where its fit begins, by default as `fit` begins.

    Raises:
        FitError: when the record cannot identify the law at all.
        DataError: when an effect of the model needs what the record does not hold.
        UsageError: for an unknown name, or odds that are none.

    Example:
        >>> from pam_ident.diagnosis import diagnose
        >>> from pam_ident.model import Model
        >>> from pam_ident.records import read_record
        >>> from pam_ident.records import thinned
        >>> from pam_ident.records.datasets import dataset_record
        >>> record = thinned(read_record(dataset_record("hidden_effect")), 1000)
        >>> found = diagnose(Model.build("exponential_law"), record)
        >>> print(f"{found.verdict}: {found.selected}, {found.base.rmse:.1f} → {found.best.rmse:.1f} N")
        missing_effect: ('pressure_friction',), 5.8 → 2.1 N
    """
    steps = diagnosing(model, record, extra, without, only, odds, also, noise_N, start=start)
    found = next(steps)
    return next(steps) if detail else found


def diagnosing(
    model: Model,
    record: Record,
    extra: tuple[Effect, ...] = (),
    without: tuple[str, ...] = (),
    only: tuple[str, ...] = (),
    odds: Mapping[str, float] | None = None,
    also: tuple[str, ...] = (),
    noise_N: float = math.inf,
    along: bool = False,
    start: Mapping[str, float] | None = None,
) -> Iterator[Diagnosis]:
    """What `diagnose` finds without its details, and then the same with them.

    Raises FitError, DataError or UsageError as `diagnose` does.
    """
    for name, chance in (odds or {}).items():
        get_effect(name, extra)
        if not 0.0 < chance < math.inf:
            raise UsageError(f"prior odds of {name} are {chance}; expected a number above 0, 1 for any other effect's")
    allowed = _allowed(extra, without, only, also)
    record = driven(model, record)
    base = fit(model, record, start=start)
    model = base.model
    fresh = [e for e in allowed if e.candidate and e.name not in model.effect_names]
    candidates = [effect.shown_by(record.inputs) for effect in fresh]
    if record.inputs.locked:
        candidates = [_one_a_driver(effect) for effect in candidates]
    steady, unsure = steadied(record, model, base.values)
    alone = fit(model, steady, start=base.values, detail=False)
    following = Following(steady, model, alone.values, unsure)
    seen = [e for e in candidates if not e.missing(record.inputs)]
    known = [*seen, *(term.effect for term in model.terms)]
    answer = _selected(alone, candidates, seen, known, following, odds)
    selection, fitted, lacking = answer.selection, answer.fitted, answer.lacking
    if lacking:
        selection, lacking = standing(answer, candidates, lacking)
        fitted = lacking.fitted
    heldout = heldout_rmse(model, record, base)

    def instead(one: FittedSet) -> bool:
        return not lacking and max(unknown_instead(selection, one, following, known).values(), default=0.0) < EVEN

    fitted, (best, after, named, ruled_out) = allowed_by_nature(base, heldout, selection, fitted, instead)
    if record.carried and not along and (static := answer.selection.best_static).terms:
        shifted = nearer(model.adding(*static.terms), record, static.values)
        again = diagnosing(model, shifted, extra, without, only, odds, also, noise_N, along=True)
        found = next(again)
        if found.best.rmse <= best.rmse:
            yield found
            yield from again
            return
    outcome = Outcome(
        base, best, heldout, after, following, known, answer, selection, fitted, lacking, named, ruled_out, noise_N
    )
    while outcome.pattern and outcome.by_form:
        outcome = _without_most_doubtful(outcome)
    found = outcome.diagnosis(candidates, (*extra, *model.own))
    yield found
    said = found.sentence + outcome.held_load
    off, off_after = outcome.lengths
    if outcome.pattern:
        rest = outcome.follows if outcome.best is base else Following.of(outcome.best).shares()
        said += could_be_tried(rest, [e for e in allowed if not e.candidate], outcome.best)
        experiment = after_pattern(outcome.pattern, selection, outcome.fitted)
    else:
        experiment = next_experiment(selection, outcome.fitted, outcome.classes)
    if experiment and experiment.protocol and record.drives_pressure:
        experiment = replace(experiment, text=experiment.text + ANOTHER_RIG)
    yield replace(
        found,
        ranking=outcome.ranking(candidates),
        next_experiment=experiment,
        sentence=said,
        rmse_mm=off,
        rmse_after_mm=off_after,
    )


def _without_most_doubtful(outcome: Outcome) -> Outcome:
    """The outcome without the name for which a form speaks least, of those for which only a form does: beside something
    unknown no form is sure. Of 13 such names 3 were right. What speaks against another may be that name alone: then the
    best set of as many others stays, if it explains as much as names must that stand."""
    selection = outcome.selection
    gone = {*outcome.ruled_out, min(outcome.by_form, key=lambda name: outcome.by_form[name][0])}
    kept = [t for t in outcome.fitted.terms if t.effect.name not in gone]
    fitted = selection.refit(kept, outcome.fitted.values)
    if any(t.effect.name in outcome.by_form for t in kept) and all(t.effect.candidate for t in kept):
        named = [v for v in selection.cache.values() if v.names == v.candidates and gone.isdisjoint(v.names)]
        fitted = min((v for v in named if len(v.terms) == len(kept)), key=lambda v: v.criterion, default=fitted)
    if outcome.lacking and not replace(outcome.lacking, fitted=fitted).nearly_all:
        fitted = selection.refit([t for t in kept if not t.effect.candidate], fitted.values)
    fitted, (best, after, named, wrong) = allowed_by_nature(
        outcome.base, outcome.heldout, selection, fitted, lambda _: False
    )
    lacking = outcome.lacking and replace(outcome.lacking, fitted=fitted)
    found = replace(outcome, best=best, heldout_after=after, fitted=fitted, lacking=lacking, named=named)
    return replace(found, ruled_out=outcome.ruled_out | wrong)


def _selected(
    alone: Fit,
    candidates: list[Effect],
    seen: list[Effect],
    known: list[Effect],
    following: Following,
    odds: Mapping[str, float] | None,
) -> Selected:
    """The answer of those effects, `seen` in the record, that follow what the error may follow first; where it is
    incomplete, of those that follow what is likely; and of those that do so in part, or of all where nothing is
    followed, if they are likelier in the place of a name, or of none: these two only where they are complete."""
    tried = [] if following.uncovered(known) else [e.name for e in seen if following.supports(e.follows)]
    answer = answer_of(alone, candidates, known, following, tried, odds)
    likely = [e.name for e in seen if e.name in tried and not following.likely.isdisjoint(e.follows[:1])]
    if answer.lacking and len(likely) < len(tried):
        narrower = answer_of(alone, candidates, known, following, likely, odds)
        answer = answer if narrower.lacking else narrower
    partly = [e for e in seen if e.name not in tried and not following.likely.isdisjoint(e.follows)]
    if not (tried or answer.fitted.terms or answer.lacking):
        partly = seen  # slow noise may be what a form says in fewer words than surfaces can
    elif not tried or not (answer.lacking or answer.fitted.candidates):
        partly = []
    if further := likelier_instead(answer, partly):
        wider = answer_of(alone, candidates, known, following, tried + further, odds)
        return answer if wider.lacking else wider
    return answer


def _allowed(
    extra: tuple[Effect, ...], without: tuple[str, ...], only: tuple[str, ...], also: tuple[str, ...]
) -> list[Effect]:
    """The catalogue less effects and forms (`name:form`), those asked for made candidates. Raises UsageError for an
    unknown one, and where nothing is left of `only`."""
    for name in (*without, *only, *also):
        get_effect(name, extra)
    only = (*only, *also) if only else ()
    fewer = []
    for effect in map(partial(_asked_for, names={*only, *also}), catalogue(extra).values()):
        labels = {form: f"{effect.name}:{form.name}" for form in effect.forms}
        forms = tuple(form for form in effect.forms if not {effect.name, labels[form]} & set(without))
        if only and effect.name not in only:
            forms = tuple(form for form in forms if labels[form] in only)
        if forms:
            fewer.append(replace(effect, forms=forms))
    if not fewer:
        both = ", ".join(only or without)
        raise UsageError(
            f"{both}: the only effect that is tried, and left out as well; nothing is left to try. Keep one"
        )
    return fewer


def _one_a_driver(effect: Effect) -> Effect:
    """The effect as one of which a set has one for each driver but the map: in a locked muscle nobody measures how far
    the braid slides, and two names together can imitate much. What lags a driven pressure relaxes as that changes."""
    driver = {"way": "rest"}.get(effect.follows[0], effect.follows[0]) if effect.follows else effect.name
    if "pressure_rate" in effect.follows:
        effect = replace(effect, follows=(*effect.follows, "rest"))
    return effect if driver == "map" else replace(effect, alike=driver)


def _asked_for(effect: Effect, names: set[str]) -> Effect:
    """The effect as a candidate in the forms that are asked for, where it is none by itself."""
    forms = tuple(f for f in effect.forms if not names.isdisjoint((effect.name, f"{effect.name}:{f.name}")))
    return effect if effect.candidate or not forms else replace(effect, forms=forms, candidate=True)
