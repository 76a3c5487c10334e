"""Figures for the prompt: pyplot holds them, so that a notebook shows them and `plt.show()` does."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def axes_of(draw: "Callable[..., Figure]", *what: Any) -> "Axes":
    """The first Axes of a figure; its `figure` has the others."""
    from matplotlib import pyplot

    from ..plot.style import figures_by

    with figures_by(pyplot.figure):
        return draw(*what).axes[0]
