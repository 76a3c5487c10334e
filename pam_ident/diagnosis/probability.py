"""How sure it is that an effect belongs to the answer."""

import math
from collections.abc import Collection, Sequence
from itertools import chain

from ..effects import Effect
from ..model import Term
from .confounding import rightly_called
from .drivers import DRIVERS
from .late import logged_late
from .remainder import as_good
from .search import CLOSE, TEMPER
from .selection import FittedSet, Selection

LAPSE, PAIR, THREE, DOUBTFUL, LOCKED, BESIDE = 0.006, 0.015, 0.3, 0.15, 0.12, 0.5
"""Chance that the search was misled as a whole, by what it ended with: one name, two, three, names that leave what
passes for slow noise but may be more, any in a locked muscle, of which nobody measures how far the braid slides, or
under weights, where length and pressure are one line each, and names beside something unknown. Shares of such
statements that were false, of the rig's sets and other hands': 4 of 1,157, 3 of 370, 20 of 58, 17 of 161, 10 of 100,
10 of 21."""
LITTLE, LITTLE_FREE, BY_FORM = 0.035, 0.13, 0.5
"""Share of what all names explain that the unforeseen form of another may leave, and what of that another's free form
takes up; and the chance that a name is right which does so, follows nothing likely, or is static beside another static
one: 4 of 4 (and none of 4 with a larger share), 7 of 12 and 12 of 18 were false."""
MISSED = 0.001
"""Chance that an effect is there of which nothing shows beside the answer: 30 of 30,807."""


def probabilities(
    selection: Selection,
    groups: Sequence[Sequence[str]],
    answer: Collection[str] | None = None,
    lapse: float = LAPSE,
) -> dict[str, float]:
    """Chance, by candidate, that it belongs to the answer, or that one does which the record cannot tell from it.

    Sets that were fitted are weighed by exp(−criterion / 2·TEMPER), and the weights of those that hold the candidate,
    or a member of its `groups`, are summed; but near the best only such as are `rightly_called`. Where the likeliest of
    them holds a name that the `answer` has not, because it is too small to matter or held-out data are predicted better
    without, no set with that name counts. With chance LAPSE, or that of its kind of answer, `lapse` at least, the
    answer is wrong all the same; with chance MISSED an effect is there whatever was fitted. These and TEMPER come from
    simulated records: docs/diagnosis.md.
    """
    best, *others = sorted(selection.cache.values(), key=lambda v: v.criterion)
    fitted = [best, *(v for v in others if v.criterion > best.criterion + CLOSE or rightly_called(selection, v))]
    while answer is not None:
        more = min(fitted, key=lambda v: v.criterion).candidates.difference(answer, *groups)
        if not more:
            break
        fitted = [v for v in fitted if v.names.isdisjoint(more)]
    least = min(v.criterion for v in fitted)
    sets = [(v.names, math.exp(-(v.criterion - least) / (2.0 * TEMPER))) for v in fitted]
    total = sum(weight for _, weight in sets)
    chance, names = {}, len(answer or ())
    locked = selection.record.inputs.locked or selection.record.carried
    kinds = {PAIR: names == 2, THREE: names > 2, LOCKED: locked}
    lapse = max([lapse, *(misled for misled, holds in kinds.items() if holds)])
    for name in dict.fromkeys([*(e.name for e in selection.candidates), *chain.from_iterable(groups)]):
        alike = {name}.union(*(group for group in groups if name in group))
        share = sum(weight for names, weight in sets if names & alike) / total
        chance[name] = (1.0 - lapse) * share + MISSED * (1.0 - share)
    return chance


def by_form_alone(
    selection: Selection,
    fitted: FittedSet,
    named: list[Term],
    classes: Sequence[Sequence[str]],
    follows: str,
    complete: bool,
) -> dict[str, tuple[float, str]]:
    """Of names, largest first, those for which only a form speaks: the chance that it does so rightly, and why it is
    asked, in a sentence.

    With the largest of the others, where the form of that may leave what it explains; where no driver of it is likely,
    and the error rather `follows` another; where it is static beside another that is, or is not told from one that
    is (`classes`), since only forms tell static effects apart, or beside what follows the temperature, of which nobody
    knows from where it counts; where another driver explains as much as the one that it follows first, and it is
    grouped with no effect that follows that; where a force that is logged late looks the same, or a pattern does, whose
    chance is counted already; where it follows a way that the braid slides and nobody measured; where it follows the
    clock in more than one way; and in its free form, where the answer is `complete`, or it is static: of statements of
    0.9 or more 4 of 40 in one were false, 3 of 258 in written ones.
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
            why = f"An unforeseen form of {others[0].title} could explain nearly all that it does."
            found[name] = BY_FORM if free else 1.0 - DOUBTFUL, why
        elif timed and term.effect.follows and selection.following.likely.isdisjoint(term.effect.follows):
            rather = f"The error rather follows {follows}" if follows != "noise" else "Slow noise could look the same"
            found[name] = BY_FORM, f"{rather}; only its form speaks for it."
        elif timed and name in known and (alike := [e for e in others if e.name in static]):
            found[name] = BY_FORM, f"With {alike[0].title} it could follow nearly any static error."
        elif timed and name in known and (warm := [e for e in others if e.follows[:1] == ("temperature",)]):
            why = f"If the law holds at another temperature than the record's first, {warm[0].title} is static in part."
            found[name] = BY_FORM, why
        elif timed and (other := _undecided(selection, term.effect, classes)):
            found[name] = 1.0 - DOUBTFUL, f"The error could as well follow {other}; its form alone tells."
        elif (
            timed
            and term.effect.follows[:1] == ("speed",)
            and (why := logged_late(selection, selection.plain_square(fitted.terms, fitted.values)))
        ):
            found[name] = BY_FORM, why
        elif timed and (other := as_good(selection, fitted, name)):
            found[name] = 1.0, f"It could as well be {other}."
        elif selection.record.kind == "dynamic" and term.effect.follows[:1] == ("way",):
            why = "How far the braid slides while the pressure alone changes is not measured."
            found[name] = 1.0 - DOUBTFUL, why
        elif term.effect.follows == ("clock",) and len(term.form.linear) > 1:
            found[name] = 1.0 - DOUBTFUL, "Noise that wanders as slowly as the test lasts could look the same."
        elif timed and free and (complete or name in known):
            found[name] = 1.0 - DOUBTFUL, "No written form of it fits, and its free form could follow much else."
    return found


def _undecided(selection: Selection, effect: Effect, classes: Sequence[Sequence[str]]) -> str:
    """What explains as much as what an effect follows first, in words; else, or where one of its group follows that,
    nothing."""
    others = selection.following.as_good(*effect.follows[:1]) if effect.follows else frozenset()
    group = {effect.name}.union(*(one for one in classes if effect.name in one))
    if any(not others.isdisjoint(e.follows[:1]) for e in selection.weighed if e.name in group):
        return ""
    return " and ".join(driver.text for driver in DRIVERS if driver.what in others)
