"""Error along each coordinate of the test: small multiples of mean and rms."""

import math
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator

from ..diagnosis.nouns import Bin, Comparison
from .style import BLUE, SKY, small_multiples, styled, zero_line

Array = np.ndarray
AXES = {
    "pressure_MPa": "pressure (MPa)",
    "contraction": "contraction ratio ε (1)",
    "speed_mm_s": "speed of the stroke (mm/s)",
    "cycle": "cycle (number)",
    "time_s": "time (s)",
}


@dataclass(frozen=True)
class ErrorProfile:
    """Error along one coordinate: centres of the bins in the axis's unit, mean and rms in N, samples; each (bins,)."""

    key: str
    axis: str
    centre: Array
    mean: Array
    rms: Array
    n: Array


def data(comparison: Comparison) -> tuple[ErrorProfile, ...]:
    """A profile for each coordinate that the record varies: at least two bins."""
    found = []
    for key, axis in AXES.items():
        bins = comparison.by.get(key, ())
        if len(bins) < 2:
            continue
        middle = [_speed(b) if key == "speed_mm_s" else 0.5 * (b.low + b.high) for b in bins]
        mean, rms, n = (np.array(column) for column in zip(*((b.mean, b.rms, b.n) for b in bins), strict=True))
        found.append(ErrorProfile(key, axis, np.array(middle), mean, rms, n))
    return tuple(found)


def _speed(bin_: Bin) -> float:
    """The median speed that the bin's label gives, else the middle of the bin on a logarithmic scale."""
    try:
        return float(bin_.label.split()[0])
    except (ValueError, IndexError):
        return math.sqrt(bin_.low * bin_.high)


@styled
def draw(comparison: Comparison) -> Figure:
    """Mean error as points inside a band of ± rms around zero: a point at the band's edge is all systematic."""
    profiles = data(comparison)
    figure, grid = small_multiples(len(profiles), 3, 0.2, 2.2, sharey=True)
    for axes, profile in zip(grid.flat, profiles, strict=False):
        zero_line(axes)
        axes.fill_between(profile.centre, -profile.rms, profile.rms, color=SKY, alpha=0.3, linewidth=0.0)
        axes.plot(profile.centre, profile.mean, marker="o", markersize=4.0, color=BLUE, linewidth=1.2)
        axes.set_xlabel(profile.axis)
        if profile.key == "speed_mm_s":
            axes.set_xscale("log")
            axes.xaxis.set_major_locator(FixedLocator(list(profile.centre)))
            axes.xaxis.set_minor_locator(NullLocator())
            axes.set_xticklabels([f"{v:.2g}" for v in profile.centre])
        elif profile.key == "cycle" and len(profile.centre) <= 12:
            axes.set_xticks(profile.centre)
    for axes in grid[:, 0]:
        axes.set_ylabel("error (N)")
    return figure
