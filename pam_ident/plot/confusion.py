"""What was taken for what: hidden families against named ones."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from .style import GREEN, GREY, INK, VERMILION, canvas, styled

LAST = ("unknown", "nothing")


@dataclass(frozen=True)
class ConfusionData:
    """`counts` (hidden, named) over the same labels: families by name, then an unknown, then nothing."""

    labels: tuple[str, ...]
    counts: np.ndarray


def data(confusion: Mapping[tuple[str, str], int]) -> ConfusionData:
    """Counts by (hidden, named) as a square matrix."""
    seen = {name for pair in confusion for name in pair}
    labels = (*sorted(seen - set(LAST)), *(name for name in LAST if name in seen))
    counts = np.zeros((len(labels), len(labels)), int)
    for (hidden, named), n in confusion.items():
        counts[labels.index(hidden), labels.index(named)] += n
    return ConfusionData(labels, counts)


@styled
def draw(confusion: Mapping[tuple[str, str], int]) -> Figure:
    """The matrix in numbers: found in green, taken for something else in red, the deeper the more of its row."""
    shown = data(confusion)
    n = len(shown.labels)
    figure = canvas(1.9 + 0.36 * n, max(2.2 + 0.36 * n, 5.0))
    axes = figure.subplots()
    rows = np.maximum(shown.counts.sum(axis=1), 1)
    words = [label.replace("_", " ") for label in shown.labels]
    for i, j in np.argwhere(shown.counts > 0):
        share = shown.counts[i, j] / rows[i]
        colour = GREEN if i == j else VERMILION
        corners = [j - 0.5, j + 0.5, j + 0.5, j - 0.5], [i - 0.5, i - 0.5, i + 0.5, i + 0.5]
        axes.fill(*corners, color=colour, alpha=0.15 + 0.45 * share, linewidth=0)
        axes.text(j, i, str(shown.counts[i, j]), ha="center", va="center", color=INK, fontsize=9.0)
    axes.set_xticks(range(n), words, rotation=45, ha="right", rotation_mode="anchor")
    axes.set_yticks(range(n), words)
    axes.set(xlim=(-0.5, n - 0.5), ylim=(n - 0.5, -0.5), aspect="equal")
    axes.set_xlabel("named")
    axes.set_ylabel("hidden")
    axes.grid(False)
    axes.tick_params(length=0, colors=GREY, labelcolor=INK)
    axes.set_title(f"{int(np.trace(shown.counts))} of {int(shown.counts.sum())} named as what they are")
    return figure
