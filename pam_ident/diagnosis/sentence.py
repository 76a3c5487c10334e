"""A diagnosis in words: effects by their titles, with what is typed to add them in brackets, once."""

from collections.abc import Iterable, Mapping, Sequence

from ..core.digits import newtons, number, percent, percents, probability
from ..effects import Effect, in_words, named
from ..fitting import Fit
from .nouns import Diagnosis, Follows, Ladder, Pattern

REST = "the rest"
"""What follows nothing, where nobody knows that it is noise."""
WORTH_TRYING = 0.1
"""Share of the squared error that follows a driver from which effects that follow it, too, are proposed."""
SURE = 0.9
"""Probability of a name from which a headline states it without a word of doubt."""
MORE = 1.2
"""Error of a model with all names, over the noise, from which more than noise is left."""
TOLD = 0.05
"""Chance of something unknown in place of a name from which it is said."""
FEW = 100
"""Samples below which what a model leaves is no measure of the noise."""


def missing(chance: float) -> str:
    """The word before names of which the least sure has a certain chance."""
    told = round(chance, 2)
    return "Missing" if told >= SURE else "Probably missing" if told >= 0.5 else "Perhaps missing"


def start(base: Fit, floor: float) -> str:
    """What a model leaves, beside the noise in N; a table, or FEW samples in time, do not show how small that is."""
    about = "about" if base.record.inputs.time is not None and len(base.record) >= FEW else "at most"
    return f"The {base.model.words} leaves {newtons(base.rmse)} rms; the noise is {about} {newtons(floor)}."


def sentence(
    base: Fit,
    best: Fit,
    labels: Sequence[str],
    chance: float,
    classes: Iterable[Sequence[str]],
    pattern: Pattern | None,
    floor: float,
    far: int,
    extra: tuple[Effect, ...],
) -> str:
    """What is missing, by the `chance` of the least sure name, and what is left, beyond noise perhaps in `far` samples
    far off. `extra` are effects beside the catalogue's."""
    parts = [start(base, floor)]
    if labels:
        parts.append(
            f"{missing(chance)}: {', '.join(named(label, extra) for label in labels)}. "
            f"With {'it' if len(labels) == 1 else 'them'} the error falls to {newtons(best.rmse)}."
        )
        if pattern is None and best.rmse > MORE * floor:
            parts.append(
                f"What is left beyond noise lies in {far} samples, where the motion turns, a run begins at rest or "
                "single ones are far off."
                if far
                else "More than noise is left: the form is not exactly right, or something small is missing, too. Add "
                "and diagnose again, or take the ladder, which does so."
            )
    elif pattern is None:
        parts.append("Nothing is missing that this record could show.")
    parts += not_told_apart(classes, extra)
    if pattern:
        parts.append(f"Something is left that no known effect explains: {pattern.text}.")
        if pattern.kind == "step" and pattern.coordinate == "time":
            after = f"--where 'time_s > {number(pattern.value)}'"
            parts.append(f"If a sensor was zeroed or knocked then, diagnose what follows it by itself: {after}.")
    return " ".join(parts)


def not_told_apart(classes: Iterable[Sequence[str]], extra: tuple[Effect, ...]) -> list[str]:
    """A sentence for each name and those that a record cannot tell from it; `extra` are effects beside the
    catalogue's."""
    return [
        f"This record cannot tell {in_words(first, extra)} from {' or '.join(named(name, extra) for name in others)}."
        for first, *others in classes
    ]


def why_it_ends(ladder: Ladder) -> str:
    """What is missing on its last rung, and from which effects the record cannot tell those that it holds."""
    return " ".join([ladder.last.sentence, *not_told_apart(ladder.groups, ladder.rungs[-1].fit.model.own)])


def headline(names: Sequence[str], diagnoses: Iterable[Diagnosis], extra: tuple[Effect, ...]) -> str:
    """What is missing in a few words: each of some effects with those that the record cannot tell from it, as sure as
    the least sure of them. `diagnoses` named them."""
    rivals: dict[str, Sequence[str]] = {}
    chances: dict[str, float] = {}
    for one in diagnoses:
        rivals |= {first: others for first, *others in one.groups}
        chances |= {each.effect: each.probability for each in one.ranking if each.effect in one.selected}
    told = [" or ".join(in_words(each, extra) for each in (name, *rivals.get(name, ()))) for name in names]
    least = min(chances.get(name, 1.0) for name in names)
    joint = ", and " if any(map(rivals.get, names)) else " and "
    return f"{missing(least)}: {joint.join(filter(None, (', '.join(told[:-1]), told[-1])))}."


def reservations(
    rivals: Mapping[str, float], by_form: Mapping[str, tuple[float, str]], extra: tuple[Effect, ...]
) -> str:
    """What makes named effects less sure, each sentence with a blank before it: the chance that one is something
    unknown, and what `by_form_alone` found."""
    said = [
        f" With a chance of {probability(chance)} it is not {in_words(name, extra)} but something unknown."
        for name, chance in rivals.items()
        if chance >= TOLD
    ]
    return "".join([*said, *(f" Less sure: {in_words(name, extra)}. {why}" for name, (_, why) in by_form.items())])


def could_be_tried(found: Sequence[Follows], others: Iterable[Effect], fit: Fit) -> str:
    """A sentence, with a blank before it, on those of some effects that follow what a fit's error follows; empty where
    there is none. `found` are the shares of that error, `others` effects that were not tried, of which none with a
    warning is proposed."""
    inputs, held = fit.record.inputs, fit.model.effect_names
    free = [e for e in others if not (e.warning or e.name in held or e.missing(inputs))]
    for one in found:
        names = [f"{e.title} (--also {e.name})" for e in free if one.what in e.follows and one.share >= WORTH_TRYING]
        if names:
            return f" Tried only if asked for, and following {one.text}, too: {', '.join(names)}."
    return ""


def as_slow_noise(found: Sequence[Follows]) -> str:
    """A sentence, with a blank before it, on what follows something but was taken for slow noise; empty without it."""
    first = found[0]
    if first.what == "noise" or first.share < WORTH_TRYING:
        return ""
    return (
        f" {percent(first.share)} of the squared error follows {first.text}. Slow noise would, too, "
        "and this record cannot tell it from an effect."
    )


def told(found: Sequence[Follows], error: str = "squared error") -> str:
    """The largest shares of an error in one sentence."""
    whole = dict(zip(found, percents([one.share for one in found]), strict=True))
    shown = [one for one in found if one.what != "noise" and one.share >= 0.01][:4]
    parts = [f"{'a further ' if k else ''}{whole[one]} follows {one.text}" for k, one in enumerate(shown)]
    noise, text = next(((text, one.text) for one, text in whole.items() if one.what == "noise"), ("0 %", "noise"))
    if not parts:
        return f"No smooth course over what was driven or recorded explains any of the {error} beyond chance."
    return f"Of the {error} {', '.join(parts)}; {noise} {'follows none of these' if text == REST else 'is noise'}."
