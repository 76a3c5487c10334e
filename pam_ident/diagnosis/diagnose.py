"""Which effect is missing, how sure that is, and what is left."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from ..core import UsageError
from ..core.digits import millimetres, newtons
from ..core.threads import one_blas_thread
from ..effects import Effect, catalogue, get_effect
from ..fitting import Fit, fit, repeat_noise
from ..fitting.carried import driven, length_rmse, nearer
from ..model import Model, Term
from ..records import Record, thinned
from .adequacy import Adequacy, FreeModel
from .answer import answer_of, likelier_instead, standing
from .confirmed import allowed_by_nature, impossible_alone
from .confounding import groups
from .experiment import after_pattern, next_experiment
from .follows import ROWS, Following, steadied
from .heldout import fit_quickly, heldout_nearby, heldout_rmse
from .nouns import Candidate, Diagnosis
from .probability import DOUBTFUL, LAPSE, probabilities
from .remainder import pattern_of, unlike_noise
from .repeats import rounding, step_of
from .select import EXACT
from .selection import OTHER_SIZE, FittedSet, Selection
from .sentence import MORE, as_slow_noise, could_be_tried, reservations, sentence

Array = np.ndarray
LITTLE, LITTLE_FREE, BY_FORM = 0.035, 0.13, 0.5
"""Share of what all names explain that the unforeseen form of another may leave, and what of that another's free form
takes up; and the chance that a name is right which does so, follows nothing likely, or is static beside another static
one: 4 of 4 (and none of 4 with a larger share), 7 of 12 and 12 of 18 were false."""
ANOTHER_RIG = " It takes a rig that drives the length while the pressure is held."
ENDED_BADLY = 1.01
"""Error of a law with a candidate, over that of the law alone, from which its fit has failed: an effect of size zero
leaves no more."""


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
    steps = diagnosing(model, record, extra, without, only, odds, also, noise_N)
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
    base = fit(model, record)
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
    tried = [] if following.uncovered(known) else [e.name for e in seen if following.supports(e.follows)]
    answer = answer_of(alone, candidates, known, following, tried, odds)
    if tried and (answer.lacking or answer.fitted.candidates):
        partly = [e for e in seen if e.name not in tried and not following.likely.isdisjoint(e.follows)]
        if further := likelier_instead(answer, partly):
            wider = answer_of(alone, candidates, known, following, tried + further, odds)
            answer = answer if wider.lacking else wider
    selection, fitted, lacking = answer.selection, answer.fitted, answer.lacking
    if lacking:
        selection, lacking = standing(answer, candidates, lacking)
        fitted = lacking.fitted
    heldout = heldout_rmse(model, record, base)

    def instead(one: FittedSet) -> bool:
        return not lacking and not any(following.outweighs(t.effect, known) for t in one.terms)

    fitted, (best, after, named, ruled_out) = allowed_by_nature(base, heldout, selection, fitted, instead)
    if record.carried and not along and (static := answer.selection.best_static).terms:
        shifted = nearer(model.adding(*static.terms), record, static.values)
        again = diagnosing(model, shifted, extra, without, only, odds, also, noise_N, along=True)
        found = next(again)
        if found.best.rmse**2 < (1.0 + OTHER_SIZE) * best.rmse**2:
            yield found
            yield from again
            return
    rivals = {t.effect.name: following.unknown_instead(t.effect, known) for t in fitted.terms if t.effect.candidate}
    patterns = [t for t in fitted.terms if not t.effect.candidate]
    if lacking and not patterns:
        odd = unlike_noise(answer.selection, answer.fitted) if answer.lacking and answer.lacking.complete else None
        pattern = odd or lacking.pattern()
    else:
        pattern = pattern_of(selection, fitted if patterns else selection.refit(named, fitted.values))
    wrong = impossible_alone(base, best, fitted, ruled_out)
    pattern = wrong if wrong and (pattern is None or pattern.kind == wrong.kind) else pattern
    follows = following.shares()
    selected = tuple(t.effect.name for t in named)
    classes = tuple(group for group in groups(selection, fitted) if group[0] in selected)
    timed = bool(selected) and record.inputs.time is not None
    slow = False
    unfollowed: tuple[str, ...] = ()
    if timed and not pattern:
        slow = Adequacy(selection, fitted, FreeModel.of(selection)).wanders
        unfollowed = following.uncovered(known, [one.what for one in follows if one.what in following.chosen])
    lapse = DOUBTFUL if pattern or slow or unfollowed else LAPSE
    chance = probabilities(selection, classes, selected, lapse)
    if lacking:
        kept = set(selected).union(*classes)
        chance = {name: chance[name] for name in chance if name in kept}
    chance = {name: chance[name] * (1.0 - rivals.get(name, 0.0)) for name in chance if name not in ruled_out}
    by_form = by_form_alone(selection, fitted, named, classes, follows[0].text)
    doubtful: dict[str, float] = {}
    for name, (sure, _) in by_form.items():
        for one in {name}.union(*(group for group in classes if group[0] == name)):
            doubtful[one] = min(sure, doubtful.get(one, 1.0))
    worse = bool(named) and after > heldout
    chance = {name: chance[name] * doubtful.get(name, 1.0) * (BY_FORM if worse else 1.0) for name in chance}
    outcome = "unknown_effect" if pattern else "missing_effect" if named else "adequate"
    labels = tuple(t.label for t in named)
    noise = selection.noise_left_by(fitted) if patterns else selection.noise
    left = selection.view(fitted).residual[~noise.outlier]
    error = float(np.sqrt(np.mean(left**2)))
    floor = _as_measured(min(noise.whole, error), best)
    if lacking:  # the names that are not all there are do not touch it
        between = [seen.sigma for one in (base, best) if (seen := repeat_noise(one))]
        floor = min(*(between or [floor]), _as_measured(lacking.free.noise.whole, best), best.rmse)
    elif pattern and not fitted.terms and record.inputs.time is not None:  # noise follows nothing
        floor = min(floor, math.sqrt(follows[-1].share) * base.rmse)
    extra = (*extra, *model.own)
    floor = min(floor, noise_N)
    rounded = bool(pattern) and not named and _may_round(selection, base.rmse, floor)
    if rounded:
        pattern, outcome = None, "adequate"
    far = 0 if error > MORE * noise.whole else int(noise.outlier.sum())
    said = sentence(base, best, labels, classes, pattern, floor, far, extra)
    if rounded:
        said += f" What is left may be rounding: the force was read in steps of {newtons(step_of(record.force))}."
    elif outcome == "adequate" and noise.coloured:
        said += as_slow_noise(follows)
    if slow:
        said += " Less sure: part of what is left passes for slow noise, but may follow what was driven as well."
    elif unfollowed:
        too = " and ".join(one.text for one in follows if one.what in unfollowed)
        said += f" Less sure: the error follows {too}, too, and no effect that was tried does."
    off = length_rmse(base)
    off_after = off if best is base else length_rmse(best)
    if record.carried:
        said += " A load was held and the length answered: errors are those of the force at the measured length"
        told = " → ".join(millimetres(one) for one in dict.fromkeys((off, off_after)) if one is not None)
        said += f"; fitted to the length, the model errs by {told}." if told else "."
    if worse:
        said += " Less sure: with what is named, held-out data are predicted worse than without."
    said += reservations({name: rivals[name] for name in selected}, by_form, extra)
    found = Diagnosis(
        base,
        best,
        outcome,
        selected,
        labels,
        classes,
        _ranking(base, selection, candidates, named, chance, errors=False),
        floor,
        heldout,
        after,
        pattern,
        None,
        said,
        follows,
        {"followed": following.newtons_followed} if len(steady) == len(record) else {},
        rmse_mm=off,
        rmse_after_mm=off_after,
    )
    yield found
    if pattern:
        rest = follows if best is base else Following.of(best).shares()
        said += could_be_tried(rest, [e for e in allowed if not e.candidate], best)
        experiment = after_pattern(pattern, selection, fitted)
    else:
        experiment = next_experiment(selection, fitted, classes)
    if experiment and experiment.protocol and record.drives_pressure:
        experiment = replace(experiment, text=experiment.text + ANOTHER_RIG)
    ranking = _ranking(base, selection, candidates, named, chance)
    yield replace(found, ranking=ranking, next_experiment=experiment, sentence=said)


def _may_round(selection: Selection, rmse: float, noise: float) -> bool:
    """Whether what a law leaves beyond noise, both in N, may be the rounding of the force: that is no less, nor too
    small to matter, and what is left has no look of its own."""
    rounds = rounding(step_of(selection.record.force))
    if rounds < max(rmse**2 - noise**2, selection.noise.too_small * noise**2):
        return False
    return unlike_noise(selection, selection.empty) is None


def by_form_alone(
    selection: Selection, fitted: FittedSet, named: list[Term], classes: Sequence[Sequence[str]], follows: str
) -> dict[str, tuple[float, str]]:
    """Of names, largest first, those for which only a form speaks: the chance that it does so rightly, and why it is
    asked, in a sentence.

    With the largest of the others, where the form of that may leave what it explains; where no driver of it is likely,
    and the error rather `follows` another; where it is static beside another that is, or is not told from one that
    is (`classes`), or in its free form, since only forms tell static effects apart, or beside what follows the
    temperature, of which nobody knows from where it counts; where it follows a way that the braid slides and nobody
    measured; and where it follows the clock in more than one way.
    """
    found: dict[str, tuple[float, str]] = {}
    timed = selection.record.inputs.time is not None
    known = {effect.name for effect in selection.candidates if effect.static}
    static = known.union(*(group for group in classes if not known.isdisjoint(group)))
    for term in named:
        name = term.effect.name
        others = [t.effect for t in named if t is not term]
        free = term.form.free and term.effect.follows[:1] != ("temperature",)  # which is measured, and like no other
        if others and selection.part(fitted, term) < (LITTLE_FREE if free else LITTLE):
            why = f"Without it {others[0].title}, in another form, could leave as little."
            found[name] = BY_FORM if free else 1.0 - DOUBTFUL, why
        elif timed and term.effect.follows and selection.following.likely.isdisjoint(term.effect.follows):
            found[name] = BY_FORM, f"The error rather follows {follows}; only its form speaks for it."
        elif timed and name in known and (alike := [e for e in others if e.name in static]):
            found[name] = BY_FORM, f"With {alike[0].title} it could follow nearly any static error."
        elif timed and name in known and (warm := [e for e in others if e.follows[:1] == ("temperature",)]):
            why = f"If the law holds at another temperature than the record's first, {warm[0].title} is static in part."
            found[name] = BY_FORM, why
        elif timed and name in known and term.form.free:
            why = "No written form of it fits, and its free form could follow nearly any static error."
            found[name] = 1.0 - DOUBTFUL, why
        elif selection.record.inputs.slid_by_pressure and term.effect.follows[:1] == ("way",):
            why = "How far the braid slides while the pressure alone changes is not measured."
            found[name] = 1.0 - DOUBTFUL, why
        elif term.effect.follows == ("clock",) and len(term.form.linear) > 1:
            found[name] = 1.0 - DOUBTFUL, "Noise that wanders as slowly as the test lasts could look the same."
    return found


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
    """The effect as one of which a set has one for each driver: in a locked muscle nobody measures how far the braid
    slides, and two names together can imitate much."""
    driver = {"way": "rest"}.get(effect.follows[0], effect.follows[0]) if effect.follows else effect.name
    return replace(effect, alike=driver)


def _asked_for(effect: Effect, names: set[str]) -> Effect:
    """The effect as a candidate in the forms that are asked for, where it is none by itself."""
    forms = tuple(f for f in effect.forms if not names.isdisjoint((effect.name, f"{effect.name}:{f.name}")))
    return effect if effect.candidate or not forms else replace(effect, forms=forms, candidate=True)


def _as_measured(noise: float, found: Fit) -> float:
    """Noise in N with what that of the pressure and displacement sensors adds by a fit, of its size in N without."""
    calm = found.model.force(found.record.steady, found.values)
    return min(math.hypot(noise, float(np.sqrt(np.mean((found.force - calm) ** 2)))), found.rmse)


def _ranking(
    base: Fit,
    selection: Selection,
    candidates: list[Effect],
    named: list[Term],
    chance: dict[str, float],
    errors: bool = True,
) -> tuple[Candidate, ...]:
    """Every candidate with the error that adding it alone leaves, on all rows and held out, by a fit of its own; None
    without `errors`, and where that fit ended above the law's own.

    It has the form that was selected, else the one that the search prefers. Of a long record ROWS rows are fitted.
    """
    best = selection.seen.best_of_each(selection.penalty)
    terms = {term.effect.name: term for term in named}
    record = thinned(base.record, ROWS)
    most = ENDED_BADLY * fit_quickly(base.model, record, base.values)[1] if errors else 0.0
    found = []
    for effect in candidates:
        if effect.name in selection.excluded:
            status, why = selection.excluded[effect.name]
            found.append(Candidate(effect.name, effect.name, status, 0.0, why=why))
            continue
        regressor = selection.seen.regressors[best[effect.name][1]]
        term = terms.get(effect.name, regressor.term)
        one = Candidate(effect.name, term.label, "candidate", chance.get(effect.name, 0.0))
        if errors:
            near = {f"{effect.name}.{k}": v for k, v in regressor.point.items()} if term == regressor.term else {}
            inside, outside = _alone(base.model.adding(term), record, base.values | near)
            if inside <= most:
                one = replace(one, rmse_after=inside, heldout_rmse_after=None if math.isnan(outside) else outside)
        found.append(one)
    found.sort(key=lambda s: (s.status != "candidate", -s.probability, s.effect not in terms, s.rmse_after or math.inf))
    return tuple(found)


def _alone(model: Model, record: Record, start: Mapping[str, float]) -> tuple[float, float]:
    """Error in N that a model leaves of all rows, and of those held out; a short record pays for every refit."""
    if len(record) - len(model.params) <= 2:
        return math.nan, math.nan
    if len(record) <= EXACT:
        whole = fit(model, record, detail=False)
        return whole.rmse, heldout_rmse(model, record, whole)
    values, error = fit_quickly(model, record, start)
    return error, heldout_nearby(model, record, values)
