"""What a batch asks, of which records, and the key under which each answer is kept."""

import hashlib
import json
import os
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from .. import __version__
from ..core import DataError, UsageError
from ..fitting.fit import branch_names
from ..records import file_sha256
from ..tasks.fit import FitOptions
from ..tasks.setup import Setup

SPECIMEN = "specimen.toml"


@dataclass(frozen=True)
class BatchRequest:
    """The same for every record: law and effects to fit, by branch, and whether to name what they lack.

    Raises UsageError for an unknown branch, or a specimen for all (each record has its own).
    """

    setup: Setup
    branch: str = "together"
    diagnose: bool = False
    version: str = field(default=__version__)

    def __post_init__(self) -> None:
        FitOptions(self.branch)
        if self.setup.specimen is not None:
            raise UsageError(f"{self.setup.specimen}: a batch takes the {SPECIMEN} beside or above each record")

    @property
    def branches(self) -> tuple[str, ...]:
        """One row of the table for each, in the order of their names."""
        return tuple(sorted(branch_names(self.branch)))

    def bare(self) -> "BatchRequest":
        """The same for another process."""
        return replace(self, setup=self.setup.bare())

    def words(self) -> dict[str, Any]:
        """All that an answer depends on besides the record, for its key; files by their hashes."""
        setup = {key: value for key, value in asdict(self.setup).items() if key != "assume" or value}
        files = {"effect_files": [file_sha256(path) for path in self.setup.effect_files]}
        return setup | files | {"branch": self.branch, "diagnose": self.diagnose, "version": self.version}


@dataclass(frozen=True)
class Item:
    """One record to answer: `name` is its path inside the tree; `key` is that of its answer."""

    name: str
    path: str
    specimen: str
    sha256: str
    key: str


@dataclass(frozen=True)
class WorkList:
    """The records of a tree in the order of their names; `faults` maps the name of a file that cannot be asked to
    why."""

    items: tuple[Item, ...]
    faults: dict[str, str]

    def __len__(self) -> int:
        return len(self.items) + len(self.faults)


def plan(folder: Path, question: BatchRequest, out: Path) -> WorkList:
    """Every CSV file under `folder` with the specimen.toml beside or above it; hidden files and `out` are passed over.

    Raises UsageError where `folder` is no folder or holds no CSV file.
    """
    if not folder.is_dir():
        raise UsageError(f"{folder}: no such folder; give the folder that holds the records")
    words = json.dumps(question.words(), sort_keys=True)
    hashes: dict[Path, str] = {}
    items, faults = [], {}
    for path in _records(folder.resolve(), out.resolve()):
        name = path.relative_to(folder.resolve()).as_posix().encode(errors="replace").decode()
        try:
            specimen = _specimen(path, folder.resolve())
            if specimen not in hashes:
                hashes[specimen] = file_sha256(specimen)
            content = file_sha256(path)
        except (OSError, DataError) as error:
            faults[name] = f"{name}: {getattr(error, 'strerror', None) or error}"
            continue
        key = hashlib.sha256("\n".join((name, content, hashes[specimen], words)).encode()).hexdigest()
        items.append(Item(name, str(path), str(specimen), content, key))
    if not items and not faults:
        raise UsageError(f"{folder}: no CSV file in it or below it; give the folder that holds the records")
    return WorkList(tuple(sorted(items, key=lambda item: item.name)), faults)


def _records(folder: Path, out: Path) -> Iterator[Path]:
    for place, folders, files in os.walk(folder):
        folders[:] = [name for name in folders if not name.startswith(".") and Path(place, name) != out]
        yield from (Path(place, n) for n in files if n.lower().endswith(".csv") and not n.startswith("."))


def _specimen(record: Path, folder: Path) -> Path:
    """The nearest specimen.toml from the record's folder upwards, not beyond the tree. Raises DataError."""
    for place in record.parents:
        if (place / SPECIMEN).is_file():
            return place / SPECIMEN
        if place == folder:
            break
    raise DataError(f"no {SPECIMEN} beside it or above it in the tree; write one with a table [specimen]")
