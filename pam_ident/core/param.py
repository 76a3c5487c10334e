"""One parameter of a law or of an effect."""

import math
from dataclasses import dataclass, replace

from .errors import UsageError

SEEN = 2.0
"""Samples within which nothing is seen to relax: what does follows the speed there."""


@dataclass(frozen=True)
class Range:
    """Where nature ends, `low` to `high` in a parameter's unit, and the `source` that says so.

    A search may go further (bounds), so that what it finds there is known to be impossible. A range that goes with the
    size of the load cell is told for one of `cell_N`, and grows where a larger force was measured.
    """

    low: float
    high: float
    source: str
    cell_N: float = math.inf

    def where_measured(self, force_N: float) -> "Range":
        """The range in a record with a largest force."""
        larger = max(force_N / self.cell_N, 1.0)
        return self if larger == 1.0 else replace(self, low=larger * self.low, high=larger * self.high)


@dataclass(frozen=True)
class Param:
    """A named physical quantity with unit and bounds.

    `start` is where a fit begins and, for the size of an effect, `neutral` is the value at which
    the effect vanishes. `grid` lists values of a shape parameter from which fits are started,
    because the error has several minima in it. `scale` is a typical magnitude in `unit`, `range` where nature
    ends, None where no source says. Of one that is held both bounds are its value. `slowest`, of a relaxation time,
    is the longest that its form has, over this one, and this one over the shortest: none outlasts a record, for what
    relaxes more slowly is elastic there, nor is over between its samples; 0 of any other parameter.

    Raises UsageError when the bounds do not hold `start`.
    """

    name: str
    unit: str
    doc: str
    lower: float = -math.inf
    upper: float = math.inf
    start: float = 0.0
    neutral: float = 0.0
    scale: float = 1.0
    symbol: str = ""
    grid: tuple[float, ...] = ()
    range: Range | None = None
    slowest: float = 0.0

    def __post_init__(self) -> None:
        if not self.lower <= self.start <= self.upper:
            raise UsageError(
                f"parameter {self.name}: start {self.start} must lie in the bounds [{self.lower}, {self.upper}]"
            )

    def where_measured(self, force_N: float) -> "Param":
        """The parameter with its `range` in a record with a largest force."""
        return self if self.range is None else replace(self, range=self.range.where_measured(force_N))

    def within(self, seconds: float, interval: float) -> "Param":
        """The parameter with its bounds, start and grid in a record of that length and sampling interval, in s."""
        if not self.slowest:
            return self
        upper = min(max(seconds / self.slowest, self.lower), self.upper)
        lower = min(max(self.lower, SEEN * interval * self.slowest), upper)
        grid = tuple(dict.fromkeys(min(max(value, lower), upper) for value in self.grid))
        return replace(self, lower=lower, upper=upper, start=min(max(self.start, lower), upper), grid=grid)

    def clip(self, value: float) -> float:
        """`value` moved into the bounds."""
        return min(max(value, self.lower), self.upper)

    def typical(self, value: float) -> float:
        """The larger of `scale` and the magnitude of `value`; a `scale` left at 1 counts as 1e-3. Never zero."""
        return max(abs(value), self.scale if self.scale != 1.0 else 1e-3)

    @property
    def largest(self) -> float:
        """How large it may be in magnitude: where nature ends, or thirty times `scale` where no source says."""
        return 30.0 * self.scale if self.range is None else max(abs(self.range.low), abs(self.range.high))

    def inside(self, value: float) -> float:
        """`value` moved off the bounds by a hundredth of its typical size, or of the span where that is less.

        Solvers that keep bounds by a smooth transform cannot leave a bound on which they start.
        """
        margin = 0.01 * min(self.typical(value), self.upper - self.lower)
        return min(max(value, self.lower + margin), self.upper - margin)
