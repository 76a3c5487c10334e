"""Static force laws, one a file. A file that defines LAW is listed, fitted and tested without further ado."""

from functools import cache

from ..core import UsageError
from ..core.discover import instances, instances_in
from ..core.nearest import unknown
from .base import Law

_own: dict[str, Law] = {}

__all__ = ["Law", "catalogue", "get_law", "listed"]


@cache
def catalogue() -> dict[str, Law]:
    """Every law of the package, by name.

    Example:
        >>> from pam_ident.laws import catalogue
        >>> print(*catalogue(), sep=", ")
        chou_hannaford, exponential_law, hildebrandt, martens_boblan, modified_chou_hannaford, polynomial, sarosi, ...
    """
    return {law.name: law for law in instances(__name__, __path__, Law)}


def listed() -> tuple[Law, ...]:
    """Every law, those with the fewest parameters first."""
    return tuple(sorted(catalogue().values(), key=lambda law: (len(law.params), law.name)))


def get_law(name: str) -> Law:
    """A law by its name, or of a Python file of the user's own that defines LAW (`my_law.py`), which is then known by
    its name, too.

    Raises:
        UsageError: for an unknown name, with those that look like it, and for a file that defines no law.

    Example:
        >>> from pam_ident.laws import get_law
        >>> law = get_law("exponential_law")
        >>> print(law.formula, "has", len(law.params), "parameters")
        F = (a0 + a1 p) − (b0 + b1 p) ε + (c0 + c1 p) exp(−μ ε) has 7 parameters
    """
    if name.endswith(".py"):
        (law, *_) = instances_in(name, Law)
        _own[law.name] = law
        return law
    laws = catalogue() | _own
    if name not in laws:
        raise UsageError(unknown("law", name, laws, "`pam-ident laws`"))
    return laws[name]
