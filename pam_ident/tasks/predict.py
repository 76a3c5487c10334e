"""A saved fit asked elsewhere: its force with intervals, and how it does on another record."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from ..core import DataError, Inputs, Specimen, UsageError
from ..core.digits import millimetres, newtons, probability
from ..core.shown import Shown
from ..effects import load_effect_files
from ..fitting.length import at_limit, by_length, load_of
from ..fitting.prediction import LengthPrediction, Prediction, Predictor, ReadingSpread, Simpler
from ..leg.fit_file import Answer, fitted_branches, read_answer, read_specimen_of
from ..model import Model
from ..records import Record
from ..records.doubt import Doubt
from ..records.gate import doubts_of
from .states import States, read_states

if TYPE_CHECKING:
    import pandas as pd

Array = np.ndarray
HOLDS = 0.8
"""Share of the readings in their 95 % interval below which a fit does not hold: on conditions that it had not seen, of
muscles that had not changed, three quarters of 500 virtual records kept 93 % and more."""
AS_WELL = 1.05
"""How much larger the error of a simpler model may be for it to predict as well."""
MOST_LOST = 0.5
"""Share of the rows for which a fit has no stable length, from which nothing is said of its lengths."""
SIMPLER = {
    "mean_over_pressure": "the mean force over pressure",
    "contraction_over_pressure": "a line of the contraction over pressure",
    "polynomial": "a plain polynomial",
}
"""The simpler models in words."""


@dataclass(frozen=True)
class SavedFit:
    """What a file with a fitted model predicts, by branch; `simpler` is empty in those of a ladder, of `add` and of
    earlier versions. `undetermined` are parameters that the record fitted did not determine, `written` what the file
    holds of each branch."""

    path: str
    law: str
    effects: tuple[str, ...]
    specimen: Specimen
    branches: Mapping[str, Predictor]
    simpler: Mapping[str, Simpler]
    undetermined: tuple[str, ...] = ()
    written: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    @property
    def without_readings(self) -> bool:
        """Whether its file does not hold how far readings lie off."""
        return bool(self.written) and not any(isinstance(one.get("reading"), dict) for one in self.written.values())

    @property
    def doubts(self) -> tuple[Doubt, ...]:
        """What is doubtful of it on any record but its own."""
        found = []
        if self.undetermined:
            names = ", ".join(self.undetermined)
            text = f"the fit is not valid: its record did not determine {names}. Elsewhere it may say anything."
            found.append(Doubt("undetermined", text))
        if self.without_readings:
            text = "no interval of readings: the file does not hold how far they lie off; `fit --json` learns that"
            found.append(Doubt("no_readings", text))
        return tuple(found)

    @property
    def model(self) -> Model:
        """The law with its effects."""
        return next(iter(self.branches.values())).model


@dataclass(frozen=True)
class Predicted:
    """What a saved fit says of a file of states, a row each, and what is doubtful of it."""

    frame: "pd.DataFrame"
    warnings: tuple[str, ...]


@dataclass(frozen=True)
class ErrorsThere:
    """Errors on a record in N, or of its length in mm: root mean square, largest, coefficient of determination."""

    rmse: float
    max_error: float
    r2: float

    @classmethod
    def of(cls, error: Array, force: Array) -> "ErrorsThere":
        """From errors and what was measured, (n,) each in one unit."""
        spread = float(np.sum((force - force.mean()) ** 2))
        r2 = 1.0 - float(error @ error) / spread if spread > 0 else math.nan
        return cls(float(np.sqrt(np.mean(error**2))), float(np.max(np.abs(error))), r2)


@dataclass(frozen=True, repr=False)
class Validation(Shown):
    """A saved fit on another record. `coverage` is the share of readings that their 95 % interval holds, NaN where none
    is known; `simpler` the same errors of models that any muscle model must beat, fitted to what the fit was.

    Of an isotonic record `trial` and `simpler` are errors of the length in mm, `in_force` those of the force at the
    measured length in N; `left_out` are the rows at its mechanical limit, and `unstable` those for which the fit has no
    stable length, which are in none of them."""

    record: Record
    saved: SavedFit
    trial: ErrorsThere
    coverage: float
    outside: float
    simpler: Mapping[str, ErrorsThere]
    in_force: ErrorsThere | None = None
    left_out: int = 0
    unstable: int = 0

    def __repr__(self) -> str:
        told = {"the fit": self.trial, **{SIMPLER[name]: one for name, one in self.simpler.items()}}
        unit = millimetres if self.in_mm else newtons
        rows = [
            f"  {name}: {unit(one.rmse)} rms, {unit(one.max_error)} at most, R² {one.r2:.5g}"
            for name, one in told.items()
        ]
        return "\n".join([self.sentence, *rows])

    @property
    def rmse(self) -> float:
        """Root mean square error of the fit in N, or of the length in mm where it is `in_mm`."""
        return self.trial.rmse

    @property
    def in_mm(self) -> bool:
        """Whether the length was predicted, so that errors are in mm."""
        return self.in_force is not None

    @property
    def warnings(self) -> tuple[Doubt, ...]:
        """What looks wrong in the fit and in the record."""
        return (*self.saved.doubts, *doubts_of(self.record))

    @property
    def as_well(self) -> list[str]:
        """The simpler models that predict this record as well."""
        return [name for name, one in self.simpler.items() if one.rmse <= AS_WELL * self.trial.rmse]

    @property
    def sentence(self) -> str:
        """The answer in words."""
        share = probability(self.coverage)
        known = f" {share} of the readings lie in their 95 % interval."
        if self.saved.without_readings:  # of which the doubts tell
            known = ""
        elif math.isnan(self.coverage):
            known = " No interval of readings: the record fitted did not show how far they lie off."
        names = " and ".join(SIMPLER[name] for name in self.as_well)
        if self.coverage < HOLDS:
            known += " So it does not hold for this record."
        if self.unstable:
            known += f" It has no length for {self.unstable} of the samples."
        rest = f" No better than {names}." if names else " No simpler model does as well." if self.simpler else ""
        what, error = ("the length of ", millimetres) if self.in_mm else ("", newtons)
        return f"The fit predicts {what}{self.record.name} to {error(self.trial.rmse)} rms.{known}{rest}"


def read_fit(path: str | Path, effect_files: tuple[str, ...] = (), specimen: Specimen | None = None) -> SavedFit:
    """A file of `pam-ident fit --json` or `add --json`, or the last rung of `ladder --json`. Raises DataError for any
    other, UsageError for an unknown effect."""
    found = read_answer(path)
    effects, holders = found.stages[-1]
    model = found.model(effects, load_effect_files(effect_files))
    specimen = specimen or read_specimen_of(found)
    return SavedFit(
        str(path),
        model.law.name,
        tuple(model.labels),
        specimen,
        {name: _predictor(found, one, model, specimen) for name, one in holders.items()},
        {name: _simpler(one["simpler"]) for name, one in holders.items() if isinstance(one.get("simpler"), dict)},
        _undetermined(holders.values()),
        holders,
    )


def _undetermined(holders: Iterable[Mapping[str, Any]]) -> tuple[str, ...]:
    """Parameters that are written as not identified in any of some branches."""
    told = ((name, one) for holder in holders for name, one in holder["parameters"].items())
    return tuple(dict.fromkeys(name for name, one in told if one.get("identified") is False))


def _predictor(found: Answer, holder: Mapping[str, Any], model: Model, specimen: Specimen) -> Predictor:
    values, spread = found.fitted(holder)
    missing = [name for name in model.names if name not in values]
    if missing:
        raise DataError(f"{found.path}: lacks {', '.join(missing)}; fit again with --json")
    free, matrix = (spread.names, spread.matrix) if spread else ((), None)
    dofs = [one.get("freedom") for name, one in holder["parameters"].items() if name in free]
    dof = min((float(d) for d in dofs if isinstance(d, int | float)), default=math.nan)
    return Predictor(model, specimen, values, free, matrix, dof, _reading(holder.get("reading"), found.seen))


def _reading(table: Any, seen: Mapping[str, list[float]]) -> ReadingSpread | None:
    """How far readings lie off; of a ladder or of `add`, which leave nothing out to learn it, only what was `seen`."""
    if not isinstance(table, dict):
        if not {"pressure_MPa", "contraction"} <= set(seen):
            return None
        low, high = seen["contraction"]
        nan = math.nan
        return ReadingSpread(nan, nan, nan, nan, tuple(seen["pressure_MPa"]), (), (low, high))
    same, between, beyond, speed, noise = (
        math.nan if table.get(f"{key}_N") is None else float(table[f"{key}_N"]) for key in READING
    )
    low, high = table["contraction"]
    pressures, speeds = tuple(table["pressures_MPa"]), tuple(table["speeds_mm_s"])
    return ReadingSpread(same, between, beyond, speed, pressures, speeds, (low, high), noise)


READING = ("same", "between", "beyond", "speed", "noise")


def _simpler(table: Mapping[str, Any]) -> Simpler:
    lines = (table.get(key) for key in ("mean_over_pressure", "contraction_over_pressure"))
    force, contraction = (None if line is None else (float(line[0]), float(line[1])) for line in lines)
    return Simpler(force, table.get("polynomial"), contraction)


def predict(branches: Mapping[str, Predictor], inputs: Inputs) -> Prediction:
    """Force and intervals at `inputs`, each sample by the fit of its branch.

    Raises UsageError where a branch was not fitted, or is not known of a sample, DataError where an effect needs what
    the inputs do not hold.
    """
    return _by_branch(branches, inputs, lambda one: one.at(inputs))


def predict_length(branches: Mapping[str, Predictor], inputs: Inputs, load: Array) -> LengthPrediction:
    """The contraction that carries `load` (n,) in N, and intervals, at the pressures of `inputs`, each sample by the
    fit of its branch. Raises as `predict` does, and DataError for an effect that remembers the way."""
    model = next(iter(branches.values())).model
    memory = [term.label for term in model.terms if term.form.remembers]
    if memory:
        raise DataError(f"the fit's {memory[0]} remembers the way, which is what is to be predicted; fit without it")
    return _by_branch(branches, inputs, lambda one: one.carrying(inputs, load))


Asked = TypeVar("Asked", Prediction, LengthPrediction)


def _by_branch(branches: Mapping[str, Predictor], inputs: Inputs, ask: Callable[[Predictor], Asked]) -> Asked:
    _check_needs(next(iter(branches.values())).model, inputs)
    if len(branches) == 1:
        return ask(next(iter(branches.values())))
    both = fitted_branches(branches, "the fit")
    if not np.all(inputs.direction):
        raise UsageError("this fit has its own parameters on each branch; give branch ('contraction' or 'extension')")
    up, down = map(ask, both)
    found = (np.where(inputs.direction > 0, getattr(up, k), getattr(down, k)) for k in type(up).__dataclass_fields__)
    return type(up)(*found)


def _check_needs(model: Model, inputs: Inputs) -> None:
    for term in model.terms:
        lacking = term.effect.missing(inputs)
        if lacking:
            words = {"motion": "time_s", "time": "time_s", "temperature": "temperature_C"}
            give = ", ".join(dict.fromkeys(words.get(need, need) for need in lacking))
            raise DataError(f"{term.effect.name} needs {', '.join(lacking)}; give {give}, too")


def prediction_frame(inputs: Inputs, found: Prediction) -> "pd.DataFrame":
    """A row a sample: what was asked, force, its standard error, both 95 % intervals in N, whether the record that was
    fitted did not reach there, and whether a reading's interval is wide because the model leaves more than noise."""
    told = {"contraction": inputs.contraction, "force_N": found.force}
    return _frame(inputs, told, found.force, found, "N").assign(unexplained=found.unexplained)


