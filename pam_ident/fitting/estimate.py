"""One fitted parameter, and what nature says of it."""

import math
from dataclasses import dataclass

from ..core.param import Range
from .identifiability import PINNED, Identifiability


@dataclass(frozen=True)
class Estimate:
    """One fitted parameter. `stderr` and the 95 % interval `low` … `high` are NaN where the record does not
    determine it; `verdict` says why. `dof` are the degrees of freedom of its Student distribution, `range` is where
    nature ends, None where no source says."""

    name: str
    unit: str
    doc: str
    value: float
    stderr: float
    at_bound: bool
    identified: bool
    low: float = math.nan
    high: float = math.nan
    dof: float = math.nan
    verdict: Identifiability = PINNED
    range: Range | None = None

    @property
    def possible(self) -> bool | None:
        """Whether nature allows the value, or another in its interval; None where no source says, or no interval is
        known of a value that stands at no bound."""
        if self.range is None:
            return None
        low, high = (self.value, self.value) if self.at_bound else (self.low, self.high)
        if not (math.isfinite(low) or math.isfinite(high)):
            return None
        return not (low > self.range.high or high < self.range.low)


def impossible(e: Estimate) -> str:
    """In words, what nature says of an estimate out of its range."""
    assert e.range is not None
    unit = f" {e.unit}" if e.unit != "1" else ""
    span = f"{e.range.low:g} to {e.range.high:g}{unit}"
    return f"{e.name} = {e.value:.3g}{unit} is impossible: {span} by {e.range.source}"
