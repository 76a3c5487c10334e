"""From suspects to the set that explains the record: search, exact refits, and second thoughts."""

from collections.abc import Collection, Mapping, Sequence
from itertools import combinations

import numpy as np

from ..effects import AddsForce, Effect
from ..fitting import Fit
from ..model import Term
from .adequacy import PATTERN_MARGIN, FreeModel, full_cost
from .follows import Following
from .ground import Ground, Lead, scan
from .noise import Noise
from .patterns import patterns
from .search import Choice, beam_search
from .spectrum import beats
from .trial import Trial, Verdict, labels

PATTERN_MORE = 0.06
"""What a pattern must explain beyond an effect, as a share of the noise's variance."""
FAINT = 1.2
"""Squares that the law alone may leave, over those that an answer leaves, for it to be slow noise after all."""
SURE = 500.0
"""Cost by which noise must lose against a name, as fitted without it, to be left aside: where it won at last, it had
lost by 160 at most."""
UNEXPLAINED, EXPLAINED = 10.0, 3.0
"""Whitened squares beyond their number, in standard deviations: something is left; nothing is."""
CLOSE, RIVALS = 100.0, 3
"""Cost within which a rival of other names is mended, and the noise that it leaves given a court of its own; and how
many are mended."""
EXACT = 500
"""Rows up to which pairs are fitted exactly, and held-out data choose the forms of a table."""
NEAR, BENT = 30.0, 0.005
"""Cost within which a linearised estimate is worth an exact fit, and what is added to it as a share of all that is to
be explained, because the law bends."""
PATTERN_TOLERANCE, FAULT_TOLERANCE = 0.04, 0.01
"""The share that an unknown pattern must earn: more than a known effect in an unforeseen form would leave, where it
adds a force as if drawn by hand; as much as two names, where it is a fault of a sensor, with the law's own slopes, or
takes the place of names with no fewer parameters; and none where these have more, and it leaves noise alone."""


def investigate(
    base: Fit,
    suspects: Sequence[Effect],
    following: Following | None = None,
    tried: Collection[str] | None = None,
    most: int = 3,
) -> tuple[Trial, Verdict]:
    """The answer to a record, with the noise and the effects made to agree.

    Slow noise and an effect can each pass for the other. So where noise is coloured, or a faint answer may be what its
    colour is, the record is judged again against the noise that the law alone would imply, and against that which a
    new answer leaves; the answers and all their parts, fitted against the likeliest of these noises, are then compared
    by their full likelihood, each with its own noise. A close rival of other names brings the noise that it leaves
    before a court as well, where none was like it. Nothing of this where no noise could take the place of any name: a
    little colour is what a form leaves that is not exactly right.
    """
    trial = Trial(base, suspects, following, tried)
    verdict = _answer(trial, most)
    faint = trial.empty.squares < FAINT * verdict.squares and trial.noise_left_by(trial.empty).coloured
    doubtful = trial.noise_left_by(verdict).coloured or faint
    if not trial.noise.coloured and (not doubtful or _no_colour(trial, verdict) or _sure(trial, verdict)):
        return trial, _weighed(trial, verdict)
    trials = [(trial, verdict)]

    def heard(noise: Noise) -> bool:
        return any(noise.like(court.noise) for court, _ in trials)

    def judge_again(noise: Noise) -> None:
        if not heard(noise):
            again = Trial(base, suspects, noise=noise, before=trial)
            trials.append((again, _answer(again, most)))

    judge_again(trial.noise_left_by(verdict, white=True))
    judge_again(trial.noise_left_by(trial.empty))
    last, answer = trials[-1]
    if not any(answer.labels == found.labels for court, found in trials if court is not last):
        judge_again(last.noise_left_by(answer))
    (least, noise, found), *others = _compared(trials)
    close = [own for cost, own, rival in others if cost < least + CLOSE and rival.names != found.names]
    unheard = [own for own in close if not heard(own)]
    if unheard:
        judge_again(unheard[0])
        _, noise, found = _compared(trials)[0]
    final = Trial(base, suspects, noise=noise, before=trial)
    seen = [t for t in found.terms if t.effect.name not in final.excluded]  # by this noise the law may follow one
    kept = _weighed(final, final.refit(seen, found.values))
    if len(kept.terms) < len(found.terms):
        final = Trial(base, suspects, noise=final.noise_left_by(kept), before=trial)
        kept = final.refit(kept.terms, kept.values)
    return final, kept


def _no_colour(trial: Trial, verdict: Verdict) -> bool:
    """Whether what a set, or the law alone, leaves is no slow noise: the free model is far likelier than either."""
    if trial.record.inputs.time is None:
        return False
    free = FreeModel.of(trial)
    return all(free.cost + SURE < full_cost(trial, v)[0] for v in (verdict, trial.empty))


