"""A story becomes a page."""

from jinja2 import Environment, PackageLoader, StrictUndefined

from . import tables
from .parts import Part, parts
from .story import Story

MOST_POINTS, FEWEST_POINTS = 1500, 200


def render(story: Story) -> str:
    """One HTML file as text: no script, nothing loaded from anywhere, every text escaped.

    The more records there are, the fewer points a figure shows, so that the file stays below 3 MB.
    """
    points = max(MOST_POINTS * 3 // max(len(story.sections), 3), FEWEST_POINTS)
    records: list[tuple[str, str, tuple[Part, ...]]] = [
        (f"r{i}", section.record.name, parts(section, f"r{i}", points))
        for i, section in enumerate(story.sections, start=1)
    ]
    return (
        environment()
        .get_template("report.html.j2")
        .render(
            title=story.title,
            records=records,
            provenance=tables.provenance(story.provenance),
            command=story.provenance.get("command"),
        )
    )


def environment() -> Environment:
    """Where the pages' templates are found; every text is escaped, and a missing value is an error."""
    return Environment(
        loader=PackageLoader("pam_ident.report", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
