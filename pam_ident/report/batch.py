"""The page that compares the muscles of a batch."""

from collections.abc import Mapping, Sequence

from .easel import Easel, Part, Picture
from .render import page
from .tables import PageTable
from .words import newtons, number

__all__ = ["Easel", "PageTable", "Part", "Picture", "newtons", "number", "render_batch"]


def render_batch(title: str, sections: Sequence[tuple[str, tuple[Part, ...]]], provenance: Mapping[str, object]) -> str:
    """One HTML file as text, a section for each named group of parts; `provenance` as in a Story."""
    return page(title, [(f"b{i}", name, parts) for i, (name, parts) in enumerate(sections, start=1)], provenance)
