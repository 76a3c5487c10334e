"""Knee tracking (Figure 16 of the paper): flexion wanted, reached, and the error, for PID and a ladder's rungs."""

from dataclasses import dataclass
from textwrap import wrap

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..leg.track import Track, Tracking
from ..model import steps
from .style import BEHIND, BLUE, GREEN, GREY, INK, ORANGE, VERMILION, canvas, styled, zero_line

Array = np.ndarray
DASHES = ("-", (0, (6, 2)), (0, (3, 1.5)), (0, (1, 1)))
COLOURS = (VERMILION, ORANGE, GREEN, BLUE)


@dataclass(frozen=True)
class TrackingData:
    """Time in s from the first sample shown and flexion wanted in degrees, (N,); runs by name; rms errors in degrees by
    rung, (rungs,), with the lower and upper end of their bands, NaN where there is none."""

    time: Array
    target: Array
    runs: dict[str, Tracking]
    rungs: tuple[str, ...]
    rms: Array
    band: Array
    pid_rms: float


def data(track: Track) -> TrackingData:
    """Plain PID tuned by hand and automatically, the first rung and the last."""
    shown = {"PID, tuned by hand": track.pid_by_hand, "PID, tuned automatically": track.pid}
    ends = dict.fromkeys((0, len(track.rungs) - 1)) if track.rungs else {}
    for k in ends:
        shown[f"PID + {_name(track, k)}"] = track.rungs[k].tracking
    bands = [(np.nan, np.nan) if rung.band is None else rung.band for rung in track.rungs]
    return TrackingData(
        track.pid.time - track.pid.time[0],
        track.pid.target,
        shown,
        steps(rung.muscle.model for rung in track.rungs),
        np.array([rung.tracking.rms_deg for rung in track.rungs]),
        np.array(bands).reshape(-1, 2),
        track.pid.rms_deg,
    )


def _name(track: Track, k: int) -> str:
    model = track.rungs[k].muscle.model
    count = len(model.labels)
    return model.law.title if count == 0 else f"{model.law.title} with {count} effect{'s' if count > 1 else ''}"


@styled
def draw(track: Track) -> Figure:
    """Angles above, errors below them; beside them the rms error of every rung with its band."""
    shown = data(track)
    figure = canvas(6.4, 11.0)
    grid = figure.add_gridspec(2, 2, width_ratios=(1.5, 1.0))
    above = figure.add_subplot(grid[0, 0])
    below = figure.add_subplot(grid[1, 0], sharex=above)
    above.plot(shown.time, shown.target, color=INK, linewidth=2.4, alpha=0.35, label="wanted")
    zero_line(below)
    for (name, run), colour, dash in zip(shown.runs.items(), COLOURS, DASHES, strict=False):
        above.plot(shown.time, run.flexion, color=colour, linestyle=dash, linewidth=1.3)
        below.plot(shown.time, run.error, color=colour, linestyle=dash, linewidth=1.3, label=name)
    above.set_ylabel("knee flexion (°)")
    above.legend(loc="upper left")
    above.tick_params(labelbottom=False)
    below.set_xlabel("time (s)")
    below.set_ylabel("error, wanted − reached (°)")
    below.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2, labelcolor=INK)
    _ladder(figure.add_subplot(grid[:, 1]), shown)
    return figure


def _ladder(axes: Axes, shown: TrackingData) -> None:
    y = np.arange(len(shown.rungs))
    axes.axvline(shown.pid_rms, color=VERMILION, linestyle="--", linewidth=1.2)
    axes.text(shown.pid_rms, -0.62, "plain PID  ", color=VERMILION, ha="right", va="center", fontsize=8.5)
    axes.hlines(y, shown.band[:, 0], shown.band[:, 1], color=BLUE, linewidth=5.0, alpha=0.3)
    axes.plot(shown.rms, y, marker="o", color=BLUE, linewidth=1.4)
    for value, place_y in zip(shown.rms, y, strict=True):
        axes.annotate(
            f"{value:.2f}°", (value, place_y), (6, -5), textcoords="offset points", va="top", color=INK, bbox=BEHIND
        )
    axes.set_yticks(y, ["\n".join(wrap(name, 28)) for name in shown.rungs], fontsize=7.5)
    axes.set_ylim(len(shown.rungs) - 0.4, -0.9)
    axes.set_xlim(0.0, 1.15 * max(shown.pid_rms, float(np.max(shown.rms, initial=0.0))))
    axes.set_xlabel("rms tracking error (°)")
    axes.set_title("PID + feed-forward by each step", color=GREY)
    axes.grid(axis="y", visible=False)