def _compared(trials: Sequence[tuple[Trial, Verdict]]) -> list[tuple[float, Noise, Verdict]]:
    """The answers of some courts and all their parts by their full cost, least first, each with the noise it leaves."""
    sets = {labels(terms): (terms, v.values) for _, v in reversed(trials) for terms in _subsets(v.terms)}
    fits = [_likeliest([court for court, _ in trials], terms, start) for terms, start in sets.values()]
    return sorted(((*full_cost(court, found), found) for court, found in fits), key=lambda item: item[0])


def _sure(trial: Trial, verdict: Verdict) -> bool:
    """Whether a set is far likelier than without any one of its terms, each with the noise that it leaves."""
    cost, _ = full_cost(trial, verdict)
    fewer = [trial.refit(verdict.without(term), verdict.values) for term in verdict.terms]
    return bool(fewer) and all(full_cost(trial, rest)[0] > cost + SURE for rest in fewer)


def _likeliest(trials: Sequence[Trial], terms: Sequence[Term], start: Mapping[str, float]) -> tuple[Trial, Verdict]:
    """The fit of a set against the noise, one of some trials', by which it is likeliest; and that trial."""
    fits = [(trial, trial.refit(terms, start)) for trial in trials]
    return min(fits, key=lambda item: item[1].squares + item[0].noise.volume)


def _subsets(terms: Sequence[Term]) -> list[tuple[Term, ...]]:
    return [some for size in range(len(terms) + 1) for some in combinations(terms, size)]


def _weighed(trial: Trial, verdict: Verdict) -> Verdict:
    """Take out, lightest first, what is significant but too small to matter."""
    small = trial.noise.too_small
    while verdict.terms:
        least = [small if term.effect.candidate else small + PATTERN_MORE for term in verdict.terms]
        weights = [trial.weight(verdict, term) / limit for term, limit in zip(verdict.terms, least, strict=True)]
        lightest = int(np.argmin(weights))
        if weights[lightest] >= 1.0:
            break
        verdict = trial.refit(verdict.without(verdict.terms[lightest]), verdict.values)
    return verdict


def _answer(trial: Trial, most: int) -> Verdict:
    """The cheapest set of effects, or of effects and a pattern. Where a pattern alone is all, no set is mended."""
    leaders = fitted_leaders(trial, most)
    if _beyond_noise(trial, leaders[0]) > UNEXPLAINED:
        found = find_pattern(trial, leaders[0])
        if found is not None and _is_all(trial, found) and found.cost < leaders[0].cost - SURE:
            return found
    verdict = mended(trial, leaders, most)
    return find_pattern(trial, verdict) or verdict


def _is_all(trial: Trial, verdict: Verdict) -> bool:
    """Whether one term explains all there is."""
    return len(verdict.terms) == 1 and _beyond_noise(trial, verdict) < EXPLAINED


def _beyond_noise(trial: Trial, verdict: Verdict) -> float:
    """Whitened squares that a set leaves beyond those of noise, in their standard deviations."""
    n = len(trial.record)
    return (verdict.squares - n) / float(np.sqrt(2.0 * n))


def fitted_leaders(trial: Trial, most: int) -> list[Verdict]:
    """The leading sets of up to `most` effects in a compressed search, and the law alone, fitted, cheapest first."""
    pool: list[Verdict] = []
    for choice in _leaders(trial, beam_search(trial.data, trial.price, most)):
        second = sorted(v.cost for v in [trial.empty, *pool])[:2][-1]
        pool.append(trial.refit_choice(trial.data, choice, trial.empty, second))
    if len(trial.record) <= EXACT:
        pool += _pairs(trial)
    return sorted([trial.empty, *pool], key=lambda v: v.cost)


def mended(trial: Trial, leaders: Sequence[Verdict], most: int) -> Verdict:
    """The cheapest set that the first leaders can be made into: the next, and those that come close."""
    first, *others = *leaders, trial.empty
    best = _mend(trial, first, most)
    rivals = [v for k, v in enumerate(others) if k == 0 or v.cost < first.cost + CLOSE]
    for rival in rivals[:RIVALS]:
        if not first.terms or not first.kin <= rival.kin:  # what it has beyond the first is tried on the first, too
            best = min(best, _mend(trial, rival, most), key=lambda v: v.cost)
    return best


def _pairs(trial: Trial) -> list[Verdict]:
    """The best single effect in each of its forms, with every other in each of its own, all fitted exactly.

    A law without free parameters leaves so much that signatures at its own values say little of pairs.
    """
    singles = [Term(effect, form) for effect in trial.suspects for form in effect.forms]
    best = min(singles, key=lambda t: trial.refit([t]).cost).effect if singles else None
    first = [t for t in singles if t.effect is best]
    return [trial.refit([a, b], trial.refit([a]).values) for a in first for b in singles if b.effect is not best]


