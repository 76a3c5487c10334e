"""Static force laws, one a file. A file that defines LAW is listed, fitted and tested without further ado."""

from functools import cache

from ..core import UsageError
from ..core.discover import instances
from .base import Law

__all__ = ["Law", "catalogue", "get_law", "listed"]


@cache
def catalogue() -> dict[str, Law]:
    """Every law of the package, by name."""
    return {law.name: law for law in instances(__name__, __path__, Law)}


def listed() -> tuple[Law, ...]:
    """Every law, those with the fewest parameters first."""
    return tuple(sorted(catalogue().values(), key=lambda law: (len(law.params), law.name)))


def get_law(name: str) -> Law:
    """The law called `name`. Raises UsageError listing the known ones."""
    laws = catalogue()
    if name not in laws:
        raise UsageError(f"unknown law {name!r}; expected one of {', '.join(sorted(laws))}")
    return laws[name]
