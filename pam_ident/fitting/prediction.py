"""The force of a fitted model where nothing was measured, with intervals of its mean and of a new reading."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..core import Array, FitError, Inputs, Specimen
from ..core.progress import steps
from ..model import Model
from ..records import Record, thinned
from ..records.folds import in_parts
from .covariance import LEVEL, student
from .fit import Fit, fit, picker
from .floor import repeat_noise
from .length import equilibrium
from .solve import jacobian, solve

ROWS = 4_000
"""Rows of a longer record that are enough to learn how far readings lie off."""
NEAR_MPA = 0.01
"""How near a pressure must be to one of the record's to count as measured there."""
NEAR_SPEED = 1.25
"""The same of a speed, as a ratio."""
NORMAL_95 = 1.96
"""Half width of 95 % of normal noise of one."""
WIDE = 1.25
"""How much wider than the noise's the interval of a reading must be to be told as wide."""


@dataclass(frozen=True)
class ReadingSpread:
    """How far readings lie off a fit that has not seen them: half the width in N that holds 95 % of them.

    `same` is of other cycles at the record's own pressures and speeds, `between` of a pressure between its own,
    `beyond` of one outside them, `speed` of another speed; each from refits without those readings, NaN where the
    record has too few to leave any out. `pressures` (MPa), `speeds` (mm/s) and `contraction` (from, to) were measured.
    `noise` is the standard deviation in N that repeated strokes show, NaN without them.
    """

    same: float
    between: float
    beyond: float
    speed: float
    pressures: tuple[float, ...]
    speeds: tuple[float, ...]
    contraction: tuple[float, float]
    noise: float = math.nan

    @property
    def wide(self) -> bool:
        """Whether readings lie off by far more than noise: the model lacks something, and its intervals hold that."""
        return self.same > WIDE * NORMAL_95 * self.noise

    def half_width(self, inputs: Inputs) -> Array:
        """Half the width in N of the interval of a reading at each sample, shape (n,); NaN where nothing is known."""
        p, levels = inputs.pressure, np.array(self.pressures)
        off = np.min(np.abs(p[:, None] - levels), axis=1) > NEAR_MPA
        outside = off & ((p < levels.min()) | (p > levels.max()))
        half = np.where(outside, self.beyond, np.where(off, self.between, self.same))
        if inputs.stroke_speed is not None and self.speeds:
            half = np.where(self._new_speed(inputs.stroke_speed), np.maximum(half, self.speed), half)
        return half

    def outside(self, inputs: Inputs) -> Array:
        """Whether a sample lies outside the measured pressures or contractions, where no interval was tried, (n,)."""
        low, high = self.contraction
        room = 0.02 * (high - low)
        e, p = inputs.contraction, inputs.pressure
        beyond = (e < low - room) | (e > high + room)
        return beyond | (p < min(self.pressures) - NEAR_MPA) | (p > max(self.pressures) + NEAR_MPA)

    def _new_speed(self, speed: Array) -> Array:
        ratio = np.maximum(speed, 1e-9)[:, None] / np.array(self.speeds)
        return np.min(np.maximum(ratio, 1.0 / ratio), axis=1) > NEAR_SPEED


def reading_spread(one: Fit) -> ReadingSpread:
    """What refits without some cycles, a pressure or a speed leave of the readings there; where the length answered
    only what was measured, for nothing is known of readings of a force."""
    record, rows = one.record, one.rows
    if one.lengths is not None:
        p, e, speed = (x[rows] for x in (record.inputs.pressure, record.inputs.contraction, _speeds(record)))
        (pressures, span), nan = ((float(x.min()), float(x.max())) for x in (p, e)), math.nan
        return ReadingSpread(nan, nan, nan, nan, pressures, tuple(np.unique(speed[speed > 0]).tolist()), span)
    if len(record) > ROWS:
        record = thinned(record if rows.all() else record.take(np.flatnonzero(rows)), ROWS)
        rows = np.ones(len(record), bool)
        one = replace(one, record=record, rows=rows, weights=None)
    level, speed = record.level, _speeds(record)
    levels, speeds = np.unique(level[rows]), np.unique(speed[rows & (speed > 0)])
    cycles = in_parts(record.block, among=record.block[rows])
    inner, outer = [level == p for p in levels[1:-1]], [level == p for p in (levels[0], levels[-1])]
    if len(levels) <= one.model.law.min_levels:
        inner = outer = []
    e = record.inputs.contraction[rows]
    same, noise = _half(one, cycles, "cycles"), repeat_noise(one)
    return ReadingSpread(
        same,
        _wider(same, _half(one, inner, "pressures"), len(inner)),
        _wider(same, _half(one, outer, "pressures at the ends"), len(outer)),
        _wider(same, _half(one, [speed == v for v in speeds] if len(speeds) > 1 else [], "speeds"), len(speeds)),
        tuple(levels.tolist()),
        tuple(speeds.tolist()),
        (float(e.min()), float(e.max())),
        math.nan if noise is None else noise.sigma,
    )


