"""Heat map of the mean error over pressure and contraction, a panel a branch."""

from dataclasses import dataclass

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from ..core.digits import newtons, percent
from ..diagnosis.nouns import Comparison
from .style import BLACK, BRANCH_NAME, INK, canvas, signed, styled

Array = np.ndarray
COLOURS = "PuOr_r"


@dataclass(frozen=True)
class FailureMap:
    """`mean` and `rms` (N), `share` (of the squared error, 0 to 1) and the samples `n` in each cell, all of shape
    (branches, pressures, cells); NaN where n is 0.

    `pressures` in MPa; `edges` (cells + 1,) are contraction ratios. `limit` is the colour scale's end in N; `marked`
    are the (branch, pressure, cell) indices of the worst cells.
    """

    branches: tuple[str, ...]
    pressures: Array
    edges: Array
    mean: Array
    rms: Array
    share: Array
    n: Array
    limit: float
    marked: tuple[tuple[int, int, int], ...]


@dataclass(frozen=True)
class Cell:
    """The numbers of one cell at (branch, pressure, contraction cell): pressure in MPa, interval of contraction ratio,
    samples, mean and rms error in N, share of the squared error."""

    place: tuple[int, int, int]
    branch: str
    pressure_MPa: float
    contraction: tuple[float, float]
    n: int
    mean: float
    rms: float
    share: float

    @property
    def gid(self) -> str:
        """Id of the cell in the drawing."""
        return "cell-" + "-".join(map(str, self.place))

    @property
    def text(self) -> str:
        """The numbers in one line."""
        low, high = (round(end, 4) + 0.0 for end in self.contraction)
        branch = "" if self.branch == "static" else f"{self.branch}, "
        sign = "+" if self.mean > 0 else ""
        text = (
            f"{branch}{self.pressure_MPa:.3g} MPa, ε {low:.4g} to {high:.4g}: mean error {sign}{newtons(self.mean)}, "
            f"rms {newtons(self.rms)}, {percent(self.share)} of the squared error, n = {self.n}"
        )
        return text.replace("-", "−")


def data(comparison: Comparison) -> FailureMap:
    """The map of a comparison; marked are those of its worst cells that hold at least 1 % of the squared error."""
    marked = []
    for region in comparison.worst:
        b = comparison.branches.index(region.branch)
        p = int(np.argmin(np.abs(comparison.pressures - region.pressure_MPa)))
        c = int(np.argmin(np.abs(comparison.edges[:-1] - region.contraction[0])))
        if region.share >= 0.01:
            marked.append((b, p, c))
    largest = float(np.nanmax(np.abs(comparison.mean)))
    return FailureMap(
        comparison.branches,
        comparison.pressures,
        comparison.edges,
        comparison.mean,
        comparison.rms,
        comparison.share,
        _samples(comparison),
        largest if largest > 0 else 1.0,
        tuple(marked),
    )


def _samples(comparison: Comparison) -> Array:
    """Samples in each cell, the cells cut as the comparison cuts them."""
    fit, edges = comparison.fit, comparison.edges
    inputs, level = fit.record.inputs, fit.record.level
    branch = np.array([BRANCH_NAME[sign] for sign in inputs.direction])
    cell = np.clip(np.searchsorted(edges, inputs.contraction, side="right") - 1, 0, len(edges) - 2)
    n = np.zeros(comparison.mean.shape, int)
    for b, name in enumerate(comparison.branches):
        mine = fit.rows & (branch == name)
        np.add.at(n[b], (np.searchsorted(comparison.pressures, level[mine]), cell[mine]), 1)
    return n


def cells(shown: FailureMap) -> tuple[Cell, ...]:
    """Every cell that holds samples, by branch, then pressure from high to low, then contraction."""
    found = []
    for b, name in enumerate(shown.branches):
        for p, c in sorted(np.argwhere(shown.n[b] > 0).tolist(), key=lambda pc: (-pc[0], pc[1])):
            ends = (float(shown.edges[c]), float(shown.edges[c + 1]))
            errors = (float(one[b, p, c]) for one in (shown.mean, shown.rms, shown.share))
            found.append(Cell((b, p, c), name, float(shown.pressures[p]), ends, int(shown.n[b, p, c]), *errors))
    return tuple(found)


