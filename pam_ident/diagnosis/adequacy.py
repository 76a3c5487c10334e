"""Whether an answer accounts for what the error follows, asked without the catalogue.

The rival of every answer is the free model: the law and smooth surfaces over the likeliest drivers, with the noise that
they leave. It has a likelihood and a price as a set of names has, and no name.
"""

import math
from collections import Counter
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from .follows import EQUAL, Following
from .noise import Noise, estimate_noise
from .nouns import Pattern
from .repeats import comes_back
from .trial import Trial, Verdict

PATTERN_MARGIN = 20.0
"""What a pattern costs more than a name."""
INEXACT, EXACT = 0.005, 0.001
"""Share of what is to be explained that the form of an effect may leave, because forms are never exactly right; and
that forms may leave which follow the same, because together they can come near to much."""


def full_cost(trial: Trial, verdict: Verdict) -> tuple[float, Noise]:
    """Deviance of a set with the noise it leaves, plus its price; and that noise."""
    noise = trial.noise_left_by(verdict)
    price = 0.0
    for term in verdict.terms:
        price += trial.price.per_parameter * len(term.form.params) + trial.price.per_name_alone
        price += 0.0 if term.effect.candidate else PATTERN_MARGIN
    return noise.deviance + price, noise


@dataclass(frozen=True)
class FreeModel:
    """The free model's `cost`, as `full_cost` has it, and its `noise`."""

    cost: float
    noise: Noise

    @classmethod
    def of(cls, trial: Trial) -> "FreeModel":
        """For the record, law and likeliest drivers of a trial."""
        following = trial.following
        surfaces, best = following.surfaces, following.best
        _, freedom = surfaces.of(best)
        slope = trial.law.around.contraction / trial.record.specimen.initial_length_mm
        left = following.newtons - surfaces.explained(best) / following.weight
        noise = estimate_noise(trial.record, left, slope, freedom + len(trial.base.values), trial.noise.outlier)
        return cls(noise.deviance + trial.price.per_parameter * freedom, noise)

    def odds(self, trial: Trial, verdict: Verdict) -> float:
        """Twice its log odds against a set with whatever noise that leaves."""
        return full_cost(trial, verdict)[0] - self.cost


@dataclass(frozen=True)
class Adequacy:
    """A set beside the free model."""

    trial: Trial
    verdict: Verdict
    free: FreeModel

    @classmethod
    def lacking(cls, trial: Trial, verdict: Verdict) -> "Adequacy | None":
        """What a set leaves with the names alone that may stand; None where it is complete, and of a table."""
        if trial.record.inputs.time is None:
            return None
        found = cls(trial, verdict, FreeModel.of(trial))
        return None if found.complete else replace(found, verdict=found.standing())

    @cached_property
    def left(self) -> Following:
        """What the set leaves, and what that follows."""
        trial, verdict = self.trial, self.verdict
        if not verdict.terms and verdict.values == trial.base.values:
            return trial.following
        return Following(trial.record, trial.base.model.adding(*verdict.terms), verdict.values, trial.following.unsure)

    @cached_property
    def unexplained(self) -> tuple[float, float]:
        """Squares that the set leaves beyond noise: as a share of the noise's, and of what is to be explained."""
        clean = ~self.free.noise.outlier
        left, alone = (float(np.mean(one.newtons[clean] ** 2)) for one in (self.left, self.trial.following))
        noise = self.free.noise.whole**2
        return (left - noise) / noise, (left - noise) / max(alone - noise, 1e-9 * noise)

    @cached_property
    def comes_back(self) -> float:
        """Share of the squares that the set leaves in its strokes which repeats of them share: no noise does that."""
        record, clean = self.trial.record, ~self.trial.noise.outlier
        return comes_back(record, self.trial.view(self.verdict).residual, clean)

    @property
    def complete(self) -> bool:
        """Whether what is left is noise, or what effects may leave whose forms are not exactly right."""
        if self.comes_back > self.trial.noise.too_small:
            return False
        odds = self.free.odds(self.trial, self.verdict)
        if odds < EQUAL:
            return True
        followed = [name for term in self.verdict.terms for name in term.effect.follows]
        if len(set(followed)) < len(followed):
            return odds < EQUAL + EXACT * self.trial.excess
        beyond, share = self.unexplained
        return beyond < self.trial.noise.too_small or (bool(followed) and share < INEXACT)

    def standing(self) -> Verdict:
        """The set with those of its names alone that may stand.

        What they follow must be there, whatever else is, and neither what is left nor another name may follow it.
        """
        followed = Counter(name for term in self.verdict.terms for name in term.effect.follows)
        sure = {name for name in self.trial.following.needed if followed[name] == 1} - self.left.drivers
        kept = [t for t in self.verdict.terms if not t.effect.candidate or sure.issuperset(t.effect.follows[:1])]
        return self.trial.refit(kept, self.verdict.values)

    def pattern(self) -> Pattern:
        """What is left, in the words of the contract."""
        first = next((f for f in self.left.shares() if f.what != "noise"), None)
        beyond, share = self.unexplained
        size = math.sqrt(max(beyond, self.comes_back)) * self.free.noise.whole
        text = f"about {size:.3g} N rms that no name explains{f'; it follows {first.text}' if first else ''}"
        return Pattern("other", first.what if first else "time", None, "", min(max(share, 0.0), 1.0), text)