def length_frame(inputs: Inputs, load: Array, found: LengthPrediction) -> "pd.DataFrame":
    """The same of a length under `load` (n,) in N: what was asked, contraction, displacement and intervals in mm."""
    mm = found.contraction * inputs.specimen.initial_length_mm
    told = {"force_N": load, "contraction": found.contraction, "displacement_mm": mm}
    return _frame(inputs, told, mm, found, "mm")


def _frame(
    inputs: Inputs, told: Mapping[str, Array], middle: Array, found: Prediction | LengthPrediction, unit: str
) -> "pd.DataFrame":
    """Time, pressure and what is `told`, then the intervals about `middle` (n,) in its unit."""
    import pandas as pd

    columns = {
        "time_s": inputs.time,
        "pressure_MPa": inputs.pressure,
        **told,
        f"stderr_{unit}": found.stderr,
        f"mean_low_{unit}": middle - found.half_mean,
        f"mean_high_{unit}": middle + found.half_mean,
        f"reading_low_{unit}": middle - found.half_reading,
        f"reading_high_{unit}": middle + found.half_reading,
        "outside": found.outside,
    }
    return pd.DataFrame({name: column for name, column in columns.items() if column is not None})


def predict_at(saved: SavedFit, at: str | Path) -> Predicted:
    """The force of a saved fit at each row of a file, as `asked` has it. Raises DataError, UsageError."""
    states = read_states(at, saved.specimen)
    frame = asked(saved.branches, states)
    warnings = [*states.warnings, *(one.text for one in saved.doubts)]
    if frame["outside"].to_numpy().any():
        warnings.append(_beyond(saved, frame))
    lost = np.flatnonzero(np.isnan(frame["contraction"].to_numpy()))
    if len(lost):
        load, pressure = (float(frame[key].to_numpy()[lost[0]]) for key in ("force_N", "pressure_MPa"))
        rows = "1 row has" if len(lost) == 1 else f"{len(lost)} rows have"
        state = f"{newtons(load)} at {pressure:.3g} MPa"
        warnings.append(f"{rows} no length: the fit carries no such load there (the first is {state})")
    if "unexplained" in frame and frame["unexplained"].to_numpy().any():
        lack = "the intervals of readings are wide: the fit leaves more than noise; `diagnose` says what it lacks"
        warnings.append(lack)
    lengths = states.load is not None and not saved.without_readings
    if lengths and not frame["reading_low_mm"].notna().to_numpy().any():
        warnings.append("no interval of readings: how far lengths lie off was not learned from the record fitted")
    return Predicted(frame, tuple(warnings))


