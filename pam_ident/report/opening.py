"""A record's first screen: what is missing in plain words, its trace, how far the error falls, what it follows."""

import math
from textwrap import fill

from .. import plot
from ..diagnosis.nouns import Diagnosis
from ..diagnosis.sentence import headline, start, told
from ..effects import in_words
from .easel import Easel, Part, Picture
from .story import Section
from .words import VERDICTS, groups, likely, newtons

HERO, BESIDE = 6.4, 5.0
"""Widths of the figures in inches; they are shown narrower than a page, and their words must stay readable."""
UNKNOWN = "Something is left that no known effect explains."
REMAINS = {
    "": "",
    "adequate": "",
    "missing_effect": " More is missing, and a known effect explains it.",
    "unknown_effect": f" {UNKNOWN}",
}


def opening(section: Section, easel: Easel) -> Part:
    """The answer, before any detail."""
    return Part(
        f"{easel.prefix}-verdict",
        _headline(section),
        (_fall(section),),
        (_trace(section, easel), *_falling(section, easel), _bar(section, easel)),
        notes=(_sure(section), *(f"{one}." for one in (section.after or section.before).at_bounds), *_next(section)),
        badge=_badge(section),
        opening=True,
    )


def answer(section: Section) -> str:
    """What the first screen says in words, for the terminal."""
    return f"{_headline(section)} {_fall(section)}"


def _added(section: Section) -> tuple[str, ...]:
    """Names of the effects that the law lacked."""
    if section.after is None:
        return ()
    held = section.before.model.effect_names
    return tuple(name for name in section.after.model.effect_names if name not in held)


def _last(section: Section) -> Diagnosis:
    """The diagnosis of the model as it is in the end."""
    return section.ladder.last if section.ladder is not None else section.diagnosis


def _unsure(section: Section) -> tuple[str, ...]:
    """Names of the diagnosis that were not added."""
    held = section.after.model.effect_names if section.after is not None else section.diagnosis.selected
    return tuple(name for name in section.diagnosis.selected if name not in held)


def _verdict(section: Section) -> str:
    """Of the model as it is in the end; nothing where nobody asked it about more."""
    last = _last(section)
    asked = last is not section.diagnosis or section.after is None or last.verdict == "unknown_effect"
    return last.verdict if asked else ""


def _badge(section: Section) -> tuple[str, str]:
    """What the law lacks, in a word: also where effects are named, it may be something that none of them is."""
    verdict = _verdict(section) or section.diagnosis.verdict
    if _added(section) and verdict != "unknown_effect":
        verdict = "missing_effect"
    return VERDICTS.get(verdict, (verdict, ""))


def _headline(section: Section) -> str:
    diagnosis, added, verdict = section.diagnosis, _added(section), _verdict(section)
    pattern = _last(section).pattern
    left = (
        f" {UNKNOWN[:-1]}: {pattern.text}."
        if verdict == "unknown_effect" and pattern
        else REMAINS.get(verdict, verdict)
    )
    if added and section.after is not None:
        rungs = section.ladder.rungs if section.ladder is not None else ()
        found = (diagnosis, *(rung.found for rung in rungs if rung.found is not None))
        unsure = _unsure(section)
        also = f" {headline(unsure, (diagnosis,), diagnosis.best.model.own)}" if unsure else ""
        return headline(added, found, section.after.model.own) + also + left
    return "Nothing is missing that this record could show." if verdict == "adequate" else left.strip()


def _fall(section: Section) -> str:
    after, said = section.after, start(section.before, section.noise_floor)
    if after is None:
        return said
    words = ", ".join(in_words(name, after.model.own) for name in _added(section)) if _unsure(section) else "that"
    return f"{said} With {words} added, {newtons(after.rmse)} are left."


def _trace(section: Section, easel: Easel) -> Picture:
    before, after = section.before, section.after
    figure, live = plot.signature.draw(before, after, easel.points, HERO), easel.live and easel.live.trace
    if after is None:
        caption = "The error of the law over the whole record."
        return easel.hang(figure, "Error of the law over the record", caption, live=live)
    caption = (
        "The error before (above), with what is added to the modelled force drawn through it, and after (below). "
        "Where the two lines above coincide, the addition explains the error."
    )
    added = ", ".join(in_words(name, after.model.own) for name in _added(section))
    label = f"Error over the record before and after adding {added}"
    return easel.hang(figure, label, caption, live=live)


def _falling(section: Section, easel: Easel) -> tuple[Picture, ...]:
    ladder = section.ladder
    if ladder is None or len(ladder.rungs) < 2:
        return ()
    width = max(44 // len(ladder.rungs), 9)
    names = ["model as given" if ladder.rungs[0].fit.model.terms else "law alone"]
    for name in plot.ladder.data(ladder).names[1:]:
        lines = name.replace("+ ", "+\u00a0").split("\n")
        names.append("\n".join(fill(line, width, break_long_words=False) for line in lines))
    label = "Falling rms error as effects are added, down to the noise"
    caption = "The error as effects are added, down to the noise."
    return (easel.hang(plot.ladder.draw(ladder, names, BESIDE), label, caption),)


def _bar(section: Section, easel: Easel) -> Picture:
    follows = section.comparison.follows
    label = f"What the error of the law follows, as one bar. {told(follows)}"
    return easel.hang(plot.follows.draw(follows, BESIDE), label, f"What the law's error follows. {told(follows)}")


def _sure(section: Section) -> str:
    diagnosis, known = section.diagnosis, section.diagnosis.best.model.own
    chances = {one.effect: one.probability for one in diagnosis.ranking}
    said = [f"{in_words(name, known)} {likely(chances[name])}" for name in diagnosis.selected if name in chances]
    return f"How sure: {'; '.join([*said, f'held-out error: {held_out(section)}'])}."


def held_out(section: Section) -> str:
    """The error on held-out data before and after, and whether all was chosen anew without them."""
    diagnosis, ladder = section.diagnosis, section.ladder
    errors, anew = [diagnosis.heldout_rmse, diagnosis.heldout_rmse_after], ""
    if ladder is not None:
        errors = [rung.heldout_rmse for rung in (ladder.rungs[0], ladder.rungs[-1])]
        anew = "" if ladder.nested is None else ", everything chosen anew without those data"
    if math.isnan(errors[0]):
        return "none could be held out"
    return " → ".join(dict.fromkeys(map(newtons, errors))) + anew


def _next(section: Section) -> tuple[str, ...]:
    """What the record cannot tell, and what to do."""
    diagnosis = section.diagnosis
    found = groups(diagnosis)
    last = _last(section)
    experiment = diagnosis.next_experiment if found else last.next_experiment or diagnosis.next_experiment
    if experiment is not None:
        todo = experiment.text[:1].lower() + experiment.text[1:]
    elif _verdict(section) in ("adequate", ""):
        todo = f"use the {'completed model' if section.after else 'model'}; its parameters are below."
    else:
        todo = "look at where the model fails, below."
    return (*found, f"What to do next: {todo}")
