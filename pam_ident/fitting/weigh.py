"""How much each sample counts: all the same, by what the sensors' errors make of the force, or less when far off."""

from dataclasses import dataclass

import numpy as np

from ..core import Array, UsageError
from ..model import Model, Values
from ..records import Record
from .identifiability import slopes

TUNING = 1.345
"""Huber's constant: 95 % efficiency where the noise is normal (Huber 1964, Annals of Math. Statistics 35, 73–101)."""
LOSSES = ("linear", "huber")


@dataclass(frozen=True)
class Weighing:
    """Weights of a fit. `sensors` takes them from the standard deviations of the sensors, `loss` "huber" counts
    residuals beyond 1.345 robust standard deviations by their size and not by its square.

    Raises UsageError for an unknown loss.
    """

    sensors: bool = False
    loss: str = "linear"

    def __post_init__(self) -> None:
        if self.loss not in LOSSES:
            raise UsageError(f"loss {self.loss!r}: expected one of {', '.join(LOSSES)}")

    def check(self, record: Record) -> None:
        """Raises UsageError where weights are to come from sensors that are not described."""
        if self.sensors and record.specimen.sensors is None:
            raise UsageError(
                f"{record.source or record.name}: no table [sensors] in the specimen file to take weights from; give "
                "standard deviations as force_N, pressure_MPa, displacement_mm"
            )

    def weights(self, model: Model, record: Record, rows: Array, values: Values) -> Array | None:
        """Multipliers of the residuals, shape (n,), after a fit; None where all count the same."""
        if self == PLAIN:
            return None
        weights = 1.0 / _deviation(model, record, values) if self.sensors else np.ones(len(record))
        # Only their ratios matter; around 1 the sum of squares stays in N².
        weights /= np.median(weights[rows])
        if self.loss == "huber":
            residual = weights * (record.force - model.force(record.inputs, values))
            limit = TUNING * _scale(residual[rows])
            weights *= np.sqrt(np.minimum(1.0, limit / np.maximum(np.abs(residual), 1e-300)))
        return weights

    def inflation(self, weighted: Array) -> float:
        """Factor on the covariance for residuals (m,) beyond Huber's limit, whose pull no longer grows with them."""
        if self.loss != "huber":
            return 1.0
        size = np.abs(weighted)
        limit = TUNING * _scale(weighted)
        counted = np.mean(np.minimum(1.0, limit / np.maximum(size, 1e-300)))
        return float(counted / max(np.mean(size <= limit), 1e-3)) ** 2


def _scale(residual: Array) -> float:
    """Robust standard deviation by the median of absolute values, at least of rounding size."""
    return max(float(np.median(np.abs(residual))) / 0.6745, 1e-9)


def _deviation(model: Model, record: Record, values: Values) -> Array:
    """Standard deviation in N that the sensors' errors make of each residual, shape (n,), to first order."""
    sensors = record.specimen.sensors
    assert sensors is not None
    by_pressure, by_contraction = slopes(model, record.inputs, values)
    by_length = by_contraction / record.specimen.initial_length_mm
    return np.sqrt(
        sensors.force_N**2 + (by_pressure * sensors.pressure_MPa) ** 2 + (by_length * sensors.displacement_mm) ** 2
    )


PLAIN = Weighing()
