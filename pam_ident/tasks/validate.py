"""A saved fit held against another record."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from ..core import DataError
from ..core.digits import millimetres, newtons, probability
from ..core.shown import Shown
from ..fitting.length import at_limit, by_length, load_of
from ..fitting.prediction import Simpler
from ..records import Record
from ..records.doubt import Doubt
from ..records.gate import doubts_of
from .predict import SavedFit, predict, predict_length

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
        """What looks wrong in the fit and in the record, and of the one beside the other."""
        return (*self.saved.doubts, *self._beside(), *doubts_of(self.record))

    def _beside(self) -> Iterator[Doubt]:
        written = list(self.saved.written.values())
        key = "rmse_mm" if self.in_mm else "rmse_N"
        # A ladder's step, of one branch, does not say how many rows it is of.
        n, square = (sum(one.get("n", 1) * (one.get(key) or 0.0) ** k for one in written) for k in (0, 2))
        if n and math.isclose(math.sqrt(square / n), self.rmse, rel_tol=1e-6):
            text = "the fit was made to this very record, or to its like to the last digit: this is no test of it"
            yield Doubt("own_record", text)
        fitted, here = self.saved.specimen, self.record.specimen
        if fitted.geometry != here.geometry:
            text = f"another muscle: the fit is of {fitted.name} ({fitted.geometry}), the record of {here.name} "
            yield Doubt("other_specimen", f"{text}({here.geometry})")

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
