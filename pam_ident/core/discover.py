"""Find what a folder of one-thing-a-file modules declares, or a user's own file."""

import importlib.util
from collections.abc import Iterable
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from types import ModuleType
from typing import TypeVar

from .errors import UsageError

T = TypeVar("T")


def instances(package: str, paths: Iterable[str], kind: type[T]) -> list[T]:
    """Public module-level objects of `kind` in every module of `package`, by module name."""
    found: list[T] = []
    for info in sorted(iter_modules(paths), key=lambda item: item.name):
        found += _declared(import_module(f"{package}.{info.name}"), kind)
    return found


def instances_in(path: str | Path, kind: type[T]) -> list[T]:
    """Those of a Python file. Raises UsageError where it cannot be run or declares none."""
    path, name = Path(path), kind.__name__
    spec = importlib.util.spec_from_file_location(f"pam_ident_user_{path.stem}", path)
    if spec is None or spec.loader is None or not path.is_file():
        raise UsageError(f"{path}: not a Python file; expected a file that defines {name.upper()}")
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise UsageError(f"{path}: fails on import ({type(error).__name__}: {error}); fix the file") from None
    found = _declared(module, kind)
    if not found:
        raise UsageError(f"{path}: defines no {name.lower()}; expected {name.upper()} = {name}(...)")
    return found


def _declared(module: ModuleType, kind: type[T]) -> list[T]:
    return [value for key, value in vars(module).items() if key.isupper() and isinstance(value, kind)]