def _leaders(trial: Trial, choices: Sequence[Choice]) -> list[Choice]:
    """The best choice of each of the leading sets of names, the best single effects always among them."""
    kept: dict[frozenset[str], Choice] = {}
    count = {1: 0, 2: 0, 3: 0}
    limit = {1: 5, 2: 4, 3: 3}
    for choice in choices:
        names = frozenset(trial.data.atoms[a].effect for a in choice.atoms)
        size = len(names)
        if names and names not in kept and count[size] < limit[size]:
            kept[names] = choice
            count[size] += 1
    return list(kept.values())


def _mend(trial: Trial, verdict: Verdict, most: int) -> Verdict:
    """Drop, exchange the form of, and add effects as long as that makes the set cheaper."""
    for _ in range(4):
        cost = verdict.cost
        rivals = [trial.refit(verdict.without(term), verdict.values, best=cost) for term in verdict.terms]
        rivals += [
            trial.refit(terms, _without(verdict.values, terms), best=cost) for terms in _other_forms(trial, verdict)
        ]
        if len(verdict.terms) < most:
            rivals += _additions(trial, verdict)
        best = min(rivals, key=lambda v: v.cost, default=verdict)
        if best.cost >= verdict.cost - 1e-6:
            return verdict
        verdict = best
    return verdict


def _other_forms(trial: Trial, verdict: Verdict) -> list[list[Term]]:
    """The set with each term in each other form, its kin's included."""
    found = []
    for k, term in enumerate(verdict.terms):
        kin = {e.name: e for e in (term.effect, *trial.suspects) if e.kin == term.effect.kin}
        others = [Term(e, form) for e in kin.values() for form in e.forms if form is not term.form]
        found += [[*verdict.terms[:k], other, *verdict.terms[k + 1 :]] for other in others]
    return found


def _without(values: dict[str, float], terms: Sequence[Term]) -> dict[str, float]:
    """Start values less the shapes of effects, which are searched anew from their grids."""
    shapes = {f"{t.effect.name}.{p.name}" for t in terms for p in t.form.shapes}
    return {k: v for k, v in values.items() if k not in shapes}


def _additions(trial: Trial, verdict: Verdict) -> list[Verdict]:
    data = trial.beyond(verdict, [e for e in trial.suspects if e.kin not in verdict.kin])
    choices = [c for c in beam_search(data, trial.price, 1) if c.atoms and c.gain > trial.price.least]
    return [trial.refit_choice(data, c, verdict, verdict.cost) for c in choices[:2]]


def find_pattern(trial: Trial, verdict: Verdict) -> Verdict | None:
    """The set with the best pattern added, when that earns its price; names the pattern makes needless are dropped.

    The pattern is looked for on what the set leaves and, lest the set has mopped it up, on what the law leaves.
    """
    leads: list[tuple[float, float, Lead]] = []
    grounds = [Ground(trial, start) for start in {v.names: v for v in (verdict, trial.empty)}.values()]
    time = trial.record.inputs.time
    lines = [] if time is None else [period for ground in grounds for period in beats(time, ground.view.residual)]
    for effect in patterns(trial.record.inputs, lines):
        for lead in scan(effect, grounds):
            price = _pattern_price(trial, lead, verdict)
            leads.append((lead.onto.cost - lead.gain + price, price, lead))
    leads.sort(key=lambda item: item[0])
    best = verdict
    for cost, price, lead in leads[:4]:
        if cost < best.cost + NEAR + BENT * trial.excess:
            best = min(best, _with_pattern(trial, lead, price), key=lambda v: v.cost)
    return best if best.cost < verdict.cost else None


def _pattern_price(trial: Trial, lead: Lead, verdict: Verdict) -> float:
    search = 2.0 * float(np.log(max(lead.tried, 2)))
    known = sum(len(term.form.params) for term in verdict.terms)
    more = lead.atom.free - known if not lead.onto.terms else 1
    rest = (lead.onto.cost - lead.gain - len(trial.record)) / float(np.sqrt(2.0 * len(trial.record)))
    fault = not isinstance(lead.atom.term.form, AddsForce)
    simpler = more < 0 and rest < EXPLAINED
    tolerance = 0.0 if simpler else FAULT_TOLERANCE if fault or more <= 0 else PATTERN_TOLERANCE
    return PATTERN_MARGIN + search + tolerance * trial.excess + trial.price.per_parameter * lead.atom.free


def _with_pattern(trial: Trial, lead: Lead, price: float) -> Verdict:
    """Fit a pattern with the set it was found beyond, then without each of the set's names in turn.

    A name must earn as much as the pattern: what an unknown effect has beyond a pattern's shape is no effect's."""
    terms = list(lead.onto.terms)
    verdict = trial.refit([*terms, lead.atom.term], lead.start, price + trial.price.total(terms))
    for gone in list(terms):
        fewer = [t for t in terms if t is not gone]
        rival = trial.refit([*fewer, lead.atom.term], verdict.values, price + trial.price.total(fewer))
        if rival.cost < verdict.cost + PATTERN_TOLERANCE * trial.excess:
            terms, verdict = fewer, rival
    return verdict
