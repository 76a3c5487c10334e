"""What a record cannot tell apart."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..core import Inputs
from ..effects import Effect
from ..effects.base import Values, keeping_no_more
from ..model import Term
from ..records import Record
from .schedule import one_speed
from .search import CLOSE
from .select import best_forms
from .selection import FORM_TOLERANCE, FittedSet, Selection

Array = np.ndarray
UNSURE = 0.1
"""Share of the samples in motion whose velocity is not the way of their stroke, from which that is unsure."""
NEARLY = 0.8
"""Share of what a name explains that another must explain where it is not known how the muscle slid, or which way."""


def groups(selection: Selection, fitted: FittedSet) -> tuple[tuple[str, ...], ...]:
    """For each selected effect that has one, the group of effects that could stand in its place."""
    found = []
    for term in fitted.terms:
        if not term.effect.candidate:
            continue
        rest = selection.refit(fitted.without(term), fitted.values)
        twins = [*_same_form(selection, term), *_general(selection, fitted, term)]
        twins += [n for n in _breaking_away(selection, fitted, term) if n not in twins]
        twins += [n for n in _close(selection, fitted, rest, term.effect) if n not in twins]
        twins += [n for n in _fitted(selection, fitted, term.effect) if n not in twins]
        if selection.record.inputs.locked:
            twins += [n for n in _same_when_locked(selection, rest, term.effect) if n not in twins]
        if one_speed(selection.record):
            twins += [n for n in _same_at_one_speed(selection, rest, term.effect) if n not in twins]
        twins += [n for n in _same_by_velocity(selection, rest, term.effect) if n not in twins]
        twins = [n for n in twins if n not in fitted.names]
        if twins:
            found.append((term.effect.name, *twins[:3]))
    return tuple(found)


def rightly_called(selection: Selection, fitted: FittedSet) -> bool:
    """Whether every effect of a set is what it is called there: friction that grows with pressure grows."""
    return not any(_needless(selection, fitted, t) for t in fitted.terms if not t.effect.special_case_of)


def _same_form(selection: Selection, term: Term) -> list[str]:
    """The other effect that the formula of the selected form holds."""
    return [e.name for e in selection.weighed if e.name == term.form.same_as]


def _general(selection: Selection, fitted: FittedSet, term: Term) -> list[str]:
    """The effect that this one is a special case of, where the record does not need the size that makes it one."""
    general = [e.name for e in selection.weighed if e.name == term.effect.special_case_of]
    return general if general and _needless(selection, fitted, term) else []


def _needless(selection: Selection, fitted: FittedSet, term: Term) -> bool:
    """Whether a set explains as much without the size that makes a term's effect what it is, beside others it has."""
    effect, form = term.effect, term.form
    kept = [k for k, p in enumerate(form.linear) if p.name != effect.own]
    if not 0 < len(kept) < len(form.linear):
        return False

    def columns(inputs: Inputs, values: Values, force: Array) -> Array:
        return form.columns(inputs, values, force)[:, kept]

    linear = tuple(form.linear[k] for k in kept)
    plain = Term(effect, replace(form, name=f"{form.name}_plain", linear=linear, columns=columns))
    fewer = selection.aside().refit([*fitted.without(term), plain], fitted.values)
    return fewer.squares < fitted.squares + CLOSE


def _breaking_away(selection: Selection, fitted: FittedSet, term: Term) -> list[str]:
    """The effects that hold more at rest than in motion, where friction of one force was found to: it cannot."""
    effect, form = term.effect, term.form
    if effect.follows != ("direction",) or len(form.linear) != 2 or not form.linear[1].name.endswith("_hold"):
        return []
    moving, held = (fitted.values[f"{effect.name}.{p.name}"] for p in form.linear)
    if held <= moving:
        return []
    linear = tuple(replace(p, lower=0.0) for p in form.linear)
    kept = replace(form, name=f"{form.name}_kept", linear=linear, columns=keeping_no_more(form.columns))
    within = selection.aside().refit([*fitted.without(term), Term(effect, kept)], fitted.values)
    if within.squares < fitted.squares + CLOSE + selection.penalty.tolerance:
        return []
    return [e.name for e in selection.weighed if e.follows == ("speed", "direction") and e.name not in fitted.names]


def _others(selection: Selection, fitted: FittedSet, effect: Effect) -> list[Effect]:
    """An effect and those outside a set; what the law follows nearly, too, which a large misfit may still be.

    Not its own special cases: with more parameters they can always do the same.
    """
    others = [e for e in selection.weighed if e.special_case_of != effect.name]
    return [e for e in others if e.name == effect.name or e.name not in fitted.names]


def _close(selection: Selection, fitted: FittedSet, rest: FittedSet, effect: Effect) -> list[str]:
    """Effects that cost nearly as little in the place of `effect`: looked up on compressed data, then fitted."""
    data = selection.beyond(rest, _others(selection, fitted, effect))
    choices = [
        (data.regressors[choice.regressors[0]].effect, choice)
        for choice in best_forms(data, selection.penalty, range(len(data.regressors)))
    ]
    mine = min([fitted.criterion - rest.criterion, *(c.criterion for name, c in choices if name == effect.name)])
    near, bent = _near(selection, effect), CLOSE + FORM_TOLERANCE * selection.excess
    best: dict[str, float] = {}
    for name, choice in choices:
        if name != effect.name and choice.criterion < mine + bent + near[name]:
            rival = selection.refit_choice(data, choice, rest, fitted.criterion + near[name])
            if rightly_called(selection, rival):
                best[name] = min(best.get(name, np.inf), rival.criterion)
    return sorted((n for n in best if best[n] < fitted.criterion + near[n]), key=best.__getitem__)


