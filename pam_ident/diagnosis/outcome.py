"""What an answer comes to: its verdict, what is left, how sure each name is, the noise, and all of it in words."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..core.digits import millimetres, newtons, number
from ..effects import Effect
from ..fitting import Fit, repeat_noise
from ..fitting.carried import length_rmse
from ..model import Term
from .adequacy import Adequacy, FreeModel, unknown_instead
from .answer import Selected
from .confirmed import impossible_alone
from .confounding import groups
from .follows import Following
from .late import logged_late
from .noise import OTHER_SIZE, Noise
from .nouns import Candidate, Diagnosis, Follows, Pattern
from .probability import BESIDE, BY_FORM, DOUBTFUL, LAPSE, by_form_alone, probabilities
from .ranking import ranked
from .remainder import hum, pattern_of, unlike_noise
from .repeats import rounding, step_of
from .selection import FittedSet, Selection
from .sentence import MORE, as_slow_noise, reservations, sentence

MANY = 0.1
"""Share of a record's samples from which they are no few."""


@dataclass(frozen=True, eq=False)
class Outcome:
    """The names of an answer that stand, `named`, largest first, in the fit `best`, and what that says.

    `fitted` is the set they come from, out of `selection`, and `lacking` that it is incomplete; `first` is what was
    selected before anything was taken back. `ruled_out` holds the fits of names whose values nature does not allow.
    `known` are the effects that were looked at or are in the model, `base` fitted without any name. Errors on held-out
    data `heldout` and `heldout_after`, and `noise_N` above which no noise is told, in N.
    """

    base: Fit
    best: Fit
    heldout: float
    heldout_after: float
    following: Following
    known: Sequence[Effect]
    first: Selected
    selection: Selection
    fitted: FittedSet
    lacking: Adequacy | None
    named: list[Term]
    ruled_out: dict[str, Fit]
    noise_N: float

    @property
    def selected(self) -> tuple[str, ...]:
        """The names."""
        return tuple(t.effect.name for t in self.named)

    @cached_property
    def patterns(self) -> list[Term]:
        """Shapes in the set that are no effect's."""
        return [t for t in self.fitted.terms if not t.effect.candidate]

    @cached_property
    def follows(self) -> tuple[Follows, ...]:
        """What the error of the law follows."""
        return self.following.shares()

    @cached_property
    def seen(self) -> Pattern | None:
        """What is left that no effect explains, rounding or not; of values against nature, what they are."""
        if self.lacking and (not self.patterns or hum(self.selection, self.fitted)):
            first = self.first
            odd = unlike_noise(first.selection, first.fitted) if first.lacking and first.lacking.complete else None
            found = odd or self.lacking.pattern()
        else:
            whole = self.fitted if self.patterns else self.selection.refit(self.named, self.fitted.values)
            found = pattern_of(self.selection, whole)
        if found and found.kind == "other" and (leap := self.following.leap):
            found = Pattern("step", "time", leap.moment, "s", found.share, leap.text)
        wrong = impossible_alone(self.base, self.best, self.fitted, self.ruled_out)
        return wrong if wrong and (found is None or found.kind == wrong.kind) else found

    @cached_property
    def rounded(self) -> bool:
        """Whether what is left beside no name may be the rounding of the force: that is no less, nor too small to
        matter, and what is left has no look of its own."""
        if not self.seen or self.named:
            return False
        rounds = rounding(step_of(self.selection.record))
        if rounds < max(self.base.rmse**2 - self.floor**2, self.selection.noise.too_small * self.floor**2):
            return False
        return unlike_noise(self.selection, self.selection.empty) is None

    @property
    def pattern(self) -> Pattern | None:
        """What is left that neither an effect nor rounding explains."""
        return None if self.rounded else self.seen

    @property
    def verdict(self) -> str:
        """Adequate, missing_effect or unknown_effect."""
        return "unknown_effect" if self.pattern else "missing_effect" if self.named else "adequate"

    @cached_property
    def classes(self) -> tuple[tuple[str, ...], ...]:
        """Each name that the record cannot tell from others, with these."""
        return tuple(group for group in groups(self.selection, self.fitted) if group[0] in self.selected)

    @cached_property
    def slow(self) -> bool:
        """Whether part of what is left beside names passes for slow noise, but may be more."""
        if not self._complete_in_time:
            return False
        return Adequacy(self.selection, self.fitted, FreeModel.of(self.selection)).wanders

    @cached_property
    def unfollowed(self) -> tuple[str, ...]:
        """Drivers that the error follows beside names of which none does."""
        if not self._complete_in_time:
            return ()
        chosen = [one.what for one in self.follows if one.what in self.following.chosen]
        return self.following.uncovered(self.known, chosen)

    @property
    def unread(self) -> bool:
        """Whether more than noise is left beside names, and many samples were left aside, as where a drive turns all
        the time: what they hold nobody looked at."""
        left = self.best.rmse**2 > (1.0 + OTHER_SIZE) * self.floor**2
        return self._complete_in_time and left and float(np.mean(self._noise.outlier)) > MANY

    @property
    def _complete_in_time(self) -> bool:
        return bool(self.named) and self.selection.record.inputs.time is not None and not self.seen

    @cached_property
    def unknown_instead(self) -> dict[str, float]:
        """Chance, by name, that something unknown is there in its place."""
        return unknown_instead(self.selection, self.fitted, self.following, self.known)

    @cached_property
    def by_form(self) -> dict[str, tuple[float, str]]:
        """Names for which only a form speaks, as `by_form_alone` has them."""
        complete = self.pattern is None
        return by_form_alone(self.selection, self.fitted, self.named, self.classes, self.follows[0].text, complete)

    @property
    def worse(self) -> bool:
        """Whether held-out data are predicted worse with the names than without."""
        return bool(self.named) and self.heldout_after > self.heldout

    @cached_property
    def chance(self) -> dict[str, float]:
        """Chance, by candidate, that it belongs to the answer; beside something unknown of those that stand alone."""
        doubtful = self.seen or self.slow or self.unfollowed or self.unread
        lapse = BESIDE if self.pattern else DOUBTFUL if doubtful else LAPSE
        chance = probabilities(self.selection, self.classes, self.selected, lapse)
        kept = set(self.selected).union(*self.classes) if self.lacking else set(chance)
        by_form = dict.fromkeys(chance, BY_FORM if self.worse else 1.0)
        for name in by_form:
            alike = {name}.union(*(group[:1] for group in self.classes if name in group))
            by_form[name] *= min(self.by_form.get(one, (1.0, ""))[0] for one in alike)
        return {
            name: chance[name] * (1.0 - self.unknown_instead.get(name, 0.0)) * by_form[name]
            for name in chance
            if name in kept and name not in self.ruled_out
        }

    @cached_property
    def floor(self) -> float:
        """The noise in N."""
        found = _as_measured(min(self._noise.whole, self._error), self.best)
        fits = (self.base, self.best) if self.lacking or self.seen else ()
        between = [seen.sigma for one in fits if (seen := repeat_noise(one))]
        if self.lacking:  # the names that are not all there are do not touch it
            found = min(*(between or [found]), _as_measured(self.lacking.free.noise.whole, self.best), self.best.rmse)
        elif self.seen and not self.named and self.selection.record.inputs.time is not None:
            found = min(found, math.sqrt(self.follows[-1].share) * self.base.rmse)  # noise follows nothing
        if self.seen:  # what is left may hide in noise that was fitted beside it, but not in what repeats differ by
            found = min([found, *between])
        return min(found, self.noise_N)

    @cached_property
    def _error(self) -> float:
        """Error of the set in N, single rows far off left out."""
        left = self.selection.view(self.fitted).residual[~self._noise.outlier]
        return float(np.sqrt(np.mean(left**2)))

    @cached_property
    def _noise(self) -> Noise:
        return self.selection.noise_left_by(self.fitted) if self.patterns else self.selection.noise

    def ranking(self, candidates: list[Effect], errors: bool = True) -> tuple[Candidate, ...]:
        """Every candidate, as `ranked` has it."""
        after = self.best.rmse, self.heldout_after
        return ranked(self.base, self.selection, candidates, self.named, self.chance, after, errors)

    def diagnosis(self, candidates: list[Effect], extra: tuple[Effect, ...]) -> Diagnosis:
        """All of it but its details; `extra` are effects beside the catalogue's."""
        whole = len(self.following.record) == len(self.base.record)
        return Diagnosis(
            self.base,
            self.best,
            self.verdict,
            self.selected,
            tuple(t.label for t in self.named),
            self.classes,
            self.ranking(candidates, errors=False),
            self.floor,
            self.heldout,
            self.heldout_after,
            self.pattern,
            None,
            self.sentence(extra),
            self.follows,
            {"followed": self.following.newtons_followed} if whole else {},
        )

    def sentence(self, extra: tuple[Effect, ...]) -> str:
        """All of it in words; `extra` are effects beside the catalogue's."""
        labels = [t.label for t in self.named]
        far = 0 if self._error > MORE * self._noise.whole else int(self._noise.outlier.sum())
        least = min((self.chance.get(name, 0.0) for name in self.selected), default=0.0)
        said = sentence(self.base, self.best, labels, least, self.classes, self.pattern, self.floor, far, extra)
        record = self.selection.record
        if self.rounded:
            said += f" What is left may be rounding: the force was read in steps of {newtons(step_of(record))}."
        elif self.verdict == "adequate" and self._noise.coloured:
            said += as_slow_noise(self.follows)
        if not self.pattern and (period := hum(self.selection, self.fitted)):
            said += (
                f" The noise hums: it has a beat with a period of {number(period, 3)} s, smaller than the rest of it."
            )
        if self.pattern and not self.fitted.terms and self.follows[0].what == "speed":
            said += f" {logged_late(self.selection, self.floor**2)}".rstrip()
        if self.slow:
            said += " Less sure: part of what is left passes for slow noise, but may follow what was driven as well."
        elif self.unfollowed:
            too = " and ".join(one.text for one in self.follows if one.what in self.unfollowed)
            said += f" Less sure: the error follows {too}, too, and no effect that was tried does."
        if self.worse:
            said += " Less sure: with what is named, held-out data are predicted worse than without."
        return said + reservations({name: self.unknown_instead[name] for name in self.selected}, self.by_form, extra)

    @cached_property
    def lengths(self) -> tuple[float | None, float | None]:
        """Error in mm of the law, and with the names, fitted to the length where that answered."""
        off = length_rmse(self.base)
        return off, off if self.best is self.base else length_rmse(self.best)

    @property
    def held_load(self) -> str:
        """Of a record in which a load was held, what its errors are, in words."""
        if not self.base.record.carried:
            return ""
        told = " → ".join(millimetres(one) for one in dict.fromkeys(self.lengths) if one is not None)
        said = " A load was held and the length answered: errors are those of the force at the measured length"
        return said + (f"; fitted to the length, the model errs by {told}." if told else ".")


def _as_measured(noise: float, found: Fit) -> float:
    """Noise in N with what that of the pressure and displacement sensors adds by a fit, of its size in N without."""
    calm = found.model.force(found.record.steady, found.values)
    return min(math.hypot(noise, float(np.sqrt(np.mean((found.force - calm) ** 2)))), found.rmse)