def _speeds(record: Record) -> Array:
    """Speed of each sample's stroke in mm/s, speeds within a tenth taken as one, shape (n,); 0 in a static table."""
    speed = record.inputs.stroke_speed
    if speed is None:
        return np.zeros(len(record))
    values = np.unique(np.round(speed, 6))
    values = values[values > 0]
    if not len(values):
        return np.zeros(len(record))
    group = np.r_[0, np.cumsum(values[1:] > 1.1 * values[:-1])]
    middle = np.array([np.median(values[group == g]) for g in range(group[-1] + 1)])
    nearest = np.argmin(np.abs(np.log(np.maximum(speed, 1e-9))[:, None] - np.log(middle)), axis=1)
    return np.where(speed > 0, middle[nearest], 0.0)


def _half(one: Fit, groups: list[Array], what: str) -> float:
    """Half the width that holds LEVEL of the readings of each group, by the model fitted to the others."""
    record, model = one.record, one.model
    found = []
    for group in steps(groups, f"leaving {what} out"):
        left, out = one.rows & ~group, one.rows & group
        if np.count_nonzero(left) <= len(model.params) or not out.any():
            continue
        pick, held = picker(left, one.weights), {**one.held, **{name: one.values[name] for name in one.shared}}
        try:
            values = solve(model, record.inputs, record.force, pick, one.values, quick=True, held=held).values
        except FitError:
            continue
        found.append(np.abs(record.force - model.force(record.inputs, values))[out])
    return _quantile(found) if found and (len(found) > 1 or len(groups) == 1) else math.nan


def _wider(same: float, half: float, groups: int) -> float:
    """The half width with room for a group more than the few it is from, at least that of the `same` conditions."""
    return float(np.fmax(half * math.sqrt(1.0 + 0.5 / max(groups, 1)), same)) if math.isfinite(half) else math.nan


def _quantile(groups: list[Array]) -> float:
    """The quantile at LEVEL of absolute errors, groups alike."""
    errors = np.concatenate(groups)
    order = np.argsort(errors)
    weight = np.concatenate([np.full(len(g), 1.0 / len(g)) for g in groups])[order]
    place = int(np.searchsorted(np.cumsum(weight), LEVEL * weight.sum()))
    return float(errors[order][min(place, len(errors) - 1)])


@dataclass(frozen=True)
class Prediction:
    """Force in N of n samples, shape (n,) each: the mean with its standard error, the half widths of the 95 % intervals
    of the mean and of a new reading, NaN where they are not known, whether the record did not reach there, and whether
    the interval of a reading is wide because the model leaves more than noise."""

    force: Array
    stderr: Array
    half_mean: Array
    half_reading: Array
    outside: Array
    unexplained: Array


@dataclass(frozen=True)
class LengthPrediction:
    """Contraction at which n samples carry their loads, shape (n,) each: with its standard error and the half widths of
    the 95 % intervals of the mean and of a new reading in mm, NaN where they are not known, and whether the record that
    was fitted did not reach there. All of them are NaN where the model has no stable length."""

    contraction: Array
    stderr: Array
    half_mean: Array
    half_reading: Array
    outside: Array


