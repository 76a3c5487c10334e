"""A fit as one meets it at the prompt."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..core import UsageError
from ..core.digits import known_to, number
from ..core.files import check_target, write_json
from ..fitting import Fit
from ..fitting.prediction import Predictor
from ..model import Model
from ..records.doubt import Doubt
from ..schema.fit import fit_json
from ..schema.prediction import law_choice_json
from ..tasks.export import export_answer
from ..tasks.fit import FitAnswer
from ..tasks.law_choice import LawChoice
from ..tasks.predict import SavedFit
from ..tasks.validate import Validation, validate_fit
from .asking import ObjectSetup, codes
from .record import ShownRecord, axes_of, read
from .saved import Predicting, parameter_table
from .working import worked

if TYPE_CHECKING:
    import lmfit
    import pandas as pd
    from matplotlib.axes import Axes


def told(params: "pd.DataFrame") -> str:
    """Parameters as text, each value with the digits that its standard error leaves."""
    columns = {"value": "value", "stderr": "std. error", "low": "95 % from", "high": "to", "unit": "unit"}
    value, error = list(map(known_to, params["value"], params["stderr"])), [number(e, 2) for e in params["stderr"]]
    ends = {end: list(map(known_to, params[end], params["stderr"])) for end in ("low", "high")}
    table = params.assign(value=value, stderr=error, **ends).loc[:, list(columns)].rename(columns=columns)
    return table.to_string()


class FitResult(Predicting):
    """A fit: its parameters, its errors, and what it predicts. `pam.fit` makes it.

    `law`, `effects` and `law_choice` say what was fitted and why; `rmse`, `max_error` (N), `r2` and `n` how well, over
    all branches; `valid`, `problems` and `warnings` whether to trust it; `details` holds the fits by branch.
    """

    def __init__(self, answer: FitAnswer, setup: ObjectSetup, choice: LawChoice | None = None) -> None:
        self.details, self.setup, self.law_choice = answer, setup, choice
        first = next(iter(answer.fits.values()))
        self.model: Model = first.model
        self.record = ShownRecord.of(first.record)
        self.specimen = self.record.specimen
        self.law, self.effects = self.model.law.name, tuple(self.model.labels)

    @property
    def predictors(self) -> Mapping[str, Predictor]:
        """The fits by branch, to be asked elsewhere."""
        return self.details.predictors

    @property
    def fits(self) -> dict[str, Fit]:
        """The fits by branch: together, contraction or extension."""
        return dict(self.details.fits)

    @property
    def values(self) -> dict[str, float]:
        """Parameter values by name; behind the branch and a colon where there are several."""
        several = len(self.fits) > 1
        return {
            f"{branch}:{name}" if several else name: value
            for branch, one in self.fits.items()
            for name, value in one.values.items()
        }

    @property
    def rmse(self) -> float:
        """Root mean square of the residual in N."""
        n = sum(one.n for one in self.fits.values())
        return math.sqrt(sum(one.n * one.rmse**2 for one in self.fits.values()) / n)

    @property
    def max_error(self) -> float:
        """Largest absolute residual in N."""
        return max(one.max_error for one in self.fits.values())

    @property
    def r2(self) -> float:
        """Coefficient of determination; of several branches the least."""
        return min(one.r2 for one in self.fits.values())

    @property
    def n(self) -> int:
        """How many samples were fitted."""
        return sum(one.n for one in self.fits.values())

    @property
    def valid(self) -> bool:
        """Converged, and every parameter identified."""
        return not self.problems

    @property
    def problems(self) -> list[str]:
        """Why the fit is not valid; empty when it is."""
        return self.details.problems

    @property
    def warnings(self) -> tuple[Doubt, ...]:
        """What looks wrong in the record, in the law on it, or in the fit."""
        return self.details.warnings

    @property
    def params(self) -> "pd.DataFrame":
        """A row a parameter: value, stderr, 95 % interval (low, high), unit, verdict, meaning; by branch, too, where
        there are several."""
        rows = {
            (branch, e.name): (e.value, e.stderr, e.low, e.high, e.unit, e.verdict.kind, e.doc)
            for branch, one in self.fits.items()
            for e in one.estimates
        }
        return parameter_table(rows, len(self.fits))

    @property
    def residuals(self) -> "pd.DataFrame":
        """A row a sample: every coordinate, force, the model's force, what is left, whether it was fitted."""
        from ..export.frames import residuals

        found = None
        for one in self.fits.values():
            mine = residuals(one)
            if found is None:
                found = mine
            else:
                found.loc[one.rows, ["model_N", "residual_N", "fitted"]] = mine.loc[one.rows]
        assert found is not None
        return found

    def summary(self) -> str:
        """The equation, how well it fits, the parameters, and which of them stand at a bound, as text."""
        head, stuck = self._head(), dict.fromkeys(line for one in self.fits.values() for line in one.at_bounds)
        table = [told(self.params)] if self.model.params else []
        return "\n".join([*head[:1], str(self.model), *head[1:], *table, *stuck])

    def _head(self) -> list[str]:
        from ..notebook.lines import fit as line

        lines = []
        for branch, one in self.fits.items():
            lines.append(line(one) if len(self.fits) == 1 else f"{branch}: {line(one)}")
        if self.law_choice is not None:
            lines.append(f"law: {self.law_choice.why}")
        return [*lines, *map(str, self.warnings)]

    def __repr__(self) -> str:
        return "\n".join(self._head())

    def _repr_html_(self) -> str:
        from ..notebook.pages import banner, page

        return banner(self.warnings) + "".join(page(one) for one in self.fits.values())

    def plot(self) -> "Axes":
        """Measured and modelled force over contraction; the Axes' figure has the error below. Of several branches the
        last is given back."""
        from ..plot import measured_against_model

        return [axes_of(measured_against_model.draw, one) for one in self.fits.values()][-1]

    def to_json(self, path: str | Path | None = None) -> dict[str, Any]:
        """The answer of `pam-ident fit --json` as a dictionary, saved to `path` where one is given."""
        found = fit_json(self.record.source or self.record.name, self.law, self.details) | law_choice_json(
            self.law_choice
        )
        if path is not None:
            check_target(path)
            write_json(path, found)
        return found

    @worked
    def export(self, to: str, out: str | Path) -> tuple[Path, ...]:
        """Write the model for another program, `to` c, fmu, fmu3, matlab, python, mujoco or json; the files written.

        Raises UsageError for what cannot be exported, and another ending of `out` than such files have.
        """
        return export_answer(self.details, to, str(out), self.record.source or self.record.name).paths

    def to_frame(self) -> "pd.DataFrame":
        """The parameters, as `params`."""
        return self.params

    def to_xarray(self) -> Any:
        """The residuals as a Dataset over `sample`, units as attributes. Raises UsageError where xarray is missing."""
        from .labelled import dataset

        return dataset(self.residuals, {"law": self.law, "effects": ", ".join(self.effects)})

    def to_lmfit(self) -> "lmfit.Parameters":
        """The parameters for lmfit, with values, errors, bounds. Raises UsageError for a fit of several branches."""
        from ..core.lmfit_names import to_lmfit_name

        if len(self.fits) > 1:
            raise UsageError("to_lmfit: the fit has several branches; take one by branch=")
        (one,) = self.fits.values()
        _, found = one.model.to_lmfit(one.record.inputs)
        for e in one.estimates:
            mine = found[to_lmfit_name(e.name)]
            mine.set(value=e.value, vary=e.name in one.free)
            mine.stderr = e.stderr if math.isfinite(e.stderr) else None
        return found

    @worked
    def report(self, path: str | Path = "report.html", *, assume: str | Iterable[str] = ()) -> Path:
        """Write the whole answer about this record and model as HTML, Markdown or PDF, by the ending of `path`.

        `assume` are codes of grave warnings that are meant so. Raises DataError for a record that looks wrong.
        """
        from ..tasks.report import report_record

        setup = replace(self.setup, assume=(*self.setup.assume, *codes(assume)))
        report_record(self.record, setup, str(path))
        return Path(path)

    @worked
    def validate(self, record: Any, specimen: Any = None) -> Validation:
        """How the fit does on another record: errors, coverage of its intervals, simpler models beside it."""
        simpler = {branch: one.simpler for branch, one in self.details.elsewhere.items()}
        saved = SavedFit("", self.law, self.effects, self.specimen, self.predictors, simpler)
        return validate_fit(saved, read(record, specimen))
