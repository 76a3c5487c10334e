"""What a fitted model can be asked elsewhere, and a fit that is read back from its file."""

import warnings
from abc import ABC, abstractmethod
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..core import DataError, Specimen, UsageError
from ..core.digits import millimetres, newtons
from ..core.files import check_target, write_json
from ..fitting.prediction import Predictor
from ..leg.fit_file import what_is_written
from ..records import Record
from ..tasks.export import export_fit
from ..tasks.predict import SavedFit, asked, read_fit
from ..tasks.states import States, inputs_of, read_states
from ..tasks.validate import Validation, validate_fit
from .hints import Hinting
from .record import read
from .working import worked

if TYPE_CHECKING:
    import pandas as pd

COLUMNS = ["value", "stderr", "low", "high", "unit", "verdict", "meaning"]


def parameter_table(rows: Mapping[tuple[str, str], tuple[Any, ...]], branches: int) -> "pd.DataFrame":
    """A row a parameter by branch and name, COLUMNS each; by name alone where there is one branch."""
    import pandas as pd

    frame = pd.DataFrame(list(rows.values()), columns=COLUMNS)
    if not rows:
        return frame
    frame.index = pd.MultiIndex.from_tuples(list(rows), names=["branch", "parameter"])
    return frame.droplevel("branch") if branches == 1 else frame


class Predicting(Hinting, ABC):
    """What every fitted model can be asked: its force elsewhere, and how it does on another record."""

    specimen: Specimen

    @property
    @abstractmethod
    def predictors(self) -> Mapping[str, Predictor]:
        """The fits by branch, to be asked elsewhere."""

    @property
    @abstractmethod
    def problems(self) -> list[str]:
        """Why the fit is not to be trusted elsewhere; empty when it is."""

    def predict(self, pressure: Any = None, contraction: Any = None, **more: Any) -> "pd.DataFrame":
        """Force with 95 % intervals of its mean (`mean_low_N`, `mean_high_N`) and of a new reading (`reading_…`).

        Args:
            pressure: gauge pressure in MPa, a number or an array; or a Record, a table, or a file, whose pressure and
                contraction are taken. Where a table or file holds a force and no length, the length is predicted at
                which the muscle carries that.
            contraction: ratio of the length at rest, a number or an array.
            more: where effects need them `time_s`, `temperature_C`, `cycle`, `branch` ('contraction' or 'extension').
                Without a pressure the columns of a table, such as `pressure_bar=3.0, length_mm=180.0`.

        A reading's interval holds the noise and what the model leaves unexplained; NaN where nothing is known of that.
        `outside` marks states that the record did not reach, of which a warning tells, as of a fit with `problems`;
        `unexplained` intervals that are wide because the model leaves more than noise: something is missing in it.
        Raises UsageError, DataError.
        """
        if pressure is None and more:
            more |= {} if contraction is None else {"contraction": contraction}
            pressure, contraction, more = _columns(more), None, {}
        if contraction is not None:
            states = States(inputs_of(self.specimen, pressure, contraction, **more))
        elif more:
            raise UsageError("predict: give pressure and contraction, or one record, table or file")
        elif isinstance(pressure, Record):
            states = States(pressure.inputs)
        elif isinstance(pressure, str | Path) or (pressure is not None and hasattr(pressure, "columns")):
            states = read_states(pressure, self.specimen)
        elif isinstance(pressure, Mapping):
            import pandas as pd

            states = read_states(pd.DataFrame(dict(pressure)), self.specimen)
        else:
            raise UsageError("predict: give contraction beside pressure, or one record, table or file")
        found = asked(self.predictors, states)
        outside = int(found["outside"].to_numpy().sum())
        if outside and not isinstance(pressure, Record):
            warnings.warn(f"{outside} of {len(found)} states lie outside what was fitted", stacklevel=2)
        for problem in self.problems:
            warnings.warn(problem, stacklevel=2)
        return found


def _columns(given: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """Columns of a table from numbers and arrays."""
    try:
        columns = np.broadcast_arrays(*(np.atleast_1d(values) for values in given.values()))
    except ValueError:
        sizes = ", ".join(f"{name} has {np.size(values)}" for name, values in given.items())
        raise UsageError(f"predict: expected numbers, or columns of one length; {sizes}") from None
    return dict(zip(given, columns, strict=True))


class SavedResult(Predicting):
    """A fit, or the last step of a ladder or of `add`, that was read back from its file: `params`, `predict`,
    `validate`, `summary`, and what else the file holds by its keys; the record is not in it."""

    def __init__(self, saved: SavedFit, content: dict[str, Any]) -> None:
        self.details, self.content = saved, content
        self.specimen, self.model = saved.specimen, saved.model
        self.law, self.effects = saved.law, saved.effects

    @property
    def predictors(self) -> Mapping[str, Predictor]:
        """The fits by branch, to be asked elsewhere."""
        return self.details.branches

    @property
    def problems(self) -> list[str]:
        """What is doubtful of it on any record but its own."""
        return [one.text for one in self.details.doubts]

    @property
    def params(self) -> "pd.DataFrame":
        """A row a parameter, as `FitResult.params`; by branch, too, where there are several."""
        docs = {p.name: p.doc for p in self.model.params}
        rows = {
            (branch, name): (
                one["value"], one["stderr"], *one["interval"], one["unit"], one["verdict"], docs.get(name, ""),
            )
            for branch, holder in self.details.written.items()
            for name, one in holder["parameters"].items()
        }  # fmt: skip
        return parameter_table(rows, len(self.predictors))

    def summary(self) -> str:
        """The equation and the parameters, as text."""
        return "\n".join([repr(self), str(self.model), self.params.iloc[:, :5].to_string()])

    def __repr__(self) -> str:
        names = " + ".join([self.law, *self.effects])
        errors = ", ".join(
            millimetres(one["rmse_mm"]) if "rmse_mm" in one else newtons(one["rmse_N"])
            for one in self.details.written.values()
        )
        return f"{names} fitted to {self.content['record']}: {errors} rms (from {self.details.path})"

    def __getitem__(self, key: str) -> Any:
        return self.content[key]

    @worked
    def validate(self, record: Any, specimen: Any = None) -> Validation:
        """How the fit does on another record. Raises DataError."""
        return validate_fit(self.details, read(record, specimen))

    @worked
    def export(self, to: str, out: str | Path) -> tuple[Path, ...]:
        """As `FitResult.export`."""
        return export_fit(self.details.path, to, str(out)).paths

    def to_json(self, path: str | Path | None = None) -> dict[str, Any]:
        """What the file holds, saved to `path` where one is given."""
        if path is not None:
            write_json(check_target(path), self.content)
        return self.content


def load(path: str | Path) -> Any:
    """What `to_json`, or a command's `--json`, wrote: a fit, a ladder or `add` comes back to be asked, any other answer
    as a dictionary.

    Args:
        path: the file.

    Raises:
        DataError: for a file that is no answer of this program.

    Example:
        >>> import pam_ident as pam
        >>> pam.fit("dmsp20_300", "martens_boblan").to_json("fit.json")["schema"]
        'pam-ident/fit/1'
        >>> print(round(pam.load("fit.json").predict(0.25, 0.1)["force_N"].item()), "N")
        135 N
    """
    expected = "expected what to_json or --json wrote"
    content, found = what_is_written(Path(path), expected)
    if not found.startswith("pam-ident/"):
        raise DataError(f"{path}: is no answer of pam-ident; {expected}")
    model = found.split("/")[1] in ("fit", "ladder", "add")
    return SavedResult(read_fit(path), content) if model else content
