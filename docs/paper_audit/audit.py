"""What the paper's printed figures say about each other.

Every number is worked out from the printed figures (datasets/paper_laws) by the program's own laws and fits.
The paper prints neither braid angle nor wall nor modulus: the first two are those of the data set's specimen.toml,
assumed, and `Audit.angles` tells how much hangs on the angle.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pam_ident.core import Inputs, Specimen
from pam_ident.fitting import fit_isobars
from pam_ident.laws import get_law
from pam_ident.model import Model
from pam_ident.records import Record, read_record
from pam_ident.records.datasets import dataset_record

from .printed import BRANCHES, Printed, PrintedLaw, read_printed
from .tables import (
    Isobar,
    Loop,
    Shared,
    TableGap,
    at_angle,
    bladder_force,
    isobars,
    law_force,
    loops,
    shared,
    table_force,
    table_gaps,
)

ANGLES_DEG = (23.0, 24.0, 25.0, 26.0, 27.0)
"""Braid angles at rest with which the findings are worked out again."""
CONTRACTIONS = (0.01, 0.1, 0.2)
"""Contraction ratios at which the two forms of the bladder's force are compared."""


@dataclass(frozen=True)
class Misprint:
    """A coefficient that two equations print differently for one law, and the force in N between the two at most."""

    branch: str
    coefficient: str
    equations: tuple[str, str]
    values: tuple[float, float]
    force: float


@dataclass(frozen=True)
class Bladder:
    """Equation (2) as printed, its number taken as N with all lengths in m, against the form by virtual work.

    `inflation`: contraction ratio → how many times Young's a modulus must be for the printed form to give the same
    force; `fitted` the same by least squares over the longest stroke. `force` and `linear` (contraction ratio → N per
    MPa): the form by virtual work, and its tangent at rest.
    """

    inflation: Mapping[float, float]
    fitted: float
    force: Mapping[float, float]
    linear: Mapping[float, float]


@dataclass(frozen=True)
class Scatter:
    """What the correlation coefficient of Table 3 says of one coefficient's straight line over pressure.

    `r` as printed, `refitted` from the isobars of the reconstructed record; `scatter` in N is the standard deviation of
    the isobars' coefficient about the line that r stands for, with the standard errors it gives `slope` (N/MPa) and
    `intercept` (N). For a least-squares line through n pressures: SSE = slope² Σ(p − p̄)² (1/r² − 1), n − 2 degrees.
    """

    branch: str
    coefficient: str
    r: float
    refitted: float
    scatter: float
    slope: float
    slope_error: float
    intercept: float
    intercept_error: float


@dataclass(frozen=True)
class Angle:
    """The findings that hang on the braid angle, at one of them; forces in N.

    `rms` of the tables against the laws over all isobars, `rms_best` with the best modulus for each isobar; `mean_gaps`
    of the tables' loops by pressure; `shared_rmse` by branch of one k0, k1, k2 for all pressures.
    """

    angle_deg: float
    bladder: Bladder
    rms: float
    rms_best: float
    mean_gaps: Mapping[float, float]
    shared_rmse: Mapping[str, float]


@dataclass(frozen=True)
class Audit:
    """All findings, at the assumed geometry `specimen`; `strokes` are the contraction ratios compared, by pressure."""

    printed: Printed
    specimen: Specimen
    strokes: Mapping[float, float]
    misprints: tuple[Misprint, ...]
    bladder: Bladder
    gaps: tuple[TableGap, ...]
    law_loops: tuple[Loop, ...]
    table_loops: tuple[Loop, ...]
    isobars: tuple[Isobar, ...]
    shared: tuple[Shared, ...]
    scatter: tuple[Scatter, ...]
    angles: tuple[Angle, ...]


def audit_paper() -> Audit:
    """Work out every finding. Raises UsageError where the data sets were not installed."""
    printed = read_printed()
    grid = read_record(dataset_record("paper_laws"))
    record = replace(grid, force=law_force(printed, grid))
    return Audit(
        printed,
        record.specimen,
        {float(p): float(record.inputs.contraction[record.level == p].max()) for p in record.levels},
        _misprints(printed, record),
        _bladder(record.inputs),
        table_gaps(printed, record),
        loops(record, record.force),
        loops(record, table_force(printed, record)),
        isobars(printed, record),
        shared(record),
        _scatter(printed, record),
        tuple(_angle(printed, at_angle(record, angle)) for angle in ANGLES_DEG),
    )


