"""Several fitted laws against the measurement on one isobar (Figure 8 of the paper), a panel a branch."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from ..core.digits import newtons
from ..fitting import Fit
from .curves import by_isobar, model_curve, stride
from .style import BLUE, BRANCH_NAME, GREEN, GREY, INK, ORANGE, PURPLE, VERMILION, canvas, cloud, styled

Array = np.ndarray
STYLES = (
    (BLUE, "-"),
    (VERMILION, (0, (5, 2))),
    (GREEN, (0, (5, 2, 1, 2))),
    (PURPLE, (0, (1, 1.5))),
    (ORANGE, (0, (8, 2, 1, 2, 1, 2))),
)


@dataclass(frozen=True)
class LawCurve:
    """One law on the panel's isobar: contraction and force in N, (m,) each, and its rms error there in N."""

    label: str
    line: Array
    line_force: Array
    rmse: float


@dataclass(frozen=True)
class LawsPanel:
    """One branch of the isobar: measured points (n,), force in N, and the laws fitted to it."""

    pressure_MPa: float
    branch: str
    contraction: Array
    measured: Array
    laws: tuple[LawCurve, ...]


def label(fit: Fit) -> str:
    """The law with its effects, which are counted where there are several."""
    names = fit.model.labels
    law = fit.model.law.name + (", free geometry" if fit.model.free_geometry else "")
    return " + ".join([law, *names]) if len(names) < 2 else f"{law} + {len(names)} effects"


def data(fits: Sequence[Fit], pressure_MPa: float | None = None, limit: int = 600) -> tuple[LawsPanel, ...]:
    """A panel for each branch that a fit covers, on the isobar nearest to `pressure_MPa`, by default the highest.

    All fits are of one record; those of single branches appear on theirs alone.
    """
    record = fits[0].record
    wanted = record.levels[-1] if pressure_MPa is None else pressure_MPa
    level = record.levels[np.argmin(np.abs(record.levels - wanted))]
    covered = np.any([one.rows for one in fits], axis=0) & (record.level == level)
    groups = list(by_isobar(record, covered))
    step = stride([len(rows) for _, _, rows in groups], limit)
    panels = []
    for pressure, sign, rows in groups:
        laws = tuple(
            LawCurve(label(one), *model_curve(one, rows, sign), float(np.sqrt(np.mean(one.residual[rows] ** 2))))
            for one in fits
            if one.rows[rows].all()
        )
        shown = rows[::step]
        contraction = record.inputs.contraction[shown]
        panels.append(LawsPanel(pressure, BRANCH_NAME[sign], contraction, record.force[shown], laws))
    return tuple(panels)


@styled
def draw(fits: Sequence[Fit], pressure_MPa: float | None = None, limit: int = 600) -> Figure:
    """Measured points in grey, a colour and dash a law, its rms error on the isobar in the legend."""
    panels = data(fits, pressure_MPa, limit)
    styles = {name: STYLES[i % len(STYLES)] for i, name in enumerate(dict.fromkeys(map(label, fits)))}
    figure = canvas(5.0)
    grid = figure.subplots(1, len(panels), sharey=True, squeeze=False)[0]
    for axes, panel in zip(grid, panels, strict=True):
        cloud(axes, panel.contraction, panel.measured, GREY, 3.4, label="measured")
        for law in panel.laws:
            colour, dash = styles[law.label]
            name = law.label.replace(" + ", "\n+ ")  # no wider than its panel
            text = f"{name}: {newtons(law.rmse)} rms"
            axes.plot(law.line, law.line_force, color=colour, linestyle=dash, linewidth=1.6, label=text)
        axes.set_xlabel("contraction ratio ε (1)")
        legend = axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), labelcolor=INK, alignment="left")
        branch = "" if panel.branch == "static" else f", {panel.branch}"
        legend.set_title(f"{panel.pressure_MPa:.3g} MPa{branch}", {"weight": "bold"})
    grid[0].set_ylabel("force (N)")
    return figure
