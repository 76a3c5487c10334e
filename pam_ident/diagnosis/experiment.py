"""The next experiment: the shortest run that is predicted to separate what a record leaves together.

Each candidate run is predicted with the effect that was found; then its rivals, in all their forms and with the law
fitted anew, try to follow it, and it tries to follow them. What they cannot follow, in squared standard errors of the
record's noise, is how well the run would separate them: the T-criterion of Atkinson & Fedorov 1975, Biometrika 62,
57–70, linearised. A run is judged by itself, for so it will be diagnosed: that an effect stays away in it decides
nothing.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..core import Inputs
from ..core.progress import tell
from ..core.prose import capital
from ..effects import Effect, in_words
from ..model import Term
from ..records import Record
from .dictionary import Regressor, closer, regressors_at
from .noise import Noise
from .nouns import Experiment, Pattern, Separation
from .possible_runs import PossibleRun, possible_runs
from .selection import FittedSet, Selection, tolerance
from .view import View
from .whitening import filter_gains

Array = np.ndarray
STEADIEST = 0.9999
"""Most that noise can keep from row to row: a stroke begins at the very moment at which the last one ends."""
ENOUGH = 10.0
"""Standard errors beyond which a pair counts as separated, were its forms exactly right: more are worth no time on the
rig."""
ALL = 0.9
"""Share that is as good as all: of the most that any run separates, and of what a pair needs."""
NEAR = 9
"""Points at which a rival's shape is searched on each side of the best on its grid."""
BARELY = 3.0
"""Standard errors below which a run separates nothing."""


def next_experiment(selection: Selection, fitted: FittedSet, classes: Sequence[Sequence[str]]) -> Experiment | None:
    """The shortest run that separates the groups `classes` as well as any, or makes surer what is loosely determined.

    The first name of a group is an effect of the set, the others are its rivals. None where nothing is open.
    """
    record, known = selection.record, {a.effect: a.term.effect for a in selection.regressors}
    terms = {t.effect.name: t for t in fitted.terms}
    questions = [Question(selection, fitted, terms[group[0]], [known[n] for n in group[1:]]) for group in classes]
    if not questions:
        alone = [Question(selection, fitted, t, []) for t in fitted.terms if t.effect.candidate]
        questions = [q for q in alone if q.separations(record.inputs)[0].standard_errors < ENOUGH]
    if not questions:
        return None
    law = replace(selection.base.model, terms=())
    runs: list[tuple[float, PossibleRun, tuple[Separation, ...]]] = []
    for possible in sorted(possible_runs(record, law, fitted.values), key=lambda c: c.cost):
        tell("trying the next experiment", len(runs))
        inputs = possible.strokes.inputs(record.specimen)
        found = tuple(s for q in questions for s in q.separations(inputs))
        runs.append((sum(s.share for s in found), possible, found))
        if min(s.share for s in found) >= 1.0:
            break
    if not runs:
        return None
    least = ALL * max(worth for worth, *_ in runs)
    _, best, found = next(run for run in runs if run[0] >= least)
    split = [s for s in found if s.standard_errors >= BARELY]
    if not split:
        return _out_of_reach(questions, found)
    own = [e for q in questions for e in q.effects]
    text = f"To {_aim(split, own)}: {best.strokes.words()}. {_promise(found, best.minutes, own)}"
    if best.beyond is not None:
        text += f" This goes above the {best.beyond:g} MPa of the record: only if the muscle is rated for it."
    return Experiment(best.vary, text, found, best.minutes, best.strokes)


class Question:
    """Whether a run would separate one effect of a set from its rivals, whichever is true, or from nothing where there
    are none."""

    def __init__(self, selection: Selection, fitted: FittedSet, term: Term, rivals: Sequence[Effect]) -> None:
        self.effects, self.noise, self.law = (term.effect, *rivals), selection.noise, selection.base.model
        self.ways = [(fitted, term.effect, rivals)]
        for rival in rivals:
            if instead := selection.best_of(fitted.names - {term.effect.name} | {rival.name}):
                self.ways.append((instead, rival, [term.effect]))

    def separations(self, inputs: Inputs) -> tuple[Separation, ...]:
        """Predicted separation from each rival by a run that gives a force law `inputs`, the lesser of both ways."""
        first, *others = [self._if_true(inputs, *way) for way in self.ways]
        found = {s.rival: s for s in first}
        for (back,) in others:
            ways = found[back.effect], replace(back, effect=first[0].effect, rival=back.effect)
            found[back.effect] = min(ways, key=lambda s: (s.share, s.standard_errors))
        return tuple(found.values())

    def _if_true(
        self, inputs: Inputs, fitted: FittedSet, effect: Effect, rivals: Sequence[Effect]
    ) -> tuple[Separation, ...]:
        """The same of an effect of a set that is true."""
        rest = self.law.adding(*(t for t in fitted.terms if t.effect.name != effect.name))
        force = self.law.adding(*fitted.terms).force(inputs, fitted.values)
        none = np.zeros(len(inputs), int)
        view = View(Record("run", inputs, force, inputs.pressure, none, none, inputs), rest, fitted.values)
        noise = _expected(self.noise, inputs)
        total, left = _left(view, noise, [a for rival in rivals for a in view.regressors(rival)])
        near = [
            regressor
            for rival in rivals
            for regressor in regressors_at(
                rival, left[rival.name][1].term.form, closer(left[rival.name][1], inputs, NEAR), inputs, view.around
            )
        ]
        _, nearer = _left(view, noise, near)
        squares: dict[str | None, float] = {
            e.name: min(found[e.name][0] for found in (left, nearer) if e.name in found) for e in rivals
        }
        needed = math.sqrt(ENOUGH**2 + (tolerance(total, len(inputs)) if squares else 0.0))
        squares = squares or {None: total}
        return tuple(Separation(effect.name, name, math.sqrt(square), needed) for name, square in squares.items())


