"""One fitted parameter, and what nature says of it."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..core.param import Param, Range
from ..effects import in_words
from .covariance import Covariance, Sums, covariance_of, student
from .identifiability import AT_BOUND, HELD, ONE, PINNED, Identifiability, flat_directions, verdicts


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
    def words(self) -> str:
        """The parameter with its value in a sentence: `q = 1.3 of extensible threads`."""
        effect, _, name = self.name.rpartition(".")
        value = f"{name} = {self.value:.3g}{'' if self.unit == '1' else f' {self.unit}'}"
        return f"{value} of {in_words(effect)}" if effect else value

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
    return f"{e.words} is impossible: {span} by {e.range.source}"


def estimates_of(
    params: Sequence[Param], values: Mapping[str, float], held: Mapping[str, float], sums: Sums | None
) -> tuple[tuple[Estimate, ...], Covariance | None]:
    """An estimate of each parameter, in order, and the covariance of those that are free; what stands at a bound is
    taken as given. No errors without `sums`, whose columns are the parameters."""
    stuck = {p.name for p in params if p.name not in held and at_bound(p, values[p.name])}
    fixed = {*held, *(p.name for p in params if p.lower == p.upper)}
    given = {p.name: HELD if p.name in fixed else AT_BOUND for p in params if p.name in fixed or p.name in stuck}
    found: dict[str, Estimate] = {}
    cov = None
    if sums is not None and params:
        fitted = [k for k, p in enumerate(params) if p.name not in held]
        flat = flat_directions([params[k].name for k in fitted], sums.triangle[:, fitted])
        free = [k for k, p in enumerate(params) if p.name not in given]
        cov = covariance_of(sums.take(free))
        found = {e.name: e for e in _determined([params[k] for k in free], values, cov, flat)}
        given |= {name: verdict for name, verdict in flat.items() if name in stuck}
    estimates = []
    for p in params:
        verdict = given.get(p.name, PINNED)
        loose = verdict.kind in ("flat", "dead")
        value, at_end = values[p.name], p.name in stuck
        plain = Estimate(p.name, p.unit, p.doc, value, math.nan, at_end, not loose, verdict=verdict, range=p.range)
        estimates.append(found.get(p.name, plain))
    return tuple(_not_told_apart(estimates)), cov


def _not_told_apart(estimates: list[Estimate]) -> list[Estimate]:
    """With a law's parameter at its bound, others that take each other's part to the last digit are not identified."""
    stuck = [e.name for e in estimates if e.at_bound and "." not in e.name]
    tied = [e.name for e in estimates if e.verdict.kind == "traded" and e.verdict.tie >= ONE] if stuck else []
    loose = [*stuck, *tied] if tied else []
    return [replace(e, identified=False) if e.name in loose else e for e in estimates]


def _determined(
    free: list[Param], values: Mapping[str, float], cov: Covariance, flat: Mapping[str, Identifiability]
) -> Iterator[Estimate]:
    """Estimates of the free parameters with their intervals and verdicts."""
    stderr, dof = cov.error(np.eye(len(free)))
    half = student(dof) * stderr
    for p, s, d, h, verdict in zip(free, stderr, dof, half, verdicts(free, values, cov, half), strict=True):
        verdict = flat.get(p.name, verdict)
        value, known = values[p.name], verdict.determined
        s, d, h = (float(x) if known else math.nan for x in (s, d, h))
        yield Estimate(p.name, p.unit, p.doc, value, s, False, known, value - h, value + h, d, verdict, p.range)


def at_bound(p: Param, value: float) -> bool:
    """Whether a value stands at a bound of its parameter."""
    span = p.upper - p.lower if math.isfinite(p.upper - p.lower) else max(abs(value), 1.0)
    return min(value - p.lower, p.upper - value) <= 1e-7 * span
