"""What a record cannot tell apart, and the test that would."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..effects import Effect
from ..model import Term
from ..records import Record
from .nouns import Experiment
from .search import Choice, Compressed
from .trial import Trial, Verdict

Array = np.ndarray
CLOSE = 9.0
"""Difference in cost (minus twice the log odds) up to which two effects count as not told apart."""
SPEED_RATIO = 1.5
"""Speeds closer than this are one speed: within a stroke, speed varies with contraction and proves nothing."""


def groups(trial: Trial, verdict: Verdict) -> tuple[tuple[str, ...], ...]:
    """For each selected effect that has one, the group of effects that could stand in its place."""
    found = []
    for term in verdict.terms:
        if not term.effect.candidate:
            continue
        rest = trial.refit(verdict.without(term), verdict.values)
        twins = _same_form(trial, term)
        twins += [n for n in _close(trial, verdict, rest, term.effect) if n not in twins]
        if one_speed(trial.record):
            twins += [n for n in _same_at_one_speed(trial, rest, term.effect) if n not in twins]
        twins = [n for n in twins if n not in verdict.names]
        if twins:
            found.append((term.effect.name, *twins[:3]))
    return tuple(found)


def one_speed(record: Record) -> bool:
    """Whether all strokes of a record in time have practically the same speed."""
    speed = record.inputs.stroke_speed
    if speed is None or record.inputs.moving is None:
        return False
    live = speed[record.inputs.moving]
    return len(live) > 0 and float(np.quantile(live, 0.95)) < SPEED_RATIO * float(np.quantile(live, 0.05))


def _same_form(trial: Trial, term: Term) -> list[str]:
    """The special case that goes by the name of the selected form: the same formula, so no record tells them apart."""
    cases = [e.name for e in trial.suspects if e.special_case_of == term.effect.name]
    return [name for name in cases if name.startswith(term.form.name.partition("_")[0])]


def _others(trial: Trial, verdict: Verdict, effect: Effect) -> list[Effect]:
    return [e for e in trial.suspects if e.name == effect.name or e.name not in verdict.names]


def _close(trial: Trial, verdict: Verdict, rest: Verdict, effect: Effect) -> list[str]:
    """Effects that cost nearly as little in the place of `effect`: looked up on compressed data, then fitted."""
    data = trial.beyond(rest, _others(trial, verdict, effect))
    best = _best_costs(trial, data)
    mine = min(best.get(effect.name, (np.inf, 0))[0], verdict.cost - rest.cost)
    found = []
    for name, (cost, atom) in best.items():
        if name != effect.name and cost < mine + 6.0 * CLOSE:
            gain, sizes = data.solve(data.columns([atom]))
            rival = trial.refit_choice(data, Choice((atom,), gain, cost, (sizes,)), rest)
            if rival.cost < verdict.cost + CLOSE:
                found.append((rival.cost, name))
    return [name for _, name in sorted(found)]


def _same_at_one_speed(trial: Trial, rest: Verdict, effect: Effect) -> list[str]:
    """Effects that explain as much once each stroke is given one speed."""
    inputs = trial.record.inputs
    if inputs.velocity is None or inputs.stroke_speed is None or inputs.moving is None:
        return []
    nominal = inputs.direction * inputs.stroke_speed * inputs.moving
    record = replace(trial.record, inputs=replace(inputs, velocity=nominal))
    data = trial.beyond(rest, [e for e in trial.suspects if e.name not in rest.names], record)
    gains = {name: -cost for name, (cost, _) in _best_costs(trial, data, priced=False).items()}
    mine = gains.get(effect.name, 0.0)
    levered = [e.name for e in trial.suspects if "speed" in e.levers or "speed" in effect.levers]
    close = [n for n, g in gains.items() if n != effect.name and n in levered and g > mine - max(CLOSE, 0.02 * mine)]
    return sorted(close, key=lambda n: -gains[n])


def _best_costs(trial: Trial, data: Compressed, priced: bool = True) -> dict[str, tuple[float, int]]:
    """Cheapest atom of each effect: its cost (or minus its gain) and its number."""
    best: dict[str, tuple[float, int]] = {}
    for k, atom in enumerate(data.atoms):
        gain, _ = data.solve(data.columns([k]))
        cost = (trial.price.of(atom) if priced else 0.0) - gain
        if cost < best.get(atom.effect, (np.inf, 0))[0]:
            best[atom.effect] = (cost, k)
    return best


def next_experiment(record: Record, found: Sequence[Sequence[str]], effects: dict[str, Effect]) -> Experiment | None:
    """The test that splits the first group: what its members respond to differently and the record lacks."""
    if not found:
        return None
    members = [effects[name] for name in found[0] if name in effects]
    levers = list(dict.fromkeys(lever for member in members for lever in member.levers))
    shared = [lever for lever in levers if all(lever in m.levers for m in members)]
    lacking = _lacking(record)
    kin = any(a.name == b.special_case_of for a in members for b in members)
    splitting = shared if kin else [v for v in levers if v not in shared]
    ordered = [v for v in levers if v in lacking] or splitting or levers
    if not ordered:
        return None
    words = {
        "speed": f"repeat {_middle(record):g} MPa at two speeds at least ten times apart, such as 2 and 40 mm/s",
        "pressure": "repeat the strokes at pressures over 4:1, such as 0.1 and 0.5 MPa",
        "hold": "hold the length for 1, 10 and 100 s after a stroke and log the force",
        "reversal": f"drive minor loops of 1, 3 and 10 mm at {_middle(record):g} MPa, at one slow speed",
        "temperature": "log the temperature and repeat the protocol 15 K warmer",
        "cycles": "run ten cycles, rest for an hour, and run the first again",
    }
    text = "; ".join(words.get(v, v) for v in ordered)
    return Experiment(tuple(ordered), f"To tell {' from '.join(found[0])}: {text}.")


def _middle(record: Record) -> float:
    return float(record.levels[len(record.levels) // 2])


def _lacking(record: Record) -> set[str]:
    """What a record does not vary, in the words of the contract."""
    inputs = record.inputs
    lacking = set()
    if one_speed(record) or inputs.velocity is None:
        lacking.add("speed")
    if len(record.levels) < 3:
        lacking.add("pressure")
    if inputs.moving is None or np.mean(~inputs.moving) < 0.05:
        lacking.add("hold")
    if inputs.temperature is None or np.ptp(inputs.temperature) < 5.0:
        lacking.add("temperature")
    if inputs.cycle is None or len(np.unique(inputs.cycle)) < 3:
        lacking.add("cycles")
    return lacking
