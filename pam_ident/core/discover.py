"""Find what a folder of one-thing-a-file modules declares."""

from collections.abc import Iterable
from importlib import import_module
from pkgutil import iter_modules
from typing import TypeVar

T = TypeVar("T")


def instances(package: str, paths: Iterable[str], kind: type[T]) -> list[T]:
    """Public module-level objects of `kind` in every module of `package`, by module name."""
    found: list[T] = []
    for info in sorted(iter_modules(paths), key=lambda item: item.name):
        module = import_module(f"{package}.{info.name}")
        found += [value for key, value in vars(module).items() if key.isupper() and isinstance(value, kind)]
    return found
