"""A story becomes a page."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from ..live import available
from . import tables
from .easel import Part, Picture
from .parts import parts
from .story import Story
from .svg import embed
from .words import plain, together

if TYPE_CHECKING:
    from ..live.page import Inline

MOST_POINTS, FEWEST_POINTS = 1500, 200

Chapters = Sequence[tuple[str, str, tuple[Part, ...]]]


def render(story: Story, live: bool = True) -> str:
    """One HTML file as text: nothing loaded from anywhere, every text escaped.

    Where Bokeh is installed and `live`, figures can be zoomed into and pointed at; else there is no script.
    """
    return page(story.title, chapters(story, live and available()), story.provenance)


def page(title: str, records: Chapters, provenance: Mapping[str, object]) -> str:
    """One HTML file as text, a chapter for each group of parts; `provenance` as in a Story."""
    return (
        environment()
        .get_template("report.html.j2")
        .render(
            title=title,
            records=records,
            live=inlined(records),
            provenance=tables.provenance(provenance),
            command=Markup.escape(plain(str(provenance.get("command", "")))),  # to be copied as it is
        )
    )


def chapters(story: Story, live: bool = False) -> Chapters:
    """Anchor, name and parts of every record.

    The more records there are, the fewer points a figure shows, so that a page stays below 3 MB. What can be zoomed
    into shows more.
    """
    points = max(MOST_POINTS * 3 // max(len(story.sections), 3), FEWEST_POINTS)
    samples = max(4 * MOST_POINTS // max(len(story.sections), 1), FEWEST_POINTS) if live else 0
    return [
        (f"r{i}", section.record.name, parts(section, f"r{i}", points, samples))
        for i, section in enumerate(story.sections, start=1)
    ]


def environment() -> Environment:
    """Where the pages' templates are found; every text is escaped and made plain, and a missing value is an error."""
    made = Environment(
        loader=PackageLoader("pam_ident.report", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=lambda value: together(plain(value)) if type(value) is str else value,
    )
    made.globals |= {"embed": _embed, "most_steps": _most_steps, "most_switches": _most_switches, "live": None}
    return made


def _embed(picture: Picture) -> Markup:
    return embed(picture.figure, picture.name, picture.label, tips=picture.tips, classes=picture.switches)


def inlined(records: Chapters) -> "Inline | None":
    """What brings the figures of a page to life."""
    pictures = (one for _, _, parts in records for one in _pictures(parts))
    figures = {f"{one.name}-live": one.live for one in pictures if one.live is not None}
    if not figures:
        return None
    from ..live.page import inline

    return inline(figures)


def _pictures(parts: Iterable[Part]) -> Iterator[Picture]:
    for part in parts:
        yield from part.pictures
        yield from _pictures(step for _, step in part.steps)


def _most_switches(records: Chapters) -> int:
    return max((len(one.switches) for _, _, parts in records for part in parts for one in part.pictures), default=0)


def _most_steps(records: Chapters) -> int:
    return max((len(part.steps) for _, _, parts in records for part in parts), default=0)
