"""What a record says about a model, as one HTML file that loads nothing, as Markdown with figures, or as PDF."""

from .markdown import render_markdown
from .pdf import find_browser, to_pdf
from .render import render
from .story import Section, Story

__all__ = ["Section", "Story", "find_browser", "render", "render_markdown", "to_pdf"]
