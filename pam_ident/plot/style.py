"""How all figures look, and the few helpers they share."""

import io
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import wraps
from typing import Any, ParamSpec

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

Array = np.ndarray
P = ParamSpec("P")

# Okabe & Ito 2008, readable with every common colour blindness.
BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
YELLOW, BLUE, VERMILION, PURPLE = "#F0E442", "#0072B2", "#D55E00", "#CC79A7"
INK, GREY, FAINT, BROWN, LILAC = "#1f2933", "#6b7280", "#d5dae1", "#8c510a", "#8b8bd9"
BRANCH_COLOUR = {"contraction": BLUE, "extension": VERMILION, "static": BLUE}
BRANCH_DASH = {"contraction": "-", "extension": (0, (5, 2)), "static": "-"}
BRANCH_MARK = {"contraction": "o", "extension": "^", "static": "o"}
BRANCH_NAME = {1.0: "contraction", -1.0: "extension", 0.0: "static"}
BEHIND: dict[str, Any] = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}
"""A white ground for words that stand on lines."""
WIDTH = 7.2
"""Width of every figure in inches."""

RC: dict[Any, Any] = {
    "font.family": "sans-serif",
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 9.0,
    "axes.labelcolor": INK,
    "axes.edgecolor": GREY,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.unicode_minus": True,
    "grid.color": "#e5e8ec",
    "grid.linewidth": 0.7,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "text.color": INK,
    "text.parse_math": False,  # names of effects and units are text, never markup
    "xtick.color": GREY,
    "ytick.color": GREY,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "svg.fonttype": "none",
    "svg.hashsalt": "pam-ident",
}


def styled(draw: Callable[P, Figure]) -> Callable[P, Figure]:
    """Run a drawing function under the house style, and put matplotlib's settings back afterwards."""

    @wraps(draw)
    def inside(*args: P.args, **kwargs: P.kwargs) -> Figure:
        with matplotlib.rc_context(RC):
            return draw(*args, **kwargs)

    return inside


_maker: ContextVar[Callable[..., Figure]] = ContextVar("pam_ident_figures", default=Figure)


@contextmanager
def figures_by(maker: Callable[..., Figure]) -> Iterator[None]:
    """Figures drawn inside are made by `maker`, such as pyplot's, which holds them to be shown."""
    token = _maker.set(maker)
    try:
        yield
    finally:
        _maker.reset(token)


def canvas(height: float, width: float = WIDTH) -> Figure:
    """An empty figure of `width` × `height` inches whose parts make room for one another."""
    return _maker.get()(figsize=(width, height), layout="constrained")


def small_multiples(panels: int, most: int, head: float, each: float, sharey: bool = False) -> tuple[Figure, Array]:
    """A figure of `head` + `each` inches a row, at most `most` panels in each, and its axes, shape (rows, columns)."""
    columns = min(max(panels, 1), most)
    rows = max(-(-panels // columns), 1)
    figure = canvas(head + each * rows)
    grid = figure.subplots(rows, columns, squeeze=False, sharey=sharey)
    for axes in grid.flat[panels:]:
        axes.set_axis_off()
    return figure, grid


def cloud(axes: Axes, x: Array, y: Array, colour: str, size: float, alpha: float = 0.5, **more: Any) -> None:
    """Samples (n,) as pale marks without an edge."""
    look = {"linestyle": "", "marker": "o", "markersize": size, "markeredgewidth": 0.0, "color": colour, "alpha": alpha}
    axes.plot(x, y, **look | more)


def zero_line(axes: Axes) -> None:
    """A thin line at zero error."""
    axes.axhline(0.0, color=GREY, linewidth=0.9, zorder=1.5)


def thin(n: int, limit: int) -> Array:
    """At most `limit` of n sample numbers, evenly spread, both ends kept; shape (≤ limit,)."""
    if n <= limit:
        return np.arange(n)
    return np.unique(np.linspace(0, n - 1, limit).round().astype(int))


def running_mean(values: Array, window: int) -> Array:
    """Mean over `window` (odd) samples around each one, fewer at the ends; shape as `values` (n,)."""
    half = max(int(window), 1) // 2
    total = np.r_[0.0, np.cumsum(values)]
    n = len(values)
    low, high = np.maximum(np.arange(n) - half, 0), np.minimum(np.arange(n) + half + 1, n)
    return (total[high] - total[low]) / (high - low)


def spread(places: Array, gap: float) -> Array:
    """The places (n,) moved apart until neighbours are at least `gap` apart, their order and mean kept."""
    order = np.argsort(places, kind="stable")
    moved = places[order].astype(float)
    for _ in range(200):
        short = gap - np.diff(moved)
        if not np.any(short > 1e-9 * max(gap, 1.0)):
            break
        push = np.where(short > 0, short / 2.0, 0.0)
        moved[:-1] -= push
        moved[1:] += push
    out = np.empty_like(moved)
    out[order] = moved
    return out


def signed(value: float) -> str:
    """A number of two to three digits with its sign, `0` for what vanishes, in a true minus sign."""
    if abs(value) < 5e-3:
        return "0"
    digits = 0 if abs(value) >= 10 else 1 if abs(value) >= 1 else 2
    return f"{value:+.{digits}f}".replace("-", "−")


def to_svg(figure: Figure) -> str:
    """The figure as SVG text, the same for the same figure: no date, fixed ids.

    Text stays text, so a letter that matplotlib's font lacks is no loss: the viewer has fonts of its own.
    """
    with matplotlib.rc_context(RC), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from")
        out = io.StringIO()
        figure.savefig(out, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    return out.getvalue()


def to_png(figure: Figure, dpi: int = 120) -> bytes:
    """The figure as PNG bytes."""
    with matplotlib.rc_context(RC):
        out = io.BytesIO()
        figure.savefig(out, format="png", dpi=dpi, metadata={"Software": None})
    return out.getvalue()
