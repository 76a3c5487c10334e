"""What the diagnosis answers with. All frozen; none draws or prints itself."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from ..fitting import Fit
from ..fitting.carried import length_rmse
from ..fitting.prediction import Elsewhere
from .strokes import Strokes

Array = np.ndarray


@dataclass(frozen=True)
class Bin:
    """Error over an interval [low, high] of one coordinate: mean and rms of n samples in N, share of the squares."""

    label: str
    low: float
    high: float
    n: int
    mean: float
    rms: float
    share: float


@dataclass(frozen=True)
class Region:
    """One cell of pressure × contraction × branch, with its share of the squared error."""

    pressure_MPa: float
    contraction: tuple[float, float]
    branch: str
    n: int
    mean: float
    rms: float
    share: float


@dataclass(frozen=True)
class Follows:
    """A share of the squared error: `what` it follows in a word of the contract, and `text` in plain words."""

    what: str
    share: float
    text: str


@dataclass(frozen=True)
class Comparison:
    """Where a fitted model fails.

    `mean`, `rms` (N) and `share` have shape (branches, pressures, contraction cells), NaN where there is no
    sample; `edges` (cells + 1,) are contraction ratios. `by` holds the error over each coordinate alone.
    `odd`, `even` and `rest` are shares of the squared error: opposite on the two branches (hysteresis), the
    same on both, and neither; odd and even are None where a record has no branches. `follows` are shares of it, too, by
    what it follows, and add to 1.
    """

    fit: Fit
    branches: tuple[str, ...]
    pressures: Array
    edges: Array
    mean: Array
    rms: Array
    share: Array
    by: dict[str, tuple[Bin, ...]]
    odd: float | None
    even: float | None
    rest: float
    worst: tuple[Region, ...]
    follows: tuple[Follows, ...]
    sentence: str


@dataclass(frozen=True)
class Candidate:
    """An effect that may be missing: `label` names the form that fits best, `probability` that it belongs to the
    answer, or that one does which the record cannot tell from it.

    `status` is candidate, absorbed_by_law or not_excited. Errors in N, None where they were not computed.
    """

    effect: str
    label: str
    status: str
    probability: float
    rmse_after: float | None = None
    heldout_rmse_after: float | None = None
    why: str = ""


@dataclass(frozen=True)
class Pattern:
    """What is left that no known effect explains: kind periodic, local, step, trend or other, along `coordinate`.

    `value` is the period, the place or the moment in `unit`; `share` of the squared error that was to be explained.
    """

    kind: str
    coordinate: str
    value: float | None
    unit: str
    share: float
    text: str


@dataclass(frozen=True)
class Separation:
    """How far a run would set an effect apart from a rival, or from nothing (None), in standard errors of the noise;
    and how far is `needed`, because no form is exactly right."""

    effect: str
    rival: str | None
    standard_errors: float
    needed: float

    @property
    def share(self) -> float:
        """What the run does of what is needed, in squares: 1 where it suffices."""
        return min(self.standard_errors / self.needed, 1.0) ** 2


@dataclass(frozen=True)
class Experiment:
    """The next test on the rig: what to vary, in words, and where it is a run of strokes, what that is predicted to
    show, its rig time in minutes and its protocol."""

    vary: tuple[str, ...]
    text: str
    predicted: tuple[Separation, ...] = ()
    minutes: float | None = None
    protocol: Strokes | None = None


@dataclass(frozen=True)
class Diagnosis:
    """Which effect a law lacks on a record.

    `base` is the model as given, `best` with the `selected` effects (names, largest first) added. `labels` are
    the same with their forms. `follows` says what the error of `base` follows, whatever it is called, and
    `details["followed"]` how much of it in N, shape (n,), unless the record was too long to look at whole. Floors and
    errors in N, those on held-out data `nested` where everything was chosen anew without it, else `refit`. Where a load
    was held, `rmse_mm` and `rmse_after_mm` are the errors of the length by `base` and `best` fitted to it.
    """

    base: Fit
    best: Fit
    verdict: str
    selected: tuple[str, ...]
    labels: tuple[str, ...]
    groups: tuple[tuple[str, ...], ...]
    ranking: tuple[Candidate, ...]
    noise_floor: float
    heldout_rmse: float
    heldout_rmse_after: float
    pattern: Pattern | None
    next_experiment: Experiment | None
    sentence: str
    follows: tuple[Follows, ...] = ()
    details: dict[str, Any] = field(default_factory=dict)
    heldout: str = "refit"
    rmse_mm: float | None = None
    rmse_after_mm: float | None = None


@dataclass(frozen=True)
class Rung:
    """One step of a ladder: the fit with the effects so far, its error on held-out data in N, and why it was taken.

    `found` is the diagnosis that led to it, None for the law alone. Where a ladder is nested, `heldout_rmse` is that of
    as many effects, chosen anew without the held-out rows, and `refit_rmse` the error with these ones fitted anew.
    """

    fit: Fit
    heldout_rmse: float
    why: str
    found: Diagnosis | None = None
    refit_rmse: float | None = None

    @property
    def effects(self) -> tuple[str, ...]:
        """Labels of the effects in the model."""
        return tuple(self.fit.model.labels)

    @cached_property
    def rmse_mm(self) -> float | None:
        """Error of the length in mm rms by its model fitted to that, where a load was held; None where none was."""
        return length_rmse(self.fit)


@dataclass(frozen=True)
class Nested:
    """What was held out while everything was chosen anew, in how many `parts`, and how laws alone do there.

    `beside` maps names of laws, and `mean over pressure`, to their number of parameters and error in N, best first.
    `text` says it in words, and which effects predicted nothing better and were left out.
    """

    by: str
    parts: int
    beside: Mapping[str, tuple[int, float]]
    text: str


@dataclass(frozen=True)
class Ladder:
    """From the law alone up to the noise floor, one effect a rung; `last` says why it ended there.

    `nested` is there where everything was chosen anew without the held-out rows.
    """

    rungs: tuple[Rung, ...]
    noise_floor: float
    last: Diagnosis
    nested: Nested | None = None

    @property
    def first(self) -> Diagnosis:
        """The diagnosis of the law alone."""
        return (self.rungs[1].found if len(self.rungs) > 1 else None) or self.last

    @property
    def verdict(self) -> str:
        """Of the last rung: adequate, missing_effect or unknown_effect."""
        return self.last.verdict

    @cached_property
    def groups(self) -> tuple[tuple[str, ...], ...]:
        """Each effect of the last rung that the record cannot tell from others, with those that it does not hold."""
        held = self.rungs[-1].fit.model.effect_names
        found = {group[0]: group for rung in self.rungs if rung.found for group in rung.found.groups}
        left = (
            tuple(n for n in group if n == first or n not in held) for first, group in found.items() if first in held
        )
        return tuple(group for group in left if len(group) > 1)

    @cached_property
    def elsewhere(self) -> Elsewhere:
        """What the record says of the last rung on others, its effects and forms kept."""
        return Elsewhere.of(self.rungs[-1].fit)
