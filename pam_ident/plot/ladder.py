"""The falling error: rms over the rungs of a ladder, down to the noise floor."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from ..core.digits import newtons
from ..diagnosis.nouns import Ladder
from ..model import steps
from .style import BEHIND, BLUE, GREY, INK, VERMILION, WIDTH, canvas, styled

Array = np.ndarray


@dataclass(frozen=True)
class LadderData:
    """What each rung added, and its rms error in N on the fitted and on held-out data, shape (rungs,)."""

    names: tuple[str, ...]
    rmse: Array
    heldout: Array
    noise_floor: float


def data(ladder: Ladder) -> LadderData:
    """The numbers of a ladder, rung by rung."""
    return LadderData(
        steps(rung.fit.model for rung in ladder.rungs),
        np.array([rung.fit.rmse for rung in ladder.rungs]),
        np.array([rung.heldout_rmse for rung in ladder.rungs]),
        ladder.noise_floor,
    )


@styled
def draw(ladder: Ladder, names: Sequence[str] = (), width: float = WIDTH) -> Figure:
    """Both errors over the rungs on a logarithmic scale, the noise floor as a line; `names` of the rungs in place of
    the code's."""
    shown = data(ladder)
    figure = canvas(min(3.6, 0.48 * width), width)
    axes = figure.subplots()
    x = np.arange(len(shown.names))
    axes.axhline(shown.noise_floor, color=GREY, linestyle="--", linewidth=1.2)
    axes.plot(x, shown.rmse, marker="o", color=BLUE, linewidth=1.6, label="on the fitted data")
    held_out = {"color": VERMILION, "linewidth": 1.3, "linestyle": ":", "label": "on held-out data"}
    axes.plot(x, shown.heldout, marker="s", **held_out)
    for i, value in enumerate(shown.rmse):
        # Below and to the left: the curves fall from the left, and the held-out error lies above.
        axes.annotate(
            newtons(value), (i, value), (-7, -5), textcoords="offset points", ha="right", va="top", bbox=BEHIND
        )
    axes.set_yscale("log")
    everything = np.r_[shown.rmse, shown.heldout, shown.noise_floor]
    everything = everything[np.isfinite(everything) & (everything > 0)]
    axes.set_ylim(everything.min() / 1.5, everything.max() * 1.3)
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.set_xlim(-0.5, max(len(x) - 0.5, 0.5) + 0.15)
    if names:
        axes.set_xticks(x, list(names), fontsize=8.0 if len(x) < 4 else 7.0)
    else:
        tilt = {"rotation": 25, "ha": "right", "rotation_mode": "anchor"} if len(x) > 3 else {}
        axes.set_xticks(x, list(shown.names), fontsize=8.0, **tilt)
    place = {"xycoords": axes.get_yaxis_transform(), "textcoords": "offset points"}
    words = f"noise floor {newtons(shown.noise_floor)}"
    axes.annotate(words, (0.0, shown.noise_floor), (4, 3), fontsize=8.5, color=GREY, **place)
    axes.set_ylabel("rms error (N)")
    axes.grid(axis="x", visible=False)
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.2, labelcolor=INK)
    return figure
