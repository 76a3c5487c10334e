"""One HTML file that tells what a record says about a model; it loads nothing from anywhere."""

from .render import render
from .story import Section, Story

__all__ = ["Section", "Story", "render"]
