"""Whether an answer accounts for what the error follows, asked without the catalogue.

The rival of every answer is the free model: the law and smooth surfaces over the likeliest drivers, with the noise that
they leave. It has a likelihood and a penalty as a set of names has, and no name.
"""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from ..core.digits import newtons
from ..effects import Effect
from ..fitting import fit
from .follows import Following
from .noise import OTHER_SIZE, Noise
from .nouns import Pattern
from .remainder import OF_ALL, ONE_IN_100
from .repeats import comes_back
from .search import CLOSE
from .selection import FORM_TOLERANCE, FittedSet, Selection

EXACT = 0.001
"""Share of what is to be explained that forms may leave which follow the same, because together they can come near to
much."""
EVEN = 0.5
"""Chance from which something is likelier than not."""
MAY_LEAVE = (0.1, 0.05, 0.02)
"""Share of what is to be explained that one, two, or three names may leave, and stand beside something unknown: the
more names, the more they imitate. Of 15 single names that left less than a tenth one was false; three were at 0.02."""


def full_criterion(selection: Selection, fitted: FittedSet) -> tuple[float, Noise]:
    """Deviance of a set with the noise it leaves, plus its penalty; and that noise. A pattern pays for each place where
    it was looked for, too."""
    noise = selection.noise_left_by(fitted)
    penalty = 0.0
    for term in fitted.terms:
        penalty += selection.penalty.alone(term)
        if not term.effect.candidate:
            penalty += CLOSE + 2.0 * math.log(math.prod(max(len(p.grid), 1) for p in term.form.nonlinear))
    return noise.deviance + penalty, noise


def larger_than_noise(selection: Selection, fitted: FittedSet) -> bool:
    """Whether what a set leaves of a record in time is larger than the noise that it is taken for: its variance by more
    than OTHER_SIZE, and by more than such noise would once in a hundred records, which is much where it is slow.

    Noise is the same all the time, so it is as large as its innovations say. How large slow noise is beside what an
    unsure track shares is not known so well.
    """
    own, time = selection.noise_left_by(fitted), selection.record.inputs.time
    if time is None or (own.coloured and own.shared):
        return False
    left = selection.plain_residual(fitted.terms, fitted.values)[~own.outlier]
    chance = math.sqrt(2.0 * (1.0 + own.share**2 * own.memory_samples(time)) / len(left))
    return float(np.mean(left**2)) / own.whole**2 - 1.0 > max(OTHER_SIZE, ONE_IN_100 * chance)


@dataclass(frozen=True)
class FreeModel:
    """The free model's `criterion`, as `full_criterion` has it, and its `noise`."""

    criterion: float
    noise: Noise

    @classmethod
    @lru_cache(maxsize=4)
    def of(cls, selection: Selection) -> "FreeModel":
        """For the record, law and likeliest drivers of a selection."""
        return cls(selection.criterion_of_best, selection.noise_of_best(selection.noise.outlier)[0])

    def odds(self, selection: Selection, fitted: FittedSet) -> float:
        """Twice its log odds against a set with whatever noise that leaves."""
        return full_criterion(selection, fitted)[0] - self.criterion