def tips(comparison: Comparison) -> dict[str, str]:
    """The numbers of each cell by its id in the drawing, for a pointer to bring up."""
    return {cell.gid: cell.text for cell in cells(data(comparison))}


@styled
def draw(comparison: Comparison) -> Figure:
    """Mean error in each cell as colour and number; the worst cells framed, with their share of the squared error."""
    shown = data(comparison)
    rows = len(shown.pressures)
    height = min(max(0.36 * rows, 1.0), 6.0)
    figure = canvas(0.9 + len(shown.branches) * (height + 0.35))
    panels = figure.subplots(len(shown.branches), 1, sharex=True, squeeze=False)[:, 0]
    norm = Normalize(-shown.limit, shown.limit)
    colours = matplotlib.colormaps[COLOURS].with_extremes(bad="#f3f4f6")
    mesh = None
    places = cells(shown)
    for b, axes in enumerate(panels):
        mesh = axes.pcolormesh(
            np.ma.masked_invalid(shown.mean[b]), cmap=colours, norm=norm, edgecolors="white", linewidth=0.8
        )
        _numbers(axes, shown, b, colours, norm, 72.0 * height / rows)
        for one in places:
            if one.place[0] == b:  # nothing to see, but a pointer finds it
                corner = (one.place[2], one.place[1])
                axes.add_patch(Rectangle(corner, 1, 1, fill=False, linewidth=0.0, zorder=5, gid=one.gid))
        axes.set_title("" if shown.branches[b] == "static" else shown.branches[b])
        axes.set_yticks(np.arange(rows) + 0.5, [f"{p:.3g}" for p in shown.pressures])
        axes.set_ylabel("pressure (MPa)")
        axes.grid(False)
        axes.tick_params(length=0)
        axes.spines[:].set_visible(False)
    every = 1 if len(shown.edges) <= 12 else 2
    ticks = np.arange(len(shown.edges))[::every]
    panels[-1].set_xticks(ticks, [f"{round(e, 3) + 0.0:.3f}".replace("-", "−") for e in shown.edges[ticks]])
    panels[-1].set_xlabel("contraction ratio ε (1), cell edges")
    assert mesh is not None
    bar = figure.colorbar(mesh, ax=list(panels), pad=0.01, aspect=30)
    bar.set_label("mean error, measured − model (N)")
    bar.outline.set_visible(False)  # type: ignore[operator]
    bar.solids.set(rasterized=False, edgecolor="face")  # type: ignore[union-attr]
    return figure


def is_dark(colour: tuple[float, float, float, float]) -> bool:
    """Whether words on a colour, red to opacity from 0 to 1, must be white."""
    red, green, blue, _ = colour
    return 0.299 * red + 0.587 * green + 0.114 * blue < 0.5


def _numbers(axes: Axes, shown: FailureMap, branch: int, colours: Colormap, norm: Normalize, room: float) -> None:
    """The mean in each cell; in marked ones a frame and the share below. `room` is a cell's height in points."""
    cells = shown.mean.shape[2]
    size = float(np.clip(min(0.42 * room, 95.0 / cells), 4.5, 8.5))
    for p, c in np.argwhere(np.isfinite(shown.mean[branch])):
        value = float(shown.mean[branch, p, c])
        mark = (branch, p, c) in shown.marked
        text = signed(value) + (f"\n{percent(shown.share[branch, p, c])}" if mark else "")
        ink = "white" if is_dark(colours(norm(value))) else INK
        look = {"fontsize": size, "weight": "bold" if mark else "normal", "linespacing": 1.05, "color": ink}
        axes.text(c + 0.5, p + 0.5, text, ha="center", va="center", **look)
        if mark:
            axes.add_patch(Rectangle((c, p), 1, 1, fill=False, edgecolor=BLACK, linewidth=1.6, clip_on=False))
