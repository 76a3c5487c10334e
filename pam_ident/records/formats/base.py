"""What a file format declares."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from ...core import DataError, UsageError
from ..mapping import Mapping
from ..table import Table


@dataclass(frozen=True)
class Format:
    """`read` gives the tables of a file that ends in one of `endings` (small letters, with the point), of the part that
    a columns.toml names where there is one. It raises DataError; what it needs beyond pandas it imports when it runs.
    """

    endings: tuple[str, ...]
    read: Callable[[Path, Mapping | None], list[Table]]


@contextmanager
def reading(path: Path, package: str, kind: str, cure: str) -> Iterator[None]:
    """Inside, a package reads a file of some kind: UsageError where it is not installed, DataError with what to do for
    any of the dozen errors in which a broken file ends."""
    try:
        yield
    except ImportError:
        raise UsageError(
            f"{path}: reading it needs {package}; install it with: pip install 'pam-ident[formats]'"
        ) from None
    except Exception as error:
        first = str(error).partition("\n")[0][:200]  # some print all the bytes that they stumbled over
        raise DataError(f"{path}: not a readable {kind} ({first}); {cure}") from None
