"""Per isobar and branch: the tables of the paper, and the energy of each loop."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..core import Array, FitError
from ..laws import Law
from ..model import Model
from ..records import Record
from .fit import Estimate, Fit, fit

FOLDED = {"exponential_law": ("a", "b", "c")}
"""Laws whose linear parameters come in pairs x0 + x1 p, and the names of x per isobar."""


@dataclass(frozen=True)
class IsobarRow:
    """Parameters of one law on one isobar and branch; `problems` say why its fit is not valid."""

    pressure_MPa: float
    branch: str
    estimates: tuple[Estimate, ...]
    rmse: float
    problems: tuple[str, ...]


@dataclass(frozen=True)
class IsobarTable:
    """All isobars, and for laws linear in pressure the correlation of each coefficient with pressure by branch.

    `two_stage` holds the parameters of the whole law from straight lines through the isobars, by branch.
    """

    rows: tuple[IsobarRow, ...]
    correlation: dict[str, dict[str, float]]
    two_stage: dict[str, dict[str, float]]

    @property
    def problems(self) -> list[str]:
        """Why fits of isobars are not valid, those that share a reason in one line."""
        where: dict[tuple[str, str], list[str]] = {}
        for row in self.rows:
            for problem in row.problems:
                where.setdefault((row.branch, problem), []).append(f"{row.pressure_MPa:g}")
        return [f"{branch}, {', '.join(levels)} MPa alone: {problem}" for (branch, problem), levels in where.items()]


def fit_isobars(
    model: Model,
    record: Record,
    branches: tuple[str, ...],
    held: Mapping[str, float] | None = None,
    rows: Array | None = None,
) -> IsobarTable:
    """Fit each isobar alone, as the paper does, over `rows` (mask (n,), default all); `held` keep their values.

    For exponential_law the isobar's law is a − b ε + c exp(−μ ε) with μ shared by all isobars (held, or from
    the global fit of the branch), then a line in p through each of a, b, c. Other laws keep their own
    parameters per isobar. Raises FitError when no isobar can be fitted.
    """
    found: list[IsobarRow] = []
    correlation: dict[str, dict[str, float]] = {}
    two_stage: dict[str, dict[str, float]] = {}
    folded = FOLDED.get(model.law.name)
    alone = replace(model, law=_one_pressure(model.law) if folded else replace(model.law, min_levels=1))
    for branch in branches:
        mask = record.branch_rows(branch) if rows is None else record.branch_rows(branch) & rows
        given = dict(held or {})
        if folded and any(p.name not in given for p in model.law.nonlinear):
            shared = fit(model, record, mask, detail=False, held=given).values
            given = {p.name: shared[p.name] for p in model.law.nonlinear} | given
        mine = _rows(alone, record, mask, branch, {k: v for k, v in given.items() if k in alone.names})
        found += mine
        if folded and len(mine) >= 2:
            lines = _lines(mine, folded)
            correlation[branch] = {key: line[2] for key, line in lines.items()}
            two_stage[branch] = given | {f"{k}{i}": line[i] for k, line in lines.items() for i in (0, 1)}
    if not found:
        raise FitError(f"{record.source or record.name}: no isobar has enough samples for {model.law.name}")
    return IsobarTable(tuple(found), correlation, two_stage)


def _rows(model: Model, record: Record, mask: Array, branch: str, held: Mapping[str, float]) -> list[IsobarRow]:
    found = []
    for level in record.levels:
        here = mask & (record.level == level)
        if here.sum() > len(model.params) - len(held) and np.ptp(record.inputs.contraction[here]) > 0.0:
            one: Fit = fit(model, record, here, held=held)
            flat = replace(record, inputs=replace(record.inputs, pressure=np.full(len(record), float(level))))
            seen = fit(model, flat, here, held=held).estimates
            free = tuple(_alone(e, s) for e, s in zip(one.estimates, seen, strict=True) if e.name not in held)
            found.append(IsobarRow(float(level), branch, free, one.rmse, tuple(one.problems)))
    return found


def _alone(e: Estimate, at_level: Estimate) -> Estimate:
    """An estimate of one isobar, not identified where that is so `at_level`, the isobar's pressure: by the sensor's
    noise alone a law's part that grows with pressure would be told from one that does not."""
    if at_level.identified:
        return e
    return replace(e, stderr=math.nan, low=math.nan, high=math.nan, identified=False, verdict=at_level.verdict)


def _lines(rows: list[IsobarRow], names: tuple[str, ...]) -> dict[str, tuple[float, float, float]]:
    """Intercept, slope and correlation coefficient over pressure of each coefficient."""
    pressure = np.array([row.pressure_MPa for row in rows])
    lines = {}
    for name in names:
        values = np.array([next(e.value for e in row.estimates if e.name == name) for row in rows])
        slope, intercept = np.polyfit(pressure, values, 1)
        spread = np.std(values) * np.std(pressure)
        together = np.mean((values - values.mean()) * (pressure - pressure.mean()))
        lines[name] = (float(intercept), float(slope), float(together / spread) if spread > 0 else math.nan)
    return lines


def _one_pressure(law: Law) -> Law:
    """The exponential law at one pressure: its columns for p = 0 under the names a, b, c."""
    linear = tuple(replace(p, name=p.name[0]) for p in law.linear if p.name.endswith("0"))
    pick = [i for i, p in enumerate(law.linear) if p.name.endswith("0")]
    return replace(law, linear=linear, columns=lambda p, e, s, q: law.columns(p, e, s, q)[:, pick], min_levels=1)


def loop_energies(record: Record, force: Array) -> dict[float, float]:
    """Energy in J of a cycle of each isobar, by MPa, from the branches' mean `force` (n,) in N over contraction.

    Positive: the loop dissipates. Negative: the extension force lies below the contraction force and the loop
    would give energy back, which no passive muscle can. Empty without both branches.
    """
    energies: dict[float, float] = {}
    direction, x = record.inputs.direction, record.inputs.displacement_mm
    usable = np.ones(len(record), bool) if record.inputs.moving is None else record.inputs.moving
    for level in record.levels:
        here = (record.level == level) & usable
        up, down = here & (direction > 0), here & (direction < 0)
        if up.sum() < 4 or down.sum() < 4:
            continue
        low, high = max(x[up].min(), x[down].min()), min(x[up].max(), x[down].max())
        if high <= low:
            continue
        edges = np.linspace(low, high, int(min(41, up.sum(), down.sum())))
        gap = _mean_curve(x[down], force[down], edges) - _mean_curve(x[up], force[up], edges)
        energies[float(level)] = float(np.trapezoid(gap, edges)) * 1e-3
    return energies


def _mean_curve(x: Array, force: Array, at: Array) -> Array:
    """Force over displacement with repeats averaged, interpolated at `at`."""
    order = np.argsort(x, kind="stable")
    edges = np.linspace(0, len(order), min(len(order), 4 * len(at)) + 1).astype(int)
    count = np.diff(edges)
    place, mean = (np.add.reduceat(v[order], edges[:-1]) / count for v in (x, force))
    return np.interp(at, place, mean)
