"""A story becomes a Markdown file with figures beside it."""

import re
from urllib.parse import quote

from markupsafe import Markup

from ..plot import to_svg
from . import tables
from .easel import Picture
from .render import chapters, environment
from .story import Story
from .words import plain

ACTIVE = re.compile(r"[\\`*_\[\]!|~$^#@]|(?<=:)/(?=/)|(?<=www)\.")
"""What is markup anywhere in a line; the last two make links of bare addresses."""
AT_THE_START = re.compile(r"^(\d*)(?=[-+.):=](?!\d))")
"""What would make a list, a rule or a heading of a line; a number is left as it is."""
AS_HTML = str.maketrans({"&": "&amp;", "<": "&lt;", ">": "&gt;"})


def render_markdown(story: Story, folder: str) -> tuple[str, dict[str, str]]:
    """The text, and the figures as SVG by file name, to lie in `folder` beside it. Every text is escaped."""
    figures: dict[str, str] = {}

    def hang(picture: Picture) -> Markup:
        name = f"figure_{len(figures) + 1:02d}.svg"
        figures[name] = plain(to_svg(picture.figure))
        return Markup(quote(f"{folder}/{name}"))

    made = environment().overlay(finalize=lambda value: Markup(escape(value)) if type(value) is str else value)
    text = made.get_template("report.md.j2").render(
        title=story.title,
        records=chapters(story),
        provenance=tables.provenance(story.provenance),
        command=code(str(story.provenance.get("command", ""))),
        hang=hang,
    )
    return re.sub(r"\n{3,}", "\n\n", text), figures


def escape(text: str) -> str:
    """Text in one line that no Markdown, and no HTML in it, can be made of."""
    line = " ".join(plain(text).split())
    line = ACTIVE.sub(lambda found: "\\" + found.group(), line)
    return AT_THE_START.sub(r"\1\\", line).translate(AS_HTML)


def code(text: str) -> Markup:
    """An indented block, which nothing inside can close."""
    return Markup("\n".join(f"    {line}" for line in plain(text).splitlines()))
