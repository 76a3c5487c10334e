"""What a run of the leg leaves behind: figures, and of the prototype its model and pictures."""

from pathlib import Path

from ..core.files import write_whole
from ..leg.track import Track
from ..plot import four_bar, loop_diagram, tracking
from .figures import write_figures

FRAMES = 25
"""Pictures a second in the animation, and postures along the stride."""


def write_track(folder: str | Path, found: Track) -> list[Path]:
    """Write the figures of tracking (the paper's 16), loop (13) and knee as SVG; of a prototype also leg.xml, pictures
    and an animation of the stride. Raises UsageError where MuJoCo cannot draw."""
    folder = Path(folder)
    leg = found.loop.pair.leg
    figures = {"tracking": tracking.draw(found), "loop": loop_diagram.draw(), "four_bar": four_bar.draw(leg.knee)}
    paths = write_figures(folder, figures)
    if found.prototype:
        paths += _prototype(folder, found)
    return paths


def _prototype(folder: Path, found: Track) -> list[Path]:
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