def asked(branches: Mapping[str, Predictor], states: States) -> "pd.DataFrame":
    """Force at some states, or where they give a force and no length, the length at which the muscle carries that.
    Raises DataError, UsageError."""
    inputs, load = states.inputs, states.load
    if load is None:
        return prediction_frame(inputs, predict(branches, inputs))
    return length_frame(inputs, load, predict_length(branches, inputs, load))


def _beyond(saved: SavedFit, frame: "pd.DataFrame") -> str:
    """How many rows lie outside what was fitted, and how far."""
    spreads = [one.spread for one in saved.branches.values() if one.spread is not None]
    spans = {
        "pressure_MPa": ("{} MPa", [p for one in spreads for p in one.pressures]),
        "contraction": ("a contraction of {}", [e for one in spreads for e in one.contraction]),
    }
    far = []
    for column, (words, seen) in spans.items():
        low, high = f"{min(seen):.3g}", f"{max(seen):.3g}"
        asked = frame[column].to_numpy(float)
        ends = {float(np.nanmin(asked)), float(np.nanmax(asked))} if np.isfinite(asked).any() else set()
        beyond = [f"{end:.3g}" for end in sorted(ends) if end < min(seen) or end > max(seen)]
        far += [f"{words.format(end)}, where {low} to {high} was fitted" for end in beyond if end not in (low, high)]
    count = int(frame["outside"].to_numpy().sum())
    furthest = f". Furthest: {'; '.join(far)}" if far else ""
    rows = "1 row lies" if count == 1 else f"{count} rows lie"
    return f"{rows} outside what was fitted; intervals there were never tried{furthest}"


