"""A saved fit asked elsewhere: its force, or the length under a load, with intervals."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from ..core import DataError, Inputs, Specimen, UsageError
from ..core.digits import newtons
from ..effects import load_effect_files
from ..fitting.prediction import LengthPrediction, Prediction, Predictor, ReadingSpread, Simpler
from ..leg.fit_file import Answer, fitted_branches, read_answer, read_specimen_of
from ..model import Model
from ..records.doubt import Doubt
from .states import States, read_states

if TYPE_CHECKING:
    import pandas as pd

Array = np.ndarray


@dataclass(frozen=True)
class SavedFit:
    """What a file with a fitted model predicts, by branch; `simpler` is empty in those of earlier versions.

    `undetermined` are parameters that the record fitted did not determine, `written` what the file holds of each
    branch."""

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
            text = "no interval of readings: the file, of an earlier version, does not say how far they lie off"
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
    """How far readings lie off; of an earlier version only what was `seen`."""
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
        raise DataError(
            f"a load gives no length by this fit: its {memory[0]} depends on the way that the length went before; take "
            "a fit without it"
        )
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
            words = {
                "motion": "time_s",
                "time": "time_s",
                "temperature": "temperature_C",
                "branch": "branch ('contraction' or 'extension')",
            }
            give = ", ".join(dict.fromkeys(words.get(need, need) for need in lacking))
            raise DataError(f"{term.effect.name} needs {', '.join(lacking)} at each state: add {give}")
        if term.form.remembers and inputs.time is not None and len(inputs) == 1:
            raise DataError(f"{term.label} depends on the way that the muscle went before: give the states of the way")


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
    return f"{rows} outside what was fitted, where no measurement has checked the intervals{furthest}"
