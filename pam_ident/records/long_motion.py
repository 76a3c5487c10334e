"""The motion of a record on disk, followed piece by piece."""

from collections.abc import Callable

import numpy as np

from ..core import Array
from .columns_on_disk import STRETCH, Columns
from .motion import follow, long_pause
from .record import turns
from .roughness import NORMAL_MEDIAN, roughness

KINDS = {"branch": np.int8, "moving": np.bool_, "segment": np.int32, "stroke": np.int32, "turn": np.int32}
"""How columns are kept that are no floating-point numbers."""


def keep_motion(
    on_disk: Columns, n: int, length_mm: float, span: float, level: Callable[[int, int], Array], given: tuple[str, ...]
) -> None:
    """Find strokes, holds, cycles, segments and turns of `n` rows as `build_record` does, and keep each as a column
    (n,).

    `span` is the range of the motion in mm, `level` gives the nominal pressures of some rows, begin … end; `given`
    columns stand already.
    """

    def read(begin: int, end: int) -> tuple[Array, Array, Array]:
        x = on_disk.read("contraction", begin, end) * length_mm
        return on_disk.read("time", begin, end), x, level(begin, end)

    begin, turn, noise = 0, 0, noise_on_disk(on_disk, n, length_mm)
    pause = long_pause(on_disk.quantile("time", 0, n, 1, 0.95))
    for fresh, found in follow(n, read, noise, span, pause):
        end = begin + len(found.stroke)
        track = read(begin, end)[1]
        begins = turns(track, found.stroke, found.segment)
        begins[0] |= fresh and begin > 0
        count = turn + np.cumsum(begins)
        columns = {name: getattr(found, name) for name in ("velocity", "stroke_speed", "moving", "stroke", "segment")}
        columns |= {"turn": count, "branch": found.direction, "cycle": found.cycle}
        for name in columns.keys() - set(given):
            on_disk.append(name, columns[name].astype(KINDS.get(name, np.float64)))
        begin, turn = end, int(count[-1])


def noise_on_disk(on_disk: Columns, n: int, length_mm: float) -> float:
    """`position_noise` of the whole record in mm."""
    count = _keep_roughness(on_disk, n, length_mm, timed=True) or _keep_roughness(on_disk, n, length_mm, timed=False)
    middle = on_disk.quantile("roughness", 0, count, 0, 0.5)
    on_disk.drop("roughness")
    return middle / NORMAL_MEDIAN


def _keep_roughness(on_disk: Columns, n: int, length_mm: float, timed: bool) -> int:
    """Keep the roughness of the track, by the clock or as of even rows, as a column; how many numbers it has."""
    count = 0
    for begin in range(0, n, STRETCH):
        end = min(begin + STRETCH + 4, n)
        x = on_disk.read("contraction", begin, end) * length_mm
        rough = roughness(x, on_disk.read("time", begin, end) if timed else None)
        on_disk.append("roughness", rough)
        count += len(rough)
    return count
