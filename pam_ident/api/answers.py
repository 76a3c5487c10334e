"""Comparisons, diagnoses, ladders, batches and runs of a leg, as one meets them at the prompt."""

import textwrap
from abc import ABC, abstractmethod
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..core import UsageError
from ..core.digits import percent, probability, three
from ..core.files import check_target, write_json
from ..fitting import Fit
from ..records.doubt import Doubt
from ..schema.diagnosis import candidates, comparison_json, diagnosis_json, ladder_json
from ..schema.prediction import law_choice_json
from ..tasks.diagnose import fit_command
from ..tasks.fit import answer_of
from ..tasks.gate import warnings_of
from ..tasks.law_choice import LawChoice
from .asking import ObjectSetup
from .fitted import FitResult
from .hints import Hinting
from .record import axes_of

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from ..diagnosis.nouns import Comparison, Diagnosis, Ladder
    from .beside import AgainstResult


WIDTH = 110
"""Characters of a line at the prompt."""


def lines_of(*said: str) -> list[str]:
    """Sentences broken into lines for the prompt."""
    return [line for one in said for line in textwrap.wrap(one, WIDTH, break_long_words=False)]


class ShownAnswer(Hinting, ABC):
    """What all of these share. `details` is the noun itself."""

    details: Any
    law_choice: LawChoice | None = None

    @cached_property
    def warnings(self) -> tuple[Doubt, ...]:
        """What looks wrong in the record, or in the law on it; the grave stop naming unless they are assumed."""
        return ()

    @property
    def sentence(self) -> str:
        """The answer in a sentence."""
        from ..notebook.lines import line

        return line(self.details)

    def __repr__(self) -> str:
        law = [f"law: {self.law_choice.why}"] if self.law_choice else []
        return "\n".join(lines_of(*map(str, self.warnings), self.sentence, *law))

    def _repr_html_(self) -> str:
        from ..notebook.pages import banner, page

        return banner(self.warnings) + page(self.details)

    @abstractmethod
    def _content(self) -> dict[str, Any]: ...

    def to_json(self, path: str | Path | None = None) -> dict[str, Any]:
        """The answer of the command's `--json` as a dictionary, saved to `path` where one is given."""
        found = self._content() | law_choice_json(self.law_choice)
        found |= {"warnings": found.get("warnings", [])}
        if path is not None:
            write_json(check_target(path), found)
        return found


class RecordAnswer(ShownAnswer):
    """An answer about one record; the model that it ends with is `fit`: `params`, `predict`, `residuals` are its."""

    def __init__(self, details: Any, setup: ObjectSetup, choice: LawChoice | None) -> None:
        self.details, self.setup, self.law_choice = details, setup, choice

    @property
    @abstractmethod
    def _last(self) -> Fit: ...

    @cached_property
    def warnings(self) -> tuple[Doubt, ...]:
        """What looks wrong in the record, or in the law on it; the grave stop naming unless they are assumed."""
        return warnings_of(self._first)

    @cached_property
    def fit(self) -> FitResult:
        """The model that the answer ends with, fitted."""
        return FitResult(answer_of(self._last), self.setup, self.law_choice)

    @property
    def record(self) -> Any:
        """What the model was held against."""
        return self.fit.record

    @property
    def _source(self) -> str:
        return self.record.source or self.record.name

    @property
    def params(self) -> "pd.DataFrame":
        """The parameters of `fit`."""
        return self.fit.params

    @property
    def residuals(self) -> "pd.DataFrame":
        """The residuals of `fit`, with every coordinate."""
        return self.fit.residuals

    def predict(self, pressure: Any, contraction: Any = None, **more: Any) -> "pd.DataFrame":
        """As `FitResult.predict`, by `fit`."""
        return self.fit.predict(pressure, contraction, **more)

    def report(self, path: str | Path = "report.html") -> Path:
        """As `FitResult.report`, of the model that was asked about."""
        return FitResult(answer_of(self._first), self.setup, self.law_choice).report(path)

    @property
    def _first(self) -> Fit:
        return self._last

    @property
    def follows(self) -> "pd.DataFrame":
        """What the error follows, largest share first, in shares of the squared error that add to 1."""
        import pandas as pd

        rows = [(one.what, one.share, one.text) for one in self._follows]
        return pd.DataFrame(rows, columns=["what", "share", "text"]).set_index("what")

    @property
    def _follows(self) -> Any:
        return self.details.follows


class ComparisonResult(RecordAnswer):
    """Where a fitted model fails. `pam.compare` makes it."""

    details: "Comparison"

    @property
    def _last(self) -> Fit:
        return self.details.fit

    def _content(self) -> dict[str, Any]:
        return comparison_json(self._source, self.details, self.warnings)

    @property
    def map(self) -> "pd.DataFrame":
        """A row a cell of pressure, contraction and branch, with its error in N and its share."""
        from ..export.frames import cells

        return cells(self.details)

    def summary(self) -> str:
        """The sentence, and the error over each coordinate, as text."""
        import pandas as pd

        parts = [repr(self)]
        for key, bins in self.details.by.items():
            rows = [(one.label, one.n, one.mean, one.rms, one.share) for one in bins]
            frame = pd.DataFrame(rows, columns=[key, "n", "mean_N", "rms_N", "share"]).set_index(key)
            parts.append(frame.to_string(formatters={"share": percent}, float_format=three))
        return "\n\n".join(parts)

    def plot(self) -> "Axes":
        """The error over pressure and contraction, branch by branch."""
        from ..plot import failure_map

        return axes_of(failure_map.draw, self.details)


