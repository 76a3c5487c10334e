"""The control loop as a diagram (Figure 13 of the paper)."""

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

from .style import BLUE, GREY, INK, canvas, styled

# name → (centre x, centre y, width, text)
BOXES: dict[str, tuple[float, float, float, str]] = {
    "gait": (0.9, 2.0, 1.3, "gait\nφ wanted"),
    "pid": (3.6, 2.0, 1.3, "PID\n5 ms"),
    "ahead": (3.6, 3.3, 2.3, "inverse of the\nfitted model"),
    "valves": (6.9, 2.0, 1.3, "pressure\nvalves"),
    "muscles": (8.9, 2.0, 1.7, "two muscles\nF1, F2"),
    "leg": (11.3, 2.0, 1.7, "sprocket,\nfour-bar, leg"),
    "sensor": (6.6, 0.6, 1.7, "angle sensor\n12 bit"),
}
SUMS = {"error": (2.2, 2.0), "split": (5.1, 2.0)}
HEIGHT = 0.78


@styled
def draw() -> Figure:
    """Blocks and signals of a leg under PID with feed-forward."""
    figure = canvas(3.2, 11.0)
    axes = figure.subplots()
    axes.set_axis_off()
    axes.set_xlim(0.0, 13.1)
    axes.set_ylim(0.0, 3.9)
    axes.set_aspect("equal")
    for x, y, width, text in BOXES.values():
        corner, round_ = (x - width / 2, y - HEIGHT / 2), "round,pad=0.0,rounding_size=0.08"
        look = {"facecolor": "white", "edgecolor": BLUE, "linewidth": 1.3}
        axes.add_patch(FancyBboxPatch(corner, width, HEIGHT, boxstyle=round_, **look))
        axes.text(x, y, text, ha="center", va="center", fontsize=8.5)
    for x, y in SUMS.values():
        axes.plot(x, y, "o", color=BLUE, markersize=13, markerfacecolor="white", markeredgewidth=1.3)
        axes.text(x, y, "+", ha="center", va="center", fontsize=10)
    _signals(axes)
    return figure


def _signals(axes: Axes) -> None:
    arrow = {"arrowstyle": "-|>", "color": GREY, "linewidth": 1.2, "shrinkA": 0, "shrinkB": 0}
    row = [(1.55, 2.03), (2.37, 2.95), (4.25, 4.93), (5.27, 6.25), (7.55, 8.05), (9.75, 10.45), (12.15, 12.95)]
    for begin, end in row:
        axes.annotate("", (end, 2.0), (begin, 2.0), arrowprops=arrow)
    words = ((5.74, "p wanted"), (7.8, "p"), (10.1, "torque"), (12.5, "φ"))
    for x, word in words:
        axes.text(x, 2.1, word, ha="center", va="bottom", fontsize=7.5, color=INK)
    axes.text(2.66, 2.1, "error", ha="center", va="bottom", fontsize=7.5)
    axes.text(4.58, 2.1, "±Δp", ha="center", va="bottom", fontsize=7.5)
    for path in (((0.9, 2.39), (0.9, 3.3), (2.45, 3.3)), ((4.75, 3.3), (5.1, 3.3), (5.1, 2.17))):
        axes.plot(*zip(*path[:-1], strict=True), color=GREY, linewidth=1.2)
        axes.annotate("", path[-1], path[-2], arrowprops=arrow)
    axes.plot((12.5, 12.5), (2.0, 0.6), color=GREY, linewidth=1.2)
    axes.annotate("", (7.45, 0.6), (12.5, 0.6), arrowprops=arrow)
    axes.plot((5.75, 2.2), (0.6, 0.6), color=GREY, linewidth=1.2)
    axes.annotate("", (2.2, 1.83), (2.2, 0.6), arrowprops=arrow)
    axes.text(2.08, 1.62, "−", ha="right", va="center", fontsize=10)
