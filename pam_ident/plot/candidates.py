"""What each candidate would leave of the error."""

import math
from dataclasses import dataclass

from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ..core.digits import newtons, probability
from ..diagnosis.nouns import Diagnosis
from ..schema.diagnosis import STATUS
from ..schema.diagnosis import candidates as likeliest
from .style import BEHIND, BLUE, GREY, INK, SKY, VERMILION, canvas, styled

BEYOND = 2.0
"""The scale ends at so many times the largest error on the fitted data, or before; of a held-out error beyond, which an
extrapolation may make as large as it likes, only the number stands there."""


@dataclass(frozen=True)
class Bar:
    """One candidate: errors after adding it in N, NaN where not computed; `note` says why there is no bar."""

    label: str
    probability: float
    rmse_after: float
    heldout: float
    selected: bool
    note: str


@dataclass(frozen=True)
class CandidatesData:
    """Candidates with the most likely first, then what the record cannot show; levels in N."""

    bars: tuple[Bar, ...]
    before: float
    noise_floor: float


def data(diagnosis: Diagnosis, limit: int = 16) -> CandidatesData:
    """At most `limit` candidates, then all that are absorbed or not excited."""
    likely = likeliest(diagnosis)[:limit]
    others = [s for s in diagnosis.ranking if s.status != "candidate"]
    bars = []
    for candidate in (*likely, *others):
        known = candidate.rmse_after is not None and candidate.status == "candidate"
        bars.append(
            Bar(
                candidate.label or candidate.effect,
                candidate.probability,
                _number(candidate.rmse_after) if known else math.nan,
                _number(candidate.heldout_rmse_after) if known else math.nan,
                candidate.effect in diagnosis.selected,
                "" if known else "not computed" if candidate.status == "candidate" else STATUS[candidate.status],
            )
        )
    return CandidatesData(tuple(bars), diagnosis.base.rmse, diagnosis.noise_floor)


def _number(value: float | None) -> float:
    return math.nan if value is None else value


@styled
def draw(diagnosis: Diagnosis, limit: int = 16) -> Figure:
    """A bar a candidate down to the error it leaves; selected ones strong, the rest of the list in grey words."""
    shown = data(diagnosis, limit)
    n = max(len(shown.bars), 1)
    figure = canvas(1.1 + 0.27 * n)
    axes = figure.subplots()
    after = [b.rmse_after for b in shown.bars if math.isfinite(b.rmse_after)]
    fitted = max([*after, shown.before, shown.noise_floor])
    heldout = [b.heldout for b in shown.bars if math.isfinite(b.heldout)]
    right = 1.04 * min(max([fitted, *heldout]), BEYOND * fitted)
    beside = {"transform": axes.get_yaxis_transform(), "va": "center"}
    for i, bar in enumerate(shown.bars):
        if bar.note:
            axes.text(0.008 * right, i, bar.note, va="center", fontsize=8.0, color=GREY, style="italic", bbox=BEHIND)
            continue
        axes.barh(i, bar.rmse_after, height=0.62, color=BLUE if bar.selected else SKY)
        if bar.heldout > right:
            told = f"{newtons(bar.heldout)} →"
            axes.text(0.992 * right, i, told, ha="right", va="center", fontsize=8.0, color=VERMILION, bbox=BEHIND)
        elif math.isfinite(bar.heldout):
            axes.plot([bar.heldout], [i], marker="D", markersize=4.5, color=VERMILION, linestyle="")
        weight = "bold" if bar.selected else "normal"
        axes.text(1.02, i, probability(bar.probability), fontsize=8.5, weight=weight, **beside)
    axes.text(1.02, -0.95, "probability", fontsize=8.0, color=GREY, **beside)
    axes.axvline(shown.before, color=INK, linewidth=1.2)
    axes.axvline(shown.noise_floor, color=GREY, linestyle="--", linewidth=1.2)
    axes.set_yticks(range(len(shown.bars)), [b.label for b in shown.bars])
    for tick, bar in zip(axes.get_yticklabels(), shown.bars, strict=True):
        tick.set_color(GREY if bar.note else INK)
        tick.set_fontweight("bold" if bar.selected else "normal")
    axes.set_ylim(n - 0.4, -0.6)
    axes.set_xlim(0.0, right)
    axes.set_xlabel("rms error left with this effect added (N)")
    axes.grid(axis="y", visible=False)
    axes.tick_params(axis="y", length=0)
    figure.legend(handles=_handles(shown), loc="outside upper left", ncols=5, columnspacing=1.2, handlelength=1.4)
    return figure


def _handles(shown: CandidatesData) -> list[Line2D | Patch]:
    return [
        Patch(color=BLUE, label="selected"),
        Patch(color=SKY, label="other candidate"),
        Line2D([], [], marker="D", color=VERMILION, linestyle="", markersize=4.5, label="on held-out data"),
        Line2D([], [], color=INK, linewidth=1.2, label=f"now, {newtons(shown.before)}"),
        Line2D([], [], color=GREY, linestyle="--", linewidth=1.2, label=f"noise floor, {newtons(shown.noise_floor)}"),
    ]