class DiagnosisResult(RecordAnswer):
    """Which effect is missing. `pam.diagnose` makes it: `verdict`, `selected`, `groups`, `candidates` and
    `next_experiment`."""

    details: "Diagnosis"

    @property
    def _last(self) -> Fit:
        return self.details.best

    @property
    def _first(self) -> Fit:
        return self.details.base

    def _content(self) -> dict[str, Any]:
        command = fit_command(self.details, self._source, self.setup)
        return diagnosis_json(self._source, self.details, self.warnings, command)

    @property
    def verdict(self) -> str:
        """`adequate`, `missing_effect` or `unknown_effect`."""
        return self.details.verdict

    @property
    def selected(self) -> tuple[str, ...]:
        """Effects that are missing, largest first; nothing when the model is adequate."""
        return self.details.selected

    @property
    def labels(self) -> tuple[str, ...]:
        """The same with their forms, as `pam.add` and `pam.fit` take them."""
        return self.details.labels

    def against(self, other: Any) -> "AgainstResult":
        """What differs between this record, A, and another, B.

        Args:
            other: a record, what `pam.read` takes, or the diagnosis of one by the same law.

        Raises:
            UsageError: for the diagnosis by another law.
            DataError, FitError: as `pam.diagnose`.
        """
        from ..diagnosis.against import against
        from ..tasks.diagnose import diagnose_record
        from .beside import AgainstResult
        from .record import read

        if not isinstance(other, DiagnosisResult):
            record = read(other)
            other = DiagnosisResult(diagnose_record(record, self.setup), self.setup, None)
        if other.details.base.model.labels != self.details.base.model.labels or (
            other.details.base.model.law.name != self.details.base.model.law.name
        ):
            raise UsageError("the two were diagnosed by different models; diagnose both by the same law and effects")
        return AgainstResult(against(self.details, other.details), (self._source, other._source))

    @property
    def groups(self) -> tuple[tuple[str, ...], ...]:
        """Effects that this record cannot tell apart, each group holding one selected name."""
        return self.details.groups

    @property
    def next_experiment(self) -> str:
        """What to test next, in words; empty where nothing is open."""
        return self.details.next_experiment.text if self.details.next_experiment else ""

    @property
    def candidates(self) -> "pd.DataFrame":
        """The effects that may be missing, the most probable first, with probability and the errors in N that they
        leave; none where nothing is missing."""
        import pandas as pd

        rows = [(s.effect, s.probability, s.rmse_after, s.heldout_rmse_after) for s in candidates(self.details)]
        names = ["effect", "probability", "rmse_after_N", "heldout_rmse_after_N"]
        return pd.DataFrame(rows, columns=names).astype(dict.fromkeys(names[1:], float)).set_index("effect")

    def summary(self) -> str:
        """The sentence, what the error follows, the candidates and the next experiment, as text."""
        parts = [repr(self), self.follows.loc[:, ["share"]].to_string(formatters={"share": percent})]
        if len(self.candidates):
            parts.append(self.candidates.to_string(formatters={"probability": probability}, float_format=three))
        if self.next_experiment:
            parts.append(f"next: {self.next_experiment}")
        return "\n\n".join(parts)

    def plot(self) -> "Axes":
        """The error that each candidate would leave."""
        from ..plot import candidates

        return axes_of(candidates.draw, self.details)


class LadderResult(RecordAnswer):
    """From the law down to the noise. `pam.ladder` makes it: `rungs`, `verdict`, `noise_floor` (N)."""

    details: "Ladder"

    @property
    def _last(self) -> Fit:
        return self.details.rungs[-1].fit

    @property
    def _first(self) -> Fit:
        return self.details.rungs[0].fit

    @property
    def _follows(self) -> Any:
        return self.details.first.follows

    def _content(self) -> dict[str, Any]:
        return ladder_json(self._source, self.details, self.warnings)

    @property
    def verdict(self) -> str:
        """Of the last rung: `adequate`, `missing_effect` or `unknown_effect`."""
        return self.details.verdict

    @property
    def noise_floor(self) -> float:
        """Noise in N."""
        return self.details.noise_floor

    @property
    def effects(self) -> tuple[str, ...]:
        """The effects of the last rung."""
        return self.details.rungs[-1].effects

    @property
    def groups(self) -> tuple[tuple[str, ...], ...]:
        """Each effect of the last rung that this record cannot tell from others, with these."""
        return self.details.groups

    @property
    def rungs(self) -> "pd.DataFrame":
        """A row a rung, the law alone first."""
        from ..export.frames import rungs

        return rungs(self.details)

    def __len__(self) -> int:
        return len(self.details.rungs)

    def summary(self) -> str:
        """The sentence and the rungs, as text."""
        shown = self.rungs.loc[:, ["effects", "parameters", "rmse_N", "heldout_rmse_N"]]
        nested = self.details.nested
        parts = [repr(self), shown.to_string(float_format=three), *([nested.text] if nested else [])]
        return "\n\n".join(parts)

    def plot(self) -> "Axes":
        """The error over the rungs, down to the noise."""
        from ..plot import ladder

        return axes_of(ladder.draw, self.details)