def validate_fit(saved: SavedFit, record: Record) -> Validation:
    """A saved fit on another record: its force, or where the length answered, its length. Raises as `predict` does."""
    found = predict(saved.branches, record.inputs)
    error = record.force - found.force
    plain = saved.simpler.get("together")
    if by_length(record):
        return _validate_length(saved, record, error, plain)
    known = np.isfinite(found.half_reading)
    inside = np.abs(error) <= found.half_reading
    forces = plain.forces(record.inputs) if plain else {}
    return Validation(
        record,
        saved,
        ErrorsThere.of(error, record.force),
        float(inside[known].mean()) if known.any() else math.nan,
        float(found.outside.mean()),
        {name: ErrorsThere.of(record.force - force, record.force) for name, force in forces.items()},
    )


def _validate_length(saved: SavedFit, record: Record, error: Array, plain: Simpler | None) -> Validation:
    """`error` (n,) in N is that of the force at the measured length. Raises DataError where no row is left, or the fit
    has no stable length for one."""
    rows = np.flatnonzero(~at_limit(record))
    if not len(rows):
        raise DataError(f"{record.source or record.name}: the length never moves with the pressure; vary it further")
    inputs, load = record.inputs.take(rows), load_of(record)[rows]
    found = predict_length(saved.branches, inputs, load)
    lost = np.isnan(found.contraction)
    if lost.mean() > MOST_LOST:
        row = int(rows[lost.argmax()]) + 1
        state = f"{load[lost][0]:.3g} N at {inputs.pressure[lost][0]:.3g} MPa"
        raise DataError(
            f"{record.source or record.name}: sample {row} ({state}), and {int(lost.sum()) - 1} more: the fit of "
            f"{saved.path or saved.law} has no stable length there. Leave them out with --where, or fit such states"
        )
    rows, load = rows[~lost], load[~lost]
    inputs = record.inputs.take(rows)
    found = predict_length(saved.branches, inputs, load)
    x, length = inputs.displacement_mm, record.specimen.initial_length_mm
    off = x - length * found.contraction
    known = np.isfinite(found.half_reading)
    beside = plain.contractions(inputs, load) if plain else {}
    return Validation(
        record,
        saved,
        ErrorsThere.of(off, x),
        float((np.abs(off) <= found.half_reading)[known].mean()) if known.any() else math.nan,
        float(found.outside.mean()),
        {name: ErrorsThere.of(x - length * e, x) for name, e in beside.items()},
        ErrorsThere.of(error[rows], record.force[rows]),
        len(record) - len(rows) - int(lost.sum()),
        int(lost.sum()),
    )
