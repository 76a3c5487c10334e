"""File formats of records, one a file. A file that defines FORMAT is read, and told of, without further ado."""

from functools import cache

from ...core.discover import instances
from .base import Format

__all__ = ["Format", "catalogue"]


@cache
def catalogue() -> dict[str, Format]:
    """Every format but text, by the endings of its files."""
    return {ending: one for one in instances(__name__, __path__, Format) for ending in one.endings}
