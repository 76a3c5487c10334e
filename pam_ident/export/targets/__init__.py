"""What a model is exported to, one a file: a file that defines TARGET is listed and written under the file's name."""

from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..target import Target

__all__ = ["get_target", "names"]


def names() -> list[str]:
    """What a model can be exported to; nothing is imported for it."""
    return sorted(info.name for info in iter_modules(__path__))


def get_target(name: str) -> "Target":
    """The target called `name`. Raises UsageError listing the known ones."""
    from ...core import UsageError

    if name not in names():
        raise UsageError(f"--to {name!r}: expected one of {', '.join([*names(), 'json'])}")
    return import_module(f"{__name__}.{name}").TARGET