def _misprints(printed: Printed, record: Record) -> tuple[Misprint, ...]:
    found = []
    for branch in BRANCHES:
        first, *others = (law for law in printed.laws if law.branch == branch)
        for other in others:
            differ = [name for name in first.values if first.values[name] != other.values[name]]
            found += [_misprint(first, other, name, record) for name in differ]
    return tuple(found)


def _misprint(first: PrintedLaw, other: PrintedLaw, name: str, record: Record) -> Misprint:
    rows, inputs = record.branch_rows(first.branch), record.inputs
    forces = [
        get_law("exponential_law").force(inputs.pressure[rows], inputs.contraction[rows], record.specimen, values)
        for values in (first.values, {**first.values, name: other.values[name]})
    ]
    between = float(np.max(np.abs(forces[0] - forces[1])))
    values = first.values[name], other.values[name]
    return Misprint(first.branch, name, (first.equation, other.equation), values, between)


def _bladder(inputs: Inputs) -> Bladder:
    at = np.array(CONTRACTIONS)
    right, printed = (
        _at_rest_pressure(inputs, at, name) for name in ("bladder_elasticity", "bladder_elasticity_printed")
    )
    in_metres = printed * 1e-3  # N·mm by internal units; in SI the number of N·m is taken for N
    along = np.linspace(0.0, float(inputs.contraction.max()), 201)
    whole, form = (
        _at_rest_pressure(inputs, along, name) for name in ("bladder_elasticity", "bladder_elasticity_printed")
    )
    step = 1e-5
    slope = float(np.diff(_at_rest_pressure(inputs, np.array([-step, step]), "bladder_elasticity"))[0]) / (2.0 * step)
    return Bladder(
        dict(zip(CONTRACTIONS, (right / in_metres).tolist(), strict=True)),
        float(whole @ form) / float(form @ form) * 1e3,
        dict(zip(CONTRACTIONS, (-right).tolist(), strict=True)),
        dict(zip(CONTRACTIONS, (-slope * at).tolist(), strict=True)),
    )


def _at_rest_pressure(inputs: Inputs, contraction: np.ndarray, name: str) -> np.ndarray:
    """The bladder's force per modulus at other contractions; it does not depend on pressure."""
    nothing = np.zeros(len(contraction))
    return bladder_force(Inputs(nothing, contraction, inputs.specimen, nothing), name)


def _scatter(printed: Printed, record: Record) -> tuple[Scatter, ...]:
    refitted = fit_isobars(Model.build("exponential_law"), record, BRANCHES).correlation
    found = []
    for branch, correlation in printed.correlation.items():
        p = np.array([row.pressure_MPa for row in printed.rows if row.branch == branch])
        square, n = float(np.sum((p - p.mean()) ** 2)), len(p)
        values = printed.law(branch).values
        for name, r in correlation.items():
            slope = values[f"{name}1"]
            scatter = abs(slope) * math.sqrt(square * (1.0 / r**2 - 1.0) / (n - 2))
            errors = scatter / math.sqrt(square), scatter * math.sqrt(1.0 / n + float(p.mean()) ** 2 / square)
            again = refitted[branch][name]
            found.append(Scatter(branch, name, r, again, scatter, slope, errors[0], values[f"{name}0"], errors[1]))
    return tuple(found)


def _angle(printed: Printed, record: Record) -> Angle:
    gaps = table_gaps(printed, record)
    return Angle(
        record.specimen.braid_angle_deg,
        _bladder(record.inputs),
        math.sqrt(np.mean([gap.rms**2 for gap in gaps])),
        math.sqrt(np.mean([gap.rms_best**2 for gap in gaps])),
        {loop.pressure_MPa: loop.mean_gap for loop in loops(record, table_force(printed, record))},
        {one.branch: one.rmse for one in shared(record) if not one.effects},
    )