@dataclass(frozen=True)
class Adequacy:
    """A set beside the free model."""

    selection: Selection
    fitted: FittedSet
    free: FreeModel

    @classmethod
    def lacking(cls, selection: Selection, fitted: FittedSet, remains: bool) -> "Adequacy | None":
        """The set beside the free model where it is incomplete; None where it is complete, and of a table.

        It is not where much `remains` of the noise that all drivers leave, whatever colour could take it for noise.
        """
        if selection.record.inputs.time is None:
            return None
        found = cls(selection, fitted, FreeModel.of(selection))
        return None if found.complete and not remains else found

    @cached_property
    def left(self) -> Following:
        """What the set leaves, and what that follows."""
        return _left_by(self.selection, self.fitted)

    @cached_property
    def unexplained(self) -> tuple[float, float]:
        """Squares that the set leaves beyond noise: as a share of the noise's, and of what is to be explained."""
        left, before, noise = self._squares
        return (left - noise) / noise, (left - noise) / max(before - noise, 1e-9 * noise)

    @cached_property
    def _squares(self) -> tuple[float, float, float]:
        """Mean squares in N² of what the set and the law alone leave, and of the noise."""
        clean, base = ~self.free.noise.outlier, self.selection.base
        if base.model.terms:
            alone = fit(replace(base.model, terms=()), base.record, detail=False).residual
        else:
            alone = self.selection.plain_residual((), base.values)
        left, before = (float(np.mean(one[clean] ** 2)) for one in (self.residual, alone))
        return left, before, self.free.noise.whole**2

    @property
    def _formed(self) -> bool:
        """Whether effects are in it, named or in the model already, whose forms may not be exactly right."""
        return bool(self.fitted.candidates or self.selection.base.model.terms)

    @cached_property
    def residual(self) -> np.ndarray:
        """What the set leaves in N, (n,), fitted without whitening."""
        return self.selection.plain_residual(self.fitted.terms, self.fitted.values)

    @cached_property
    def comes_back(self) -> float:
        """Share of the squares that the set leaves in its strokes which repeats of them share: no noise does that."""
        return comes_back(self.selection.record, self.residual, ~self.selection.noise.outlier)

    @property
    def wanders(self) -> bool:
        """Whether much of what the set leaves passes for slow noise, but smooth surfaces would follow it, too."""
        beyond, share = self.unexplained
        return beyond > self.selection.noise.too_small and share > OF_ALL

    @property
    def complete(self) -> bool:
        """Whether what is left is noise, or what effects may leave whose forms are not exactly right."""
        if larger_than_noise(self.selection, self.fitted) or self._returns or self._static_part_open:
            return False
        free = [term.effect.follows[:1] for term in self.fitted.terms if term.form.free]
        if len(set(free)) < len(free):  # no form speaks for either, and together they follow anything of that driver
            return False
        odds = self.free.odds(self.selection, self.fitted)
        if odds < CLOSE:
            return True
        followed = [name for term in self.fitted.terms for name in term.effect.follows]
        if len(set(followed)) < len(followed):
            return odds < CLOSE + EXACT * self.selection.excess
        beyond, share = self.unexplained
        return beyond < self.selection.noise.too_small or (self._formed and share < FORM_TOLERANCE)

    @property
    def _returns(self) -> bool:
        """Whether what comes back is too much for noise, and for forms that are not exactly right."""
        if self.comes_back <= self.selection.noise.too_small:
            return False
        left, before, noise = self._squares
        return not self._formed or self.comes_back * left > FORM_TOLERANCE * (before - noise)

    @property
    def _static_part_open(self) -> bool:
        """Whether the error follows pressure and contraction most, and of the names none does: over strokes that are
        all alike memories of them can imitate that, and nothing shows that it is memory, unless written forms say it
        better than the free model does."""
        following, names = self.selection.following, [term.effect for term in self.fitted.terms]
        if not names or not following.uncovered(names, ("map",)) or following.shares()[0].what != "map":
            return False
        return any(t.form.free for t in self.fitted.terms) or self.free.odds(self.selection, self.fitted) > -CLOSE

    def standing(self) -> "Adequacy":
        """The same with those names alone that may stand.

        What they follow must be likely, and no other name may follow it; and they must explain nearly all. Where
        several follow the same, one of them may by itself.
        """
        likely = self.selection.following.likely
        kept = self._following(likely)
        if kept.nearly_all:
            return kept
        named = [t for t in self.fitted.terms if t.effect.candidate and likely.issuperset(t.effect.follows[:1])]
        single = [replace(self, fitted=self.selection.refit([term], self.fitted.values)) for term in named]
        enough = [one for one in single if one.nearly_all]
        return min(enough, key=lambda one: one.fitted.criterion, default=self._following(frozenset()))

    @property
    def nearly_all(self) -> bool:
        """Whether the names explain as much as so many must that stand beside something unknown."""
        names = sum(t.effect.candidate for t in self.fitted.terms)
        return self.unexplained[1] < MAY_LEAVE[min(max(names, 1), len(MAY_LEAVE)) - 1]

    def _following(self, drivers: frozenset[str]) -> "Adequacy":
        """The same with the names that are the only ones to follow theirs, first one of some drivers."""
        followed = Counter(name for term in self.fitted.terms for name in term.effect.follows)
        sure = {name for name in drivers if followed[name] == 1}
        kept = [t for t in self.fitted.terms if not t.effect.candidate or sure.issuperset(t.effect.follows[:1])]
        return replace(self, fitted=self.selection.refit(kept, self.fitted.values))

    def pattern(self) -> Pattern:
        """What is left, in the words of the contract."""
        first = next((f for f in self.left.shares() if f.what != "noise"), None)
        beyond, share = self.unexplained
        size = max(beyond, self.comes_back)
        left = min(math.sqrt(size) * self.free.noise.whole, float(np.sqrt(np.mean(self.residual**2))))
        text = f"about {newtons(left)} rms"
        if size < self.selection.noise.too_small:
            text = "hardly more than noise in size, but no noise"
        text += f"; it follows {first.text}" if first else ""
        return Pattern("other", first.what if first else "time", None, "", min(max(share, 0.0), 1.0), text)


def _left_by(selection: Selection, fitted: FittedSet) -> Following:
    """What a set leaves, and what that follows."""
    if not fitted.terms and fitted.values == selection.base.values:
        return selection.following
    model = selection.base.model.adding(*fitted.terms)
    return Following(selection.record, model, fitted.values, selection.following.unsure)


def unknown_instead(
    selection: Selection, fitted: FittedSet, following: Following, known: Sequence[Effect]
) -> dict[str, float]:
    """Chance, by name of a set, that something unknown is there in its place, EVEN or more where that is likelier;
    `known` are the effects that were looked at."""
    found = {t.effect.name: following.unknown_instead(t.effect, known) for t in fitted.terms if t.effect.candidate}
    return dict.fromkeys(found, 0.0) if any(found.values()) and outdoes_free(selection, fitted) else found


def outdoes_free(selection: Selection, fitted: FittedSet) -> bool:
    """Whether a set is likelier than the free model and leaves no more than that does: then what the free model follows
    beside the names is no effect in their place."""
    if selection.record.inputs.time is None:
        return False
    found = Adequacy(selection, fitted, FreeModel.of(selection))
    return found.unexplained[0] <= 0.0 and found.free.odds(selection, fitted) < -CLOSE


def needless(selection: Selection, effect: Effect, others: FittedSet) -> bool:
    """Whether nothing speaks for an effect beside others that are complete without it, not by slow noise alone: they
    follow what it does first, or their drivers explain as much; or what they leave does not follow that."""
    if not effect.follows or selection.record.inputs.time is None:
        return False
    rest = Adequacy(selection, others, FreeModel.of(selection))
    if not rest.complete or rest.unexplained[1] > MAY_LEAVE[0]:
        return False
    first, followed = effect.follows[0], {name for term in others.terms for name in term.effect.follows}
    return first in followed or selection.following.enough(followed, first) or first not in rest.left.likely
