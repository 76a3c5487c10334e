"""The next experiment: the run that is predicted to tell most, for its time on the rig.

Each candidate run is predicted with the effect that was found; then its rivals, in all their forms and with the law
fitted anew, try to follow record and run together. What they cannot follow, in squared standard errors of the noise, is
how well the run would separate them: the T-criterion of Atkinson & Fedorov 1975, Biometrika 62, 57–70, linearised.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..core import Inputs
from ..effects import Effect
from ..model import Term
from ..records import Record
from .candidates import Candidate, candidates
from .dictionary import Atom
from .noise import Noise, filter_gains
from .nouns import Experiment, Pattern, Separation
from .search import Compressed
from .trial import Trial, Verdict, View

Array = np.ndarray
ENOUGH = 10.0
"""Standard errors beyond which a pair counts as separated: more are worth no time on the rig."""
BARELY = 3.0
"""Standard errors below which a run separates nothing."""


def next_experiment(trial: Trial, verdict: Verdict, classes: Sequence[Sequence[str]]) -> Experiment | None:
    """The run that separates the groups `classes` best for its time, or makes surer what is loosely determined.

    The first name of a group is an effect of the verdict, the others are its rivals. None where nothing is open.
    """
    known = {e.name: e for e in trial.suspects}
    terms = {t.effect.name: t for t in verdict.terms}
    questions = [Question(trial, verdict, terms[group[0]], [known[n] for n in group[1:]]) for group in classes]
    if not questions:
        alone = [Question(trial, verdict, t, []) for t in verdict.terms if t.effect.candidate]
        questions = [q for q in alone if q.separations()[0].standard_errors < ENOUGH]
    if not questions:
        return None
    law = replace(trial.base.model, terms=())
    scored = []
    for candidate in candidates(trial.record, law, verdict.values):
        found = tuple(s for q in questions for s in q.separations(candidate))
        worth = sum(min(s.standard_errors, ENOUGH) ** 2 for s in found) / candidate.minutes
        scored.append((worth, candidate, found))
    _, best, found = max(scored, key=lambda item: item[0])
    split = [s for s in found if s.standard_errors >= BARELY]
    if not split:
        return _out_of_reach(questions, found)
    text = f"To {_aim(split)}: {best.strokes.words()}. {_promise(found, best.minutes)}"
    return Experiment(best.vary, text, found, best.minutes, best.strokes)


class Question:
    """Whether a run would separate one effect of a verdict from its rivals, or from nothing where there are none."""

    def __init__(self, trial: Trial, verdict: Verdict, term: Term, rivals: Sequence[Effect]) -> None:
        self.effect, self.rivals = term.effect, rivals
        self.noise, self.specimen = trial.noise, trial.record.specimen
        self.whole = trial.base.model.adding(*verdict.terms)
        self.rest = trial.base.model.adding(*verdict.without(term))
        self.values = verdict.values
        self.record = self._signals(_one_speed_a_stroke(trial.record.inputs), trial.noise).packed()

    def separations(self, candidate: Candidate | None = None) -> tuple[Separation, ...]:
        """Predicted separation from each rival by the record, with the run of a candidate if one is given."""
        signals = self.record
        if candidate is not None:
            inputs = candidate.strokes.inputs(self.specimen)
            signals = signals.joined(self._signals(inputs, _expected(self.noise, inputs)))
        left = signals.left()
        names = [e.name for e in self.rivals] or [None]
        return tuple(Separation(self.effect.name, name, float(np.sqrt(left[name]))) for name in names)

    def _signals(self, inputs: Inputs, noise: Noise) -> "_Signals":
        """The effect's force as the verdict predicts it, what the rest of the model can do about it, and the rivals."""
        none = np.zeros(len(inputs), int)
        force = self.whole.force(inputs, self.values)
        view = View(Record("run", inputs, force, inputs.pressure, none, none, inputs), self.rest, self.values)
        atoms = {_key(a): a for rival in self.rivals for a in view.atoms(rival)}
        columns = noise.whiten(np.hstack([view.law, view.residual[:, None], *[a.columns for a in atoms.values()]]))
        return _Signals(atoms, columns)


