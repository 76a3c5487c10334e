"""What lies on the bench: a record, a model of it, where that fails and what it may lack. Nothing here draws."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ..core import PamError, UsageError
from ..core.progress import steps
from ..diagnosis import compare
from ..diagnosis.nouns import Comparison, Diagnosis, Ladder, Rung
from ..fitting import Fit, fit
from ..fitting.carried import driven
from ..records import Record
from ..records.doubt import Doubt, grave
from ..report import Story, render
from ..report.story import provenance
from ..schema.diagnosis import candidates
from ..tasks.diagnose import diagnosing_record
from ..tasks.gate import admit, computing, doubts_about
from ..tasks.ladder import ladder_by_hand
from ..tasks.section import section_of
from ..tasks.setup import Setup

MOST_CANDIDATES = 7
"""Candidates that are tried before anybody asks; the others can be added by name."""


@dataclass(frozen=True)
class Preview:
    """What adding an effect would do: the `rmse` in N that it leaves, and what it would take from the error, in N,
    shape (n,). `probability` is the diagnosis'."""

    label: str
    probability: float
    rmse: float
    takes: np.ndarray


@dataclass(frozen=True)
class Bench:
    """A record at `path` with a rung for each model from the law alone to the present one.

    `diagnosis` is of the present model, None until it is asked for; `first` is that of the law alone. `path` is as the
    user knows it, and goes into the command that repeats what was done. `held` are parameters that are held by hand;
    `previews` what the candidates would do, once that has been tried.
    """

    record: Record
    path: str
    setup: Setup
    rungs: tuple[Rung, ...]
    diagnosis: Diagnosis | None = None
    first: Diagnosis | None = None
    held: Mapping[str, float] = field(default_factory=dict)
    previews: tuple[Preview, ...] = ()

    @classmethod
    def begin(cls, record: Record, path: str, setup: Setup) -> "Bench":
        """Fit the law alone, and then with each effect of `setup` more. An isotonic record is taken along the lengths
        that the law predicts. Raises FitError, DataError or UsageError."""
        admit(record)
        with computing(record):
            record = driven(setup.law_alone, record)
        return cls(record, path, setup, ladder_by_hand(record, setup, {}, None))

    @property
    def fit(self) -> Fit:
        """The present model."""
        return self.rungs[-1].fit

    @property
    def law_alone(self) -> Fit:
        """The law without effects."""
        return self.rungs[0].fit

    @cached_property
    def doubts(self) -> tuple[Doubt, ...]:
        """What looks wrong in the record, or in the law on it, the grave first."""
        return doubts_about(self.law_alone)

    @property
    def stopped(self) -> bool:
        """Whether a grave doubt stops naming."""
        return bool(grave(self.doubts, self.setup.assume))

    def all_the_same(self) -> "Bench":
        """With every grave doubt taken as meant so."""
        return replace(self, setup=replace(self.setup, assume=("all",)))

    @cached_property
    def comparison(self) -> Comparison:
        """Where the present model fails; what the error follows is the diagnosis' to say, nothing before it."""
        return compare(self.fit, self.diagnosis.follows if self.diagnosis else ())

    @property
    def followed(self) -> np.ndarray | None:
        """What of the present error follows anything, in N, shape (n,); None before the diagnosis, and of a record too
        long to be looked at whole."""
        return self.diagnosis.details.get("followed") if self.diagnosis else None

    @property
    def noise_floor(self) -> float | None:
        """In N, as the latest diagnosis has it."""
        last = self.diagnosis or self.first
        return last.noise_floor if last else None

    @property
    def ladder(self) -> Ladder | None:
        """The rungs as a ladder; None before a diagnosis has found the noise floor."""
        last = self.diagnosis or self.first
        return Ladder(self.rungs, last.noise_floor, last) if last else None

    @property
    def judged(self) -> bool:
        """Whether the present model is diagnosed, and what every candidate would leave is known."""
        ranking = self.diagnosis.ranking if self.diagnosis else ()
        tried = [one.rmse_after is not None for one in ranking if one.status == "candidate"]
        return self.diagnosis is not None and (any(tried) or not tried)

    def diagnosing(self) -> Iterator["Bench"]:
        """With the diagnosis of the present model as soon as it is there, and then with all that belongs to it.

        Raises FitError or DataError, UsageError with parameters held.
        """
        if self.held:
            raise UsageError("nothing is named while a parameter is held by hand; release it first")
        bench = self
        for found in diagnosing_record(self.record, self.setup):
            record = found.base.record
            if record.carried and record is not bench.record:  # it lies nearer to the lengths as measured
                bench = replace(bench, record=record, rungs=ladder_by_hand(record, self.setup, {}, self.diagnosis))
            yield replace(bench, diagnosis=found, first=self.first if self.fit.model.terms else found)

    def diagnosed(self) -> "Bench":
        """With all of it. Raises as `diagnosing` does."""
        *_, last = self.diagnosing()
        return last

    def tried(self) -> "Bench":
        """With what each candidate would do, fitted as `adding` fits it; the most probable first, of those that are
        alike the one that leaves the least."""
        with computing(self.record):
            found = sorted(self._tried(), key=lambda p: (-round(100 * p.probability), p.rmse))
        return replace(self, previews=tuple(found))

    def _tried(self) -> Iterator[Preview]:
        found = self.diagnosis
        named = {label.partition(":")[0]: label for label in found.labels} if found else {}
        for one in steps(candidates(found)[:MOST_CANDIDATES] if found else [], "trying candidates"):
            label = named.get(one.effect, one.label)
            try:
                added = fit(replace(self.setup, effects=(*self.setup.effects, label)).model, self.record)
            except PamError:
                continue
            yield Preview(label, one.probability, added.rmse, self.fit.residual - added.residual)

    def holding(self, held: Mapping[str, float]) -> "Bench":
        """With some parameters held at values, all others fitted; none releases them. Raises FitError."""
        if not held:
            return self._with(self.setup.effects)
        with computing(self.record):
            one = fit(self.fit.model, self.record, start=self.fit.values, held=held)
        rung = replace(self.rungs[-1], fit=one, heldout_rmse=math.nan)
        return replace(self, rungs=(*self.rungs[:-1], rung), diagnosis=None, held=dict(held), previews=())

    def adding(self, label: str) -> "Bench":
        """With one effect more, `name` or `name:form`. Raises UsageError, FitError or DataError."""
        return self._with((*self.setup.effects, label))

    def removing(self, name: str) -> "Bench":
        """With one effect less. Raises UsageError where the model does not hold it."""
        left = tuple(label for label in self.setup.effects if label.partition(":")[0] != name)
        if len(left) == len(self.setup.effects):
            raise UsageError(f"the model holds no effect {name!r} to take out")
        return self._with(left)

    def _with(self, effects: tuple[str, ...]) -> "Bench":
        setup = replace(self.setup, effects=effects)
        known = {rung.effects: rung for rung in (self.rungs[:-1] if self.held else self.rungs)}
        rungs = ladder_by_hand(self.record, setup, known, self.diagnosis)
        return replace(self, setup=setup, rungs=rungs, diagnosis=None, held={}, previews=())

    @property
    def command(self) -> str:
        """The command line that fits the same again."""
        return self.setup.command("add" if self.setup.effects else "compare", self.path)

    def report(self) -> str:
        """The ladder that was climbed as one HTML page. Raises UsageError before the first diagnosis."""
        steps, found = self.ladder, self.first or self.diagnosis
        if steps is None or found is None:
            raise UsageError("nothing to report yet: let the workbench find what is missing first")
        after = self.fit if self.fit.model.terms else None
        section = section_of(self.record, self.law_alone, found, steps, after)
        source = provenance({self.path: self.record}, self.command)
        return render(Story(f"{self.record.name}: {self.law_alone.model.law.title}", (section,), source))
