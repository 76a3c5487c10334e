"""Tables 1 and 2 of the paper against its laws (4) and (5): forces, loops, and the parameters themselves."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pam_ident.core import Inputs, Specimen
from pam_ident.effects import get_effect
from pam_ident.fitting import fit_branches, fit_isobars, loop_energies
from pam_ident.laws import get_law
from pam_ident.model import Model
from pam_ident.records import Record

from .printed import BRANCHES, Printed

Array = np.ndarray
MODULI_MPA = (0.5, 1.0, 2.0)
"""Young's moduli at which the bladder's force is added to Tables 1 and 2; the paper prints none."""


@dataclass(frozen=True)
class TableGap:
    """Force of equation (1) with a row of Table 1 or 2, minus the branch's law, along one isobar.

    `law_rest`, `table_rest`: the two forces at ε = 0; `rms` and `largest` (with its sign) without F_t; `rms_with` by
    modulus in MPa with it; `best_modulus` ≥ 0 in MPa leaves the least, `rms_best`. Forces in N.
    """

    branch: str
    pressure_MPa: float
    k2: float
    law_rest: float
    table_rest: float
    rms: float
    largest: float
    rms_with: Mapping[float, float]
    best_modulus: float
    rms_best: float


@dataclass(frozen=True)
class Loop:
    """Energy in J that one isobar's loop takes up, and the mean of extension minus contraction force in N."""

    pressure_MPa: float
    energy: float
    mean_gap: float


@dataclass(frozen=True)
class Isobar:
    """k0, k1, k2 of one isobar as printed and as fitted to the branch's law; `at_bound` names those at a bound."""

    branch: str
    pressure_MPa: float
    printed: Mapping[str, float]
    fitted: Mapping[str, float]
    at_bound: tuple[str, ...]
    rmse: float


@dataclass(frozen=True)
class Shared:
    """Equation (1) with parameters shared by all pressures, fitted to the branch's law; errors in N."""

    branch: str
    effects: tuple[str, ...]
    values: Mapping[str, float]
    rmse: float
    max_error: float


def law_force(printed: Printed, record: Record) -> Array:
    """Force in N of laws (4) and (5) at the record's samples, each on its branch, shape (n,)."""
    force, inputs = np.empty(len(record)), record.inputs
    for branch in BRANCHES:
        rows = record.branch_rows(branch)
        values = printed.law(branch).values
        force[rows] = get_law("exponential_law").force(
            inputs.pressure[rows], inputs.contraction[rows], record.specimen, values
        )
    return force


def table_force(printed: Printed, record: Record) -> Array:
    """Force in N of equation (1) without F_t, Table 1 or 2 on each branch and isobar, shape (n,)."""
    force, inputs = np.empty(len(record)), record.inputs
    for row in printed.rows:
        rows = record.branch_rows(row.branch) & (record.level == row.pressure_MPa)
        force[rows] = get_law("modified_chou_hannaford").force(
            inputs.pressure[rows], inputs.contraction[rows], record.specimen, row.values
        )
    return force


def bladder_force(inputs: Inputs, name: str = "bladder_elasticity") -> Array:
    """Force in N per unit of modulus of an elastic bladder in its simplest form, −F_t/E, shape (n,)."""
    return get_effect(name)[1].columns(inputs, {}, np.zeros(len(inputs)))[:, 0]


def at_angle(record: Record, angle_deg: float) -> Record:
    """The same samples on a braid of another angle at rest."""
    return replace(record, inputs=with_specimen(record.inputs, braid_angle_deg=angle_deg))


def with_specimen(inputs: Inputs, **geometry: float) -> Inputs:
    """The same samples on a specimen with other figures."""
    specimen: Specimen = replace(inputs.specimen, **geometry)
    return replace(inputs, specimen=specimen)


def table_gaps(printed: Printed, record: Record) -> tuple[TableGap, ...]:
    """A gap a row of Tables 1 and 2, over the isobar's stroke in `record`, which must begin at ε = 0."""
    law, table, elastic = law_force(printed, record), table_force(printed, record), bladder_force(record.inputs)
    found = []
    for row in printed.rows:
        rows = np.flatnonzero(record.branch_rows(row.branch) & (record.level == row.pressure_MPa))
        rest = rows[np.argmin(record.inputs.contraction[rows])]
        gap, per_modulus = (table - law)[rows], elastic[rows]
        best = max(0.0, -float(gap @ per_modulus) / float(per_modulus @ per_modulus))
        found.append(
            TableGap(
                row.branch,
                row.pressure_MPa,
                row.values["k2"],
                float(law[rest]),
                float(table[rest]),
                _rms(gap),
                float(gap[np.argmax(np.abs(gap))]),
                {modulus: _rms(gap + modulus * per_modulus) for modulus in MODULI_MPA},
                best,
                _rms(gap + best * per_modulus),
            )
        )
    return tuple(found)


def loops(record: Record, force: Array) -> tuple[Loop, ...]:
    """The loop of each isobar of a force (n,) in N along the record, over the contraction both branches cover."""
    found = []
    for level, energy in loop_energies(record, force).items():
        here = record.level == level
        stroke = float(np.ptp(record.inputs.displacement_mm[here]))
        found.append(Loop(level, energy, energy / stroke * 1e3))
    return tuple(found)


def isobars(printed: Printed, record: Record) -> tuple[Isobar, ...]:
    """Equation (1) without F_t fitted to each isobar of `record` alone, beside the printed figures."""
    table = fit_isobars(Model.build("modified_chou_hannaford"), record, BRANCHES)
    fitted = {(row.branch, row.pressure_MPa): row for row in table.rows}
    found = []
    for row in printed.rows:
        mine = fitted[row.branch, row.pressure_MPa]
        values = {e.name: e.value for e in mine.estimates}
        bound = tuple(e.name for e in mine.estimates if e.at_bound)
        found.append(Isobar(row.branch, row.pressure_MPa, row.values, values, bound, mine.rmse))
    return tuple(found)


def shared(record: Record) -> tuple[Shared, ...]:
    """Equation (1) fitted to all isobars of a branch at once, without F_t and with it."""
    found = []
    for effects in ((), ("bladder_elasticity",)):
        fits = fit_branches(Model.build("modified_chou_hannaford", effects), record, "separate")
        found += [Shared(branch, effects, one.values, one.rmse, one.max_error) for branch, one in fits.items()]
    return tuple(found)


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