@dataclass(frozen=True)
class Predictor:
    """A fitted model that is asked elsewhere.

    `free` and `matrix` (k, k) are the parameters that have errors and their covariance, None where no errors are known;
    `dof` the fewest degrees of freedom that any of them has. `spread` is None in files of earlier versions.
    """

    model: Model
    specimen: Specimen
    values: Mapping[str, float]
    free: tuple[str, ...]
    matrix: Array | None
    dof: float
    spread: ReadingSpread | None

    @classmethod
    def of(cls, one: Fit, spread: ReadingSpread) -> "Predictor":
        """That of a fit."""
        dofs = [e.dof for e in one.estimates if e.name in one.free and math.isfinite(e.dof)]
        matrix = None if one.covariance is None else one.covariance.matrix
        return cls(one.model, one.record.specimen, one.values, one.free, matrix, min(dofs, default=math.nan), spread)

    def at(self, inputs: Inputs) -> Prediction:
        """The force at `inputs`. The interval of a reading holds the noise and what the model leaves unexplained."""
        force = self.model.force(inputs, self.values)
        stderr = self._stderr(inputs, force)
        # A law without free parameters has no error of its own.
        half = student(np.array(self.dof)) * stderr if math.isfinite(self.dof) else stderr
        if self.spread is None:
            nothing = np.full(len(force), math.nan)
            no = np.zeros(len(force), bool)
            return Prediction(force, stderr, half, nothing, no, no)
        reading = np.hypot(self.spread.half_width(inputs), half)
        wide = np.full(len(force), self.spread.wide)
        return Prediction(force, stderr, half, reading, self.spread.outside(inputs), wide)

    def carrying(self, inputs: Inputs, load: Array) -> LengthPrediction:
        """The contraction at which the model carries `load` (n,) in N at the pressures of `inputs`."""
        e, slope = equilibrium(self.model, inputs, self.values, load)
        e = np.where(slope < 0.0, e, math.nan)
        there = replace(inputs, contraction=np.nan_to_num(e))
        found = self.at(there)
        by_newton = inputs.specimen.initial_length_mm / np.where(slope < 0.0, -slope, math.nan)
        stderr, mean, reading = (by_newton * half for half in (found.stderr, found.half_mean, found.half_reading))
        return LengthPrediction(e, stderr, mean, reading, found.outside | np.isnan(e))

    def _stderr(self, inputs: Inputs, force: Array) -> Array:
        if self.matrix is None or not self._index:
            return np.zeros(len(force)) if not self.model.params else np.full(len(force), math.nan)
        slopes = jacobian(self.model, inputs, self.values, force)[:, self._index]
        return np.sqrt(np.maximum(np.einsum("nk,kl,nl->n", slopes, self.matrix, slopes), 0.0))

    @cached_property
    def _index(self) -> list[int]:
        names = [p.name for p in self.model.params]
        return [] if self.matrix is None else [names.index(name) for name in self.free]


@dataclass(frozen=True)
class Simpler:
    """Models that any muscle model must beat, fitted to the same rows: the mean force as a line over pressure, N and
    N/MPa, or where the length answered the mean contraction, 1 and 1/MPa, and the polynomial law's values, None where
    the record cannot fit it."""

    line: tuple[float, float] | None
    polynomial: Mapping[str, float] | None
    contraction_line: tuple[float, float] | None = None

    def forces(self, inputs: Inputs) -> dict[str, Array]:
        """What each predicts at `inputs`, N, shape (n,), by name."""
        found = {} if self.line is None else {"mean_over_pressure": self.line[0] + self.line[1] * inputs.pressure}
        if self.polynomial is not None:
            found["polynomial"] = Model("polynomial").force(inputs, self.polynomial)
        return found

    def contractions(self, inputs: Inputs, load: Array) -> dict[str, Array]:
        """The contraction that each predicts under `load` (n,) in N, shape (n,), by name."""
        found = {}
        if self.contraction_line is not None:
            found["contraction_over_pressure"] = self.contraction_line[0] + self.contraction_line[1] * inputs.pressure
        if self.polynomial is not None:
            found["polynomial"] = equilibrium(Model("polynomial"), inputs, self.polynomial, load)[0]
        return found


def simpler(one: Fit) -> Simpler:
    """The simpler models of a fit's rows."""
    record, rows = one.record, one.rows
    p, answer = record.inputs.pressure[rows], (record.force if one.lengths is None else record.inputs.contraction)[rows]
    varied = len(np.unique(record.level[rows])) > 1 if one.lengths is None else np.ptp(p) > 0.0
    slope, offset = np.polyfit(p, answer, 1) if varied else (0.0, answer.mean())
    try:
        values = fit(Model("polynomial"), record, rows, detail=False).values
    except FitError:
        values = None
    line = (float(offset), float(slope))
    return Simpler(line, values) if one.lengths is None else Simpler(None, values, line)


@dataclass(frozen=True)
class Elsewhere:
    """What a fit's own record says of it on others: how far readings lie off, and the simpler models it must beat."""

    spread: ReadingSpread
    simpler: Simpler

    @classmethod
    def of(cls, one: Fit) -> "Elsewhere":
        """That of a fit, by refits without a part of its rows."""
        return cls(reading_spread(one), simpler(one))
