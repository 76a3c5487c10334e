"""Pictures of the prototype without a screen: PNG files of postures, and a GIF of a motion."""

import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from ..core import UsageError
from .prototype import Angles, Prototype, mujoco

SIZE = (640, 760)
"""Width and height of a picture, pixels."""


def pictures(prototype: Prototype, angles: Iterable[Angles], folder: str | Path) -> list[Path]:
    """A PNG a posture, `leg_000.png` and on, in a folder that is made. Raises UsageError where nothing can be drawn."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for number, frame in enumerate(frames(prototype, angles)):
        paths.append(folder / f"leg_{number:03d}.png")
        Image.fromarray(frame).save(paths[-1])
    return paths


def animation(prototype: Prototype, angles: Sequence[Angles], path: str | Path, frame_s: float = 0.04) -> Path:
    """A GIF that repeats, a frame a posture, `frame_s` each. Raises UsageError where nothing can be drawn."""
    first, *rest = (
        Image.fromarray(frame).quantize(128, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
        for frame in frames(prototype, angles)
    )
    path = Path(path)
    first.save(path, save_all=True, append_images=rest, duration=round(1000 * frame_s), loop=0, optimize=True)
    return path


def frames(prototype: Prototype, angles: Iterable[Angles]) -> list[np.ndarray]:
    """Postures as pictures, (height, width, 3) of uint8 each; the prototype's own state is left alone."""
    drawn = []
    with _renderer(prototype.model) as renderer:
        for one in angles:
            renderer.update_scene(prototype.posed(one), camera="side")
            drawn.append(renderer.render().copy())
    return drawn


def _renderer(model: Any) -> Any:
    try:
        return mujoco().Renderer(model, height=SIZE[1], width=SIZE[0])
    except Exception as error:  # each backend of MuJoCo fails in a type of its own
        raise UsageError(
            f"no pictures: MuJoCo cannot draw here with MUJOCO_GL={os.environ.get('MUJOCO_GL')} ({error}); "
            "set MUJOCO_GL to egl, osmesa or glfw, whichever this machine has, before Python starts"
        ) from None
