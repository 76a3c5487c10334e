"""What a record cannot tell apart."""

from dataclasses import replace

import numpy as np

from ..effects import Effect
from ..model import Term
from .follows import one_speed
from .search import Choice
from .trial import Trial, Verdict

Array = np.ndarray
CLOSE = 18.0
"""Difference in cost up to which two effects count as not told apart: odds of 10, tempered (`probability.TEMPER`)."""


def groups(trial: Trial, verdict: Verdict) -> tuple[tuple[str, ...], ...]:
    """For each selected effect that has one, the group of effects that could stand in its place."""
    found = []
    for term in verdict.terms:
        if not term.effect.candidate:
            continue
        rest = trial.refit(verdict.without(term), verdict.values)
        twins = _same_form(trial, term)
        twins += [n for n in _close(trial, verdict, rest, term.effect) if n not in twins]
        twins += [n for n in _fitted(trial, verdict, term.effect) if n not in twins]
        if one_speed(trial.record):
            twins += [n for n in _same_at_one_speed(trial, rest, term.effect) if n not in twins]
        twins = [n for n in twins if n not in verdict.names]
        if twins:
            found.append((term.effect.name, *twins[:3]))
    return tuple(found)


def _same_form(trial: Trial, term: Term) -> list[str]:
    """The special case that goes by the name of the selected form: the same formula, so no record tells them apart."""
    cases = [e.name for e in trial.suspects if e.special_case_of == term.effect.name]
    return [name for name in cases if name.startswith(term.form.name.partition("_")[0])]


def _others(trial: Trial, verdict: Verdict, effect: Effect) -> list[Effect]:
    """An effect and those outside a set; what the law follows nearly, too, which a large misfit may still be.

    Not its own special cases: with more parameters they can always do the same.
    """
    others = [e for e in (*trial.suspects, *trial.absorbed) if e.special_case_of != effect.name]
    return [e for e in others if e.name == effect.name or e.name not in verdict.names]


def _close(trial: Trial, verdict: Verdict, rest: Verdict, effect: Effect) -> list[str]:
    """Effects that cost nearly as little in the place of `effect`: looked up on compressed data, then fitted."""
    data = trial.beyond(rest, _others(trial, verdict, effect))
    best = data.cheapest(trial.price)
    mine = min(best.get(effect.name, (np.inf, 0))[0], verdict.cost - rest.cost)
    found = []
    for name, (cost, atom) in best.items():
        if name != effect.name and cost < mine + 3.0 * CLOSE:
            gain, sizes = data.solve(data.columns([atom]))
            rival = trial.refit_choice(data, Choice((atom,), gain, cost, (sizes,)), rest)
            if rival.cost < verdict.cost + CLOSE:
                found.append((rival.cost, name))
    return [name for _, name in sorted(found)]


def _fitted(trial: Trial, verdict: Verdict, effect: Effect) -> list[str]:
    """Effects that cost nearly as little in the place of `effect` in a set that was fitted, in whatever form."""
    rest = verdict.names - {effect.name}
    rivals = [v for v in trial.weighed() if rest < v.names and len(v.names) == len(verdict.names)]
    close = sorted((v for v in rivals if v.cost < verdict.cost + CLOSE), key=lambda v: v.cost)
    names = dict.fromkeys(name for v in close for name in v.names - rest)
    others = [e.name for e in _others(trial, verdict, effect)]
    return [name for name in names if name in others and name != effect.name]


def _same_at_one_speed(trial: Trial, rest: Verdict, effect: Effect) -> list[str]:
    """Effects that explain as much once each stroke is given one speed."""
    inputs = trial.record.inputs
    if inputs.velocity is None or inputs.stroke_speed is None or inputs.moving is None:
        return []
    nominal = inputs.direction * inputs.stroke_speed * inputs.moving
    record = replace(trial.record, inputs=replace(inputs, velocity=nominal))
    data = trial.beyond(rest, [e for e in trial.suspects if e.name not in rest.names], record)
    gains = {name: -cost for name, (cost, _) in data.cheapest().items()}
    mine = gains.get(effect.name, 0.0)
    levered = [e.name for e in trial.suspects if "speed" in e.levers or "speed" in effect.levers]
    close = [n for n, g in gains.items() if n != effect.name and n in levered and g > mine - max(CLOSE, 0.02 * mine)]
    return sorted(close, key=lambda n: -gains[n])
