"""What is known about a record besides its numbers, and records that are Data Packages (Frictionless Data, version 1).

https://specs.frictionlessdata.io/data-package
"""

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import date, datetime, time
from pathlib import Path
from typing import Any

from ..core import DataError
from ..core.files import read_toml

DESCRIPTOR, METADATA = "datapackage.json", "metadata.toml"


@dataclass(frozen=True)
class Package:
    """What a datapackage.json says: title, paths of the data, and metadata."""

    title: str
    paths: tuple[Path, ...]
    metadata: Mapping[str, Any]


def read_package(folder: Path) -> Package | None:
    """The Data Package in a folder, None where there is none. Raises DataError for one that cannot be read."""
    path = folder / DESCRIPTOR
    if not path.is_file():
        return None
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        names = [str(one.get("path")) for one in content["resources"]]
        title, metadata = str(content.get("title") or content.get("name") or ""), dict(content.get("metadata", {}))
    except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
        raise DataError(f"{path}: no readable Data Package ({error}); expected resources with a path each") from None
    return Package(title, tuple(folder / name for name in names), metadata)


def data_of(package: Package, folder: Path, endings: tuple[str, ...]) -> tuple[Path, ...]:
    """The files of a package that end as records do. Raises DataError where there are none, or not in the folder."""
    found = tuple(path for path in package.paths if path.suffix.lower() in endings)
    for path in found:
        if not (path.resolve().is_relative_to(folder.resolve()) and path.is_file()):
            raise DataError(f"{folder / DESCRIPTOR}: there is no file {path.name} in this folder; add it")
    if not found:
        raise DataError(f"{folder / DESCRIPTOR}: no resource is a record; expected a path ending in {endings[0]}")
    return found


def read_metadata(folder: Path) -> dict[str, Any]:
    """What is known about a record in the folder: of its Data Package, or of `metadata.toml`. Raises DataError."""
    package, path = read_package(folder), folder / METADATA
    if package is not None:
        return dict(package.metadata)
    return metadata_of(path) if path.is_file() else {}


def metadata_of(path: str | Path) -> dict[str, Any]:
    """The content of a TOML file, dates as text. Raises DataError."""
    return _plain(read_toml(path))


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(one) for key, one in value.items()}
    if isinstance(value, list):
        return [_plain(one) for one in value]
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return value.isoformat() if isinstance(value, date | datetime | time) else value


def told(metadata: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, str]]:
    """Metadata line by line: the words that lead there, and the value."""
    for key, value in metadata.items():
        words = _one_line(f"{before}{key}".replace("_", " "))
        if isinstance(value, Mapping):
            yield from told(value, f"{words}: ")
        else:
            yield words, _one_line(", ".join(map(str, value)) if isinstance(value, list) else str(value))


def _one_line(text: str) -> str:
    """Without what a terminal would obey."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())
