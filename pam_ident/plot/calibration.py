"""Stated probabilities against how often they were true."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from .style import BLUE, GREY, canvas, styled

if TYPE_CHECKING:
    from ..validation.calibration import Reliability

Z = 1.96
LEAST = 5e-4
"""Probabilities nearer to 0 or 1 are drawn here."""
TICKS = (0.001, 0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99, 0.999)


@dataclass(frozen=True)
class CalibrationData:
    """Bin by bin: mean stated probability, share that was true with its 95 % interval, number of statements."""

    stated: tuple[float, ...]
    true: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    n: tuple[int, ...]
    brier: float


def data(found: "Reliability") -> CalibrationData:
    """Points of the reliability diagram; intervals after Wilson 1927, JASA 22, 209–212."""
    rows = [(b.stated, b.true / b.n, *_wilson(b.true / b.n, b.n), b.n) for b in found.bins]
    stated, true, low, high, n = zip(*rows, strict=True) if rows else [()] * 5
    return CalibrationData(stated, true, low, high, n, found.brier)


def _wilson(share: float, n: int) -> tuple[float, float]:
    middle = (share + Z**2 / (2 * n)) / (1 + Z**2 / n)
    half = Z / (1 + Z**2 / n) * np.sqrt(share * (1 - share) / n + Z**2 / (4 * n**2))
    return float(max(middle - half, 0.0)), float(min(middle + half, 1.0))


@styled
def draw(found: "Reliability") -> Figure:
    """Reliability diagram over the odds, for most statements are near 0 or 1; on the curve they mean what they say."""
    shown = data(found)
    figure = canvas(4.0, 6.4)
    axes = figure.subplots()
    axes.set_xscale("logit")
    honest = 1.0 / (1.0 + np.exp(-np.linspace(-8.0, 8.0, 200)))
    axes.plot(honest, honest, color=GREY, linestyle="--", linewidth=1.0)
    places = np.clip(shown.stated, LEAST, 1.0 - LEAST)
    axes.vlines(places, shown.low, shown.high, color=BLUE, linewidth=1.2)
    axes.plot(places, shown.true, "o", color=BLUE, markersize=5.0)
    for x, n in zip(places, shown.n, strict=True):
        axes.annotate(str(n), (x, 1.06), ha="center", fontsize=8.0, color=GREY, annotation_clip=False)
    axes.set(xlim=(0.5 * LEAST, 1.0 - 0.5 * LEAST), ylim=(-0.03, 1.03))
    axes.set_xticks(TICKS, [f"{x:g}" for x in TICKS])
    axes.minorticks_off()
    axes.set_xlabel("stated probability (mean of the bin)")
    axes.set_ylabel("share truly hidden (95 % interval)")
    axes.set_title(f"{sum(shown.n)} statements, Brier score {shown.brier:.4f}", pad=18.0)
    return figure