def _near(selection: Selection, effect: Effect) -> dict[str, float]:
    """Criterion within which each other effect could be meant, by name. What a form may leave that is not exactly right
    is in it where the form alone tells the two apart: the other follows the same first, or what the likeliest drivers
    hold, and this one does not. Nor is it known by what measure softening fades, way, stroke or energy: where the error
    may follow the cycle and rest, the time since an isobar began is one more. Nor how a contact under a weight bends
    before it slides: while the weight sticks, nothing shows it."""
    following, first, tolerance = selection.following, effect.follows[:1], selection.penalty.tolerance
    chosen, alike = following.chosen, [{"cycle", "rest"}] if following.drivers >= {"cycle", "rest"} else []
    alike += [{"way", "direction"}] if selection.record.carried else []

    def by_form(other: Effect) -> bool:
        likelier = chosen.isdisjoint(first) and not chosen.isdisjoint(other.follows[:1])
        one = other.follows[:1] == first or any(same.issuperset({*first, *other.follows[:1]}) for same in alike)
        return bool(first) and (one or likelier)

    return {e.name: CLOSE + (tolerance if by_form(e) else 0.0) for e in selection.weighed}


def _fitted(selection: Selection, fitted: FittedSet, effect: Effect) -> list[str]:
    """Effects that cost nearly as little in the place of `effect` in a set that was fitted, in whatever form."""
    rest = fitted.names - {effect.name}
    rivals = [v for v in selection.cache.values() if rest < v.names and len(v.names) == len(fitted.names)]
    near, least = _near(selection, effect), fitted.criterion
    others = {e.name for e in _others(selection, fitted, effect)} - {effect.name}
    pairs = [(v.criterion, name, v) for v in rivals for name in v.names - rest if name in others]
    close = sorted((one for one in pairs if one[0] < least + near.get(one[1], 0.0)), key=lambda one: one[:2])
    found: list[str] = []
    for _, name, one in close:
        if name not in found and rightly_called(selection, one):  # which fits: once a name is enough
            found.append(name)
    return found


def _same_when_locked(selection: Selection, rest: FittedSet, effect: Effect) -> list[str]:
    """Effects that follow the speed, as this one does, and explain nearly as much: nobody measures how far the braid of
    a locked muscle slides, and it slides as fast as the pressure changes."""
    alike = [e for e in selection.candidates if e.follows[:1] == effect.follows[:1] == ("speed",)]
    if len(alike) < 2:
        return []
    gains = _gains(selection, rest, alike)
    mine = gains.get(effect.name, 0.0)
    return [e.name for e in alike if e is not effect and gains.get(e.name, 0.0) > NEARLY * mine]


def _same_at_one_speed(selection: Selection, rest: FittedSet, effect: Effect) -> list[str]:
    """Effects that explain as much once each stroke is given one speed."""
    inputs = selection.record.inputs
    if inputs.velocity is None or inputs.stroke_speed is None or inputs.moving is None:
        return []
    nominal = inputs.direction * inputs.stroke_speed * inputs.moving
    record = replace(selection.record, inputs=replace(inputs, velocity=nominal))
    gains = _gains(selection, rest, [e for e in selection.candidates if e.name not in rest.names], record)
    mine = gains.get(effect.name, 0.0)
    levered = [e.name for e in selection.candidates if "speed" in e.levers or "speed" in effect.levers]
    close = [n for n, g in gains.items() if n != effect.name and n in levered and _as_much(g, mine)]
    return sorted(close, key=lambda n: -gains[n])


def _same_by_velocity(selection: Selection, rest: FittedSet, effect: Effect) -> list[str]:
    """Effects of the direction that explain nearly as much as one of the speed once each sample goes the way that its
    velocity says: where that is often not the way of its stroke, the track has turned more often than its noise
    shows."""
    inputs = selection.record.inputs
    if inputs.velocity is None or inputs.moving is None or effect.follows[:1] != ("speed",):
        return []
    way = np.where(inputs.moving & (inputs.velocity != 0.0), np.sign(inputs.velocity), inputs.direction)
    if np.mean(way != inputs.direction) < UNSURE * np.mean(inputs.moving):
        return []
    others = [e for e in selection.candidates if e.name not in rest.names and e.follows[:1] == ("direction",)]
    gains = _gains(selection, rest, others, replace(selection.record, inputs=replace(inputs, direction=way)))
    mine = _gains(selection, rest, [effect]).get(effect.name, 0.0)
    return sorted((n for n, g in gains.items() if g > NEARLY * mine), key=lambda n: -gains[n])


def _gains(
    selection: Selection, rest: FittedSet, effects: Sequence[Effect], record: Record | None = None
) -> dict[str, float]:
    """What the best form of each effect explains beyond a set, in whitened squares, by name; `record` may stand in."""
    data = selection.beyond(rest, effects, record)
    return {name: -criterion for name, (criterion, _) in data.best_of_each().items()}


def _as_much(gain: float, mine: float) -> bool:
    """Whether a gain in squares is as much as another, but for what two answers may differ by and a form may leave."""
    return gain > mine - max(CLOSE, 0.02 * mine)