def _left(
    view: View, noise: Noise, regressors: Sequence[Regressor]
) -> tuple[float, dict[str, tuple[float, Regressor]]]:
    """Whitened squares that the law leaves of a residual, and that each effect's best regressor does, with that one."""
    data = view.singly(regressors, noise)
    best = data.best_of_each().items()
    return data.total, {name: (max(data.total + criterion, 0.0), data.regressors[k]) for name, (criterion, k) in best}


def _expected(noise: Noise, inputs: Inputs) -> Noise:
    """The record's noise in a run that has not been made."""
    n = len(inputs)
    decay, gain, spread = np.zeros(n), np.zeros((n, 1)), np.ones((n, 1))
    if noise.coloured and inputs.time is not None:
        advance = np.ones(n) if noise.clock == "samples" else np.diff(inputs.time, prepend=inputs.time[0])
        decay = np.minimum(np.exp(-advance / noise.memory), STEADIEST)
        decay[0] = 0.0
        gain, spread = filter_gains(decay[:, None], np.array([noise.share]), np.zeros(n))
    parts = {"decay": decay, "gain": gain[:, 0], "spread": spread[:, 0], "outlier": np.zeros(n, bool)}
    return replace(noise, **parts, shared=None)  # whose position the run is to be driven to is known


def _aim(split: Sequence[Separation], own: Sequence[Effect]) -> str:
    told: dict[str, list[str]] = {}
    for s in split:
        told.setdefault(in_words(s.effect, own), []).extend([in_words(s.rival, own)] if s.rival else [])
    parts = [
        f"tell {name} from {' and '.join(rivals)}" if rivals else f"measure {name}" for name, rivals in told.items()
    ]
    return " and ".join(parts)


def _promise(found: Sequence[Separation], minutes: float, own: Sequence[Effect]) -> str:
    """What a run is predicted to show, with numbers, and what it leaves open."""
    far = [s for s in found if s.standard_errors >= BARELY]
    said = ", ".join(
        f"{in_words(s.effect, own)}{f' from {in_words(s.rival, own)}' if s.rival else ''} by {s.standard_errors:.0f}"
        for s in far
    )
    open_ = " and ".join(
        f"{in_words(s.effect, own)} from {in_words(s.rival, own)}" for s in found if s.rival and s not in far
    )
    verb = "separate" if far[0].rival else "show"
    text = f"In {minutes:.0f} minutes it would {verb} {said} standard errors."
    if vague := [s for s in far if s.share < ALL]:
        text += f" Below {max(s.needed for s in vague):.0f} a doubt is left."
    return f"{text} It would not tell {open_}." if open_ else text


def _out_of_reach(questions: Sequence[Question], found: Sequence[Separation]) -> Experiment:
    """No run of strokes separates them: what would, by the effects' own tests."""
    most = max(s.standard_errors for s in found)
    effects = {e.name: e for q in questions for e in q.effects}
    tests = "; ".join(f"for {e.title}: {e.test}" for e in effects.values())
    levers = tuple(dict.fromkeys(lever for e in effects.values() for lever in e.levers))
    names = " from ".join(e.title for e in effects.values())
    text = (
        f"As this record fits them, no run of strokes would tell {names} (by {most:.1f} standard errors at most). "
        f"What sets them apart where they differ: {tests}."
    )
    return Experiment(levers, text, tuple(found))


def after_pattern(pattern: Pattern, selection: Selection, fitted: FittedSet) -> Experiment:
    """What to do about a pattern that no known effect explains, and the run to do it with."""
    middle = f"{selection.record.levels[len(selection.record.levels) // 2]:g} MPa"
    lever, text = {
        "periodic": ("speed", "a ripple of the screw keeps its period in mm at another speed, one of the supply in s"),
        "local": ("reversal", f"turn the muscle about its axis at {middle}: a rub moves or goes"),
        "step": ("cycles", "mark the clamps: a slipped mount shows as a shifted length"),
        "trend": ("cycles", "tare before and after: a trend that goes on is the rig's"),
    }.get(pattern.kind, ("pressure", "then measure another muscle the same way: an error that both show is the rig's"))
    law = replace(selection.base.model, terms=())
    runs = [c for c in possible_runs(selection.record, law, fitted.values) if lever in c.vary]
    if not runs:
        return Experiment((lever,), f"{capital(text)}.")
    best = min(runs, key=lambda c: c.cost)
    text = f"{capital(best.strokes.words())}, {best.minutes:.0f} minutes in all; {text}."
    return Experiment(best.vary, text, minutes=best.minutes, protocol=best.strokes)
