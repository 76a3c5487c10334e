"""The four-bar knee over its range: postures with the path of the instantaneous centre, and the sprocket's ratio."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..leg.four_bar import FourBar
from .style import BLUE, FAINT, GREEN, GREY, INK, ORANGE, VERMILION, canvas, styled

Array = np.ndarray
RANGE_DEG = (-5.0, 75.0)
POSTURES_DEG = (0.0, 25.0, 50.0, 75.0)


@dataclass(frozen=True)
class Drawn:
    """One posture: the pivots A, B on the thigh and C (crank), D (rocker) on the shank, (4,) complex in mm."""

    flexion_deg: float
    pivots: Array


@dataclass(frozen=True)
class FourBarData:
    """Flexion in degrees with the instantaneous centre (complex, mm) and ds/dφ, (n,) each; some postures.

    Places are x forward, y up, from the straight knee's origin in the thigh's frame.
    """

    flexion_deg: Array
    centre: Array
    ratio: Array
    postures: tuple[Drawn, ...]


def data(knee: FourBar, postures_deg: Sequence[float] = POSTURES_DEG, n: int = 161) -> FourBarData:
    """The linkage over RANGE_DEG."""
    flexion = np.linspace(*RANGE_DEG, n)
    found = knee.at(np.radians(flexion))
    drawn = []
    for degrees in postures_deg:
        one = knee.at(np.radians(degrees))
        ends = (knee.crank_thigh + one.crank[0], knee.rocker_thigh + one.rocker[0])
        drawn.append(Drawn(degrees, 1e3 * np.array([knee.crank_thigh, knee.rocker_thigh, *ends])))
    return FourBarData(flexion, 1e3 * found.centre, found.ratio, tuple(drawn))


@styled
def draw(knee: FourBar, postures_deg: Sequence[float] = POSTURES_DEG) -> Figure:
    """Left the linkage in the thigh's frame, later postures stronger; right the sprocket's turn by the knee's."""
    shown = data(knee, postures_deg)
    figure = canvas(4.4)
    left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.15))
    last = len(shown.postures)
    for number, posture in enumerate(shown.postures, 1):
        _posture(left, posture, 0.25 + 0.75 * number / last, number == last)
    centre = np.real(shown.centre), np.imag(shown.centre)
    left.plot(*centre, color=VERMILION, linewidth=1.8, label="instantaneous centre")
    left.margins(0.12)
    left.set_aspect("equal", adjustable="datalim")
    left.set_xlabel("forward (mm)")
    left.set_ylabel("up (mm)")
    left.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, labelcolor=INK)
    right.plot(shown.flexion_deg, shown.ratio, color=BLUE, linewidth=1.8)
    right.set_xlabel("knee flexion φ (°)")
    right.set_ylabel("sprocket's turn by the knee's, ds/dφ (1)")
    right.set_xlim(*RANGE_DEG)
    right.set_ylim(0.0, 1.1 * float(shown.ratio.max()))
    return figure


def _posture(axes: Axes, posture: Drawn, strength: float, named: bool) -> None:
    a, b, c, d = posture.pivots
    if named:
        _link(axes, a, b, INK, 1.0, "thigh")
    for start, end, colour, word in ((a, c, ORANGE, "crank"), (b, d, GREEN, "rocker"), (c, d, GREY, "shank")):
        _link(axes, start, end, colour, strength, word if named else None)
    out = c + 2.6 * (c - a) / abs(c - a)
    axes.annotate(f"{posture.flexion_deg:g}°", (out.real, out.imag), ha="center", va="center", fontsize=8.0, color=INK)


def _link(axes: Axes, start: complex, end: complex, colour: str, strength: float, label: str | None) -> None:
    pins = {"marker": "o", "markersize": 4.5, "markeredgecolor": INK, "markerfacecolor": FAINT, "markeredgewidth": 0.8}
    ends = [start.real, end.real], [start.imag, end.imag]
    axes.plot(*ends, color=colour, alpha=strength, linewidth=2.2, label=label, **pins)
