"""Figures 7 to 10 of the paper, drawn from any record and fit, and those that a run of the leg leaves behind."""

import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from ..core import FitError, UsageError
from ..core.files import write_whole
from ..fitting import Fit, IsobarTable, fit, fit_isobars
from ..model import Model
from ..plot import coefficients, isobars, laws_compared, measured_against_model, to_svg
from .fit import FitAnswer

if TYPE_CHECKING:
    from ..leg.track import Track

STANDARDS = ("chou_hannaford", "modified_chou_hannaford")
"""Laws that every fit is shown beside, as in Figure 8."""
FRAMES = 25
"""Pictures a second in the animation, and postures along the stride."""


def paper_figures(answer: FitAnswer) -> dict[str, Figure]:
    """Figures by name: isobars (7), laws_compared (8), coefficients (9), measured_against_model (10).

    Figure 8 is of the highest isobar and of the branches that were fitted. Figure 9 shows the law without effects,
    isobar by isobar, and is left out where it has no parameters or no isobar has samples enough. Of several branches
    each has a figure 10 of its own, measured_against_model_BRANCH. Raises FitError where a law cannot be fitted at all.
    """
    figures = {"isobars": isobars.draw(answer.record), "laws_compared": laws_compared.draw(_laws(answer))}
    table = answer.isobars or _isobars(answer)
    if table is not None:
        figures["coefficients"] = coefficients.draw(table)
    for branch, one in answer.fits.items():
        name = "measured_against_model" + ("" if len(answer.fits) == 1 else f"_{branch}")
        figures[name] = measured_against_model.draw(one)
    return figures


def make_folder(path: str | Path) -> Path:
    """`path` as a folder that can be written to, made where it is missing. Raises UsageError."""
    path = Path(path)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"{path}: cannot be made a folder ({error.strerror}); name another folder") from None
    if not os.access(path, os.W_OK):
        raise UsageError(f"{path}: the folder cannot be written to; name another folder")
    return path


def write_figures(folder: str | Path, figures: Mapping[str, Figure]) -> list[Path]:
    """Write each figure as FOLDER/NAME.svg, whole or not at all; the files in order."""
    texts = {name: to_svg(figure) for name, figure in figures.items()}
    return [write_whole(Path(folder) / f"{name}.svg", text) for name, text in texts.items()]


def write_track(folder: str | Path, found: "Track") -> list[Path]:
    """Write the figures of tracking (the paper's 16), loop (13) and knee as SVG; of a prototype also leg.xml, pictures
    and an animation of the stride. Raises UsageError where MuJoCo cannot draw."""
    from ..plot import four_bar, loop_diagram, tracking  # the last brings JAX, which a fit's figures do not wait for

    folder = Path(folder)
    leg = found.loop.pair.leg
    figures = {"tracking": tracking.draw(found), "loop": loop_diagram.draw(), "four_bar": four_bar.draw(leg.knee)}
    paths = write_figures(folder, figures)
    if found.prototype:
        paths += _prototype(folder, found)
    return paths


def _prototype(folder: Path, found: "Track") -> list[Path]:
    from ..leg import mjcf
    from ..leg.control import SAMPLE_S
    from ..leg.loop import STEP_S
    from ..leg.prototype import Prototype
    from ..leg.render import animation, pictures

    leg = found.loop.pair.leg
    stride = Prototype(leg, found.course.gait, STEP_S, found.ground)
    every = round(1.0 / (FRAMES * SAMPLE_S))
    shown = found.motion[::every]
    paths = [write_whole(folder / "leg.xml", mjcf.write(leg, STEP_S, found.ground))]
    paths += pictures(stride, shown[:: max(len(shown) // 4, 1)][:4], folder)
    return [*paths, animation(stride, shown, folder / "gait.gif", 1.0 / FRAMES)]


def _laws(answer: FitAnswer) -> list[Fit]:
    """The standards and then the answer's own model, each fitted to the answer's branches."""
    own = next(iter(answer.fits.values())).model
    others = [model for model in map(Model.build, STANDARDS) if model != own]
    record = answer.record
    fits = [fit(model, record, record.branch_rows(branch)) for model in others for branch in answer.fits]
    return [*fits, *answer.fits.values()]


def _isobars(answer: FitAnswer) -> IsobarTable | None:
    model = replace(next(iter(answer.fits.values())).model, terms=())
    if not model.params:
        return None
    try:
        return fit_isobars(model, answer.record, tuple(answer.fits))
    except FitError:
        return None