@dataclass(frozen=True)
class _Signals:
    """Whitened rows of a record or run: the law's slopes, the effect's force, then the columns of its rivals' atoms."""

    atoms: dict[tuple[object, ...], Atom]
    columns: Array

    def _parts(self) -> tuple[Array, dict[tuple[object, ...], Array]]:
        widths = [a.columns.shape[1] for a in self.atoms.values()]
        edges = np.cumsum([self.columns.shape[1] - sum(widths), *widths])[:-1]
        first, *others = np.split(self.columns, edges, axis=1)
        return first, dict(zip(self.atoms, others, strict=True))

    def packed(self) -> "_Signals":
        """As many rows as columns, which say the same in every least-squares problem."""
        return replace(self, columns=np.linalg.qr(self.columns, mode="r"))

    def joined(self, run: "_Signals") -> "_Signals":
        """A run's rows below these, with the atoms that both have."""
        (mine, my_atoms), (its, its_atoms) = self._parts(), run._parts()
        both = {k: a for k, a in self.atoms.items() if k in its_atoms}
        rows = [np.hstack([mine, *[my_atoms[k] for k in both]]), np.hstack([its, *[its_atoms[k] for k in both]])]
        return _Signals(both, np.vstack(rows))

    def left(self) -> dict[str | None, float]:
        """Squares of the effect's force that the law leaves (None), and that the best atom of each rival leaves."""
        first, parts = self._parts()
        data = Compressed(list(self.atoms.values()), list(parts.values()), first[:, :-1], first[:, -1])
        left: dict[str | None, float] = {None: data.total}
        for k, atom in enumerate(data.atoms):
            gain, _ = data.solve(data.columns([k]))
            left[atom.effect] = max(min(left.get(atom.effect, np.inf), data.total - gain), 0.0)
        return left


def _key(atom: Atom) -> tuple[object, ...]:
    return (atom.effect, atom.term.form.name, *atom.shapes.items())


def _one_speed_a_stroke(inputs: Inputs) -> Inputs:
    """Speed within a stroke varies with contraction, and so may any friction: it is no evidence."""
    if inputs.velocity is None or inputs.stroke_speed is None or inputs.moving is None:
        return inputs
    return replace(inputs, velocity=inputs.direction * inputs.stroke_speed * inputs.moving)


def _expected(noise: Noise, inputs: Inputs) -> Noise:
    """The record's noise in a run that has not been made."""
    assert inputs.time is not None
    n = len(inputs)
    decay, gain, spread = np.zeros(n), np.zeros((n, 1)), np.ones((n, 1))
    if noise.coloured:
        advance = np.ones(n) if noise.clock == "samples" else np.diff(inputs.time, prepend=inputs.time[0])
        decay = np.exp(-advance / noise.memory)
        decay[0] = 0.0
        gain, spread = filter_gains(decay[:, None], np.array([noise.share]), np.zeros(n))
    return replace(noise, decay=decay, gain=gain[:, 0], spread=spread[:, 0], outlier=np.zeros(n, bool))


def _aim(split: Sequence[Separation]) -> str:
    told: dict[str, list[str]] = {}
    for s in split:
        told.setdefault(s.effect, []).extend([s.rival] if s.rival else [])
    parts = [
        f"tell {name} from {' and '.join(rivals)}" if rivals else f"measure {name}" for name, rivals in told.items()
    ]
    return " and ".join(parts)


def _promise(found: Sequence[Separation], minutes: float) -> str:
    """What a run is predicted to show, with numbers, and what it leaves open."""
    far = [s for s in found if s.standard_errors >= BARELY]
    said = ", ".join(f"{s.effect} from {s.rival or 'nothing'} by {s.standard_errors:.0f}" for s in far)
    open_ = " and ".join(f"{s.effect} and {s.rival}" for s in found if s.rival and s not in far)
    text = f"In {minutes:.0f} minutes it would separate {said} standard errors."
    return f"{text} It would leave {open_} together." if open_ else text


def _out_of_reach(questions: Sequence[Question], found: Sequence[Separation]) -> Experiment:
    """No run of strokes separates them: what would, by the effects' own tests."""
    most = max(s.standard_errors for s in found)
    effects = {e.name: e for q in questions for e in (q.effect, *q.rivals)}
    tests = "; ".join(f"for {name}: {e.test}" for name, e in effects.items())
    levers = tuple(dict.fromkeys(lever for e in effects.values() for lever in e.levers))
    text = f"No run of strokes would tell {' from '.join(effects)} (by {most:.1f} standard errors at most): {tests}."
    return Experiment(levers, text, tuple(found))


def after_pattern(pattern: Pattern, trial: Trial, verdict: Verdict) -> Experiment:
    """What to do about a pattern that no known effect explains, and the run to do it with."""
    middle = f"{trial.record.levels[len(trial.record.levels) // 2]:g} MPa"
    lever, text = {
        "periodic": ("speed", "a ripple of the screw keeps its period in mm at another speed, one of the supply in s"),
        "local": ("reversal", f"turn the muscle about its axis at {middle}: a rub moves or goes"),
        "step": ("cycles", "mark the clamps: a slipped mount shows as a shifted length"),
        "trend": ("cycles", "tare before and after: a trend that goes on is the rig's"),
    }.get(pattern.kind, ("pressure", "take a second specimen: what stays is the rig's"))
    law = replace(trial.base.model, terms=())
    runs = [c for c in candidates(trial.record, law, verdict.values) if lever in c.vary]
    if not runs:
        return Experiment((lever,), f"{text[0].upper()}{text[1:]}.")
    best = min(runs, key=lambda c: c.minutes)
    words = best.strokes.words()
    return Experiment(best.vary, f"{words[0].upper()}{words[1:]}; {text}.", minutes=best.minutes, protocol=best.strokes)
