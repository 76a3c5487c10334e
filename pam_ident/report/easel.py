"""What a page is put together from: parts with text, figures and tables."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from ..fitting import Fit
from .tables import PageTable

if TYPE_CHECKING:
    from bokeh.models import Column

    from ..live.record import Figures


@dataclass(frozen=True)
class Picture:
    """A figure with a name that no other on the page has, a label that is read out, and a caption.

    `tips` are texts by the ids of parts of the figure, shown where a pointer rests on them; `switches` words by the ids
    of parts that can be switched off, each id ending in its number from 1. `live` is the same to zoom and to point at.
    """

    name: str
    figure: Figure
    label: str
    caption: str
    tips: Mapping[str, str] = field(default_factory=dict)
    switches: Mapping[str, str] = field(default_factory=dict)
    live: "Column | None" = None


@dataclass(frozen=True)
class Part:
    """A heading with, in this order, text, facts, figures, tables and notes; `id` is its anchor.

    `steps` are parts of which a screen shows one at a time, each under a short name, and paper all. What follows an
    `opening` on a page is folded; its first picture is the largest.
    """

    id: str
    heading: str
    text: tuple[str, ...] = ()
    pictures: tuple[Picture, ...] = ()
    tables: tuple[PageTable, ...] = ()
    notes: tuple[str, ...] = ()
    badge: tuple[str, str] | None = None
    facts: tuple[tuple[str, str], ...] = ()
    steps: tuple[tuple[str, "Part"], ...] = ()
    opening: bool = False


@dataclass
class Easel:
    """Gives a record's figures names of their own; `points` is the most points of a cloud, `live` what can be zoomed
    into where a page may hold that."""

    prefix: str
    points: int
    live: "Figures | None" = None
    count: int = field(default=0, init=False)

    def hang(
        self,
        figure: Figure,
        label: str,
        caption: str,
        tips: Mapping[str, str] | None = None,
        switches: Mapping[str, str] | None = None,
        live: "Column | None" = None,
    ) -> Picture:
        """The figure under the next free name."""
        self.count += 1
        return Picture(f"{self.prefix}f{self.count}", figure, label, caption, tips or {}, switches or {}, live)


def live(before: Fit, after: Fit | None, samples: int) -> "Figures | None":
    """What can be zoomed into of two fits of a record, with so many samples; nothing without any."""
    if not samples:
        return None
    from ..live.record import Figures  # Bokeh takes half a second, and is not everywhere

    return Figures(before, after, samples)
