"""What each effect leaves in a standard virtual record: its force, what each law takes up of it, whom it resembles."""

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from matplotlib.figure import Figure

from pam_ident.core import Inputs
from pam_ident.diagnosis.dictionary import Slopes, grid, signature, slopes
from pam_ident.diagnosis.selection import TOO_FLAT
from pam_ident.effects import Effect
from pam_ident.fitting import fit
from pam_ident.fitting.solve import jacobian
from pam_ident.laws import catalogue as laws
from pam_ident.model import Model
from pam_ident.plot.style import BRANCH_COLOUR, GREY, canvas, styled, zero_line
from pam_ident.records import Record, read_record
from pam_ident.rig import Plan, Protocol, make_record, write_case

Array = np.ndarray
STANDARD = Protocol(warming_K=15.0, hold_s=(1.0, 10.0, 100.0), substeps=4)
SEED = 20
PLAIN_LAW = "modified_chou_hannaford"
"""The law whose leftovers the figures show: it has few parameters, and each of them means something."""
ALIKE = 0.8
"""Cosine of two signatures, the law's part taken out, from which they are listed as easily confused."""
POINTS = 1500


@dataclass(frozen=True)
class Around:
    """A law fitted to the standard record: its slopes, and an orthonormal basis (n, k) of what it can follow."""

    around: Slopes
    basis: Array

    def left(self, columns: Array) -> Array:
        """Columns (n, m) without what the law can follow by itself."""
        return columns - self.basis @ (self.basis.T @ columns)


@cache
def standard_record() -> Record:
    """A run of the virtual rig in which all levers are moved: five pressures, three speeds, holds of three lengths,
    nine cycles on each isobar, 15 K of warming. Nothing is hidden in it."""
    with tempfile.TemporaryDirectory() as folder:
        write_case(folder, make_record(Plan(SEED, protocol=STANDARD)))
        return read_record(f"{folder}/record.csv")


@cache
def around_law(law: str) -> Around:
    """The standard record under a law."""
    record, model = standard_record(), Model(laws()[law])
    found = fit(model, record)
    steep = jacobian(model, record.inputs, found.values, record.force)
    steep = steep / np.maximum(np.linalg.norm(steep, axis=0), 1e-300)
    left, sigma, _ = np.linalg.svd(steep, full_matrices=False)
    return Around(slopes(model, record.inputs, found.values), left[:, sigma > 1e-10])


def _columns(effect: Effect, inputs: Inputs, around: Slopes) -> list[Array]:
    """Signatures (n, k) of the simplest form over its grid, in N per unit."""
    form = effect.forms[0]
    found = [signature(form, inputs, point, around) for point in grid(form, inputs)]
    return [columns for columns in found if np.all(np.isfinite(columns)) and np.any(columns)]


def share_left(effect: Effect, law: str) -> float | None:
    """Share of the signature's rms that a law cannot follow, 0 to 1; None where the standard record cannot show it."""
    here, inputs = around_law(law), standard_record().inputs
    if effect.missing(inputs):
        return None
    shares = [np.linalg.norm(here.left(c)) / np.linalg.norm(c) for c in _columns(effect, inputs, here.around)]
    return float(max(shares)) if shares else None


@cache
def _bases(effect: Effect) -> tuple[Array, ...]:
    """Orthonormal bases (n, k) of what the plain law leaves of the signature, one for each point of its grid.

    None of an effect that the law takes up: the direction of the little that is left means nothing.
    """
    if (share_left(effect, PLAIN_LAW) or 0.0) < TOO_FLAT:
        return ()
    here = around_law(PLAIN_LAW)
    columns = _columns(effect, standard_record().inputs, here.around)
    return tuple(np.linalg.qr(here.left(one))[0] for one in columns)


def look_alikes(effect: Effect, others: Sequence[Effect]) -> list[tuple[str, float]]:
    """Effects whose signature points the same way as this one's, with the cosine (0 to 1), the closest first."""
    mine, found = _bases(effect), []
    for other in others:
        cosines = [np.linalg.norm(a.T @ b, 2) for a in mine for b in _bases(other)]
        if other.name != effect.name and cosines and max(cosines) >= ALIKE:
            found.append((other.name, min(float(max(cosines)), 1.0)))
    return sorted(found, key=lambda pair: -pair[1])


@styled
def draw(effect: Effect) -> Figure | None:
    """Force of the simplest form over contraction, at the highest pressure, and over time; None where it is not shown.

    Grey is the whole of it, the colours of the branches what the plain law leaves when it is fitted anew.
    """
    here, record = around_law(PLAIN_LAW), standard_record()
    inputs, form = record.inputs, effect.forms[0]
    if effect.missing(inputs):
        return None
    off = np.array([p.neutral + p.scale for p in form.linear]) - [p.neutral for p in form.linear]
    force = signature(form, inputs, {p.name: p.start for p in form.nonlinear}, here.around) @ off
    left = here.left(force[:, None])[:, 0]
    figure = canvas(3.4)
    by_contraction, by_time = figure.subplots(1, 2, sharey=True)
    assert inputs.time is not None
    top = np.flatnonzero(record.level == record.levels[-1])
    minutes = (inputs.time - inputs.time[0]) / 60.0
    for axes, x, rows in ((by_contraction, inputs.contraction, top), (by_time, minutes, np.arange(len(record)))):
        rows = rows[:: max(1, -(-len(rows) // POINTS))]
        axes.plot(x[rows], force[rows], ".", color=GREY, alpha=0.45, markersize=2.5, label="the effect")
        for sign, branch in ((1.0, "contraction"), (-1.0, "extension")):
            some = rows[inputs.direction[rows] == sign]
            label = f"left by the law, {branch}"
            axes.plot(x[some], left[some], ".", color=BRANCH_COLOUR[branch], markersize=3.0, label=label)
        zero_line(axes)
    by_contraction.set_xlabel(f"contraction ratio ε (1), at {record.levels[-1]:.1f} MPa")
    by_time.set_xlabel("time (min), all pressures")
    by_contraction.set_ylabel("force (N)")
    figure.legend(*by_contraction.get_legend_handles_labels(), loc="outside upper left", ncols=3, markerscale=3.0)
    return figure
