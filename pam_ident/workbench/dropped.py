"""Files that came through the browser, as a record."""

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from ..core import PamError, Specimen, UsageError
from ..records import Record, read_record
from ..records.files import check_unpacked

COMPANIONS = ("specimen.toml", "columns.toml")
MOST_UNPACKED = 1 << 30
"""Bytes that a file may have behind its compression."""
UNSAFE = re.compile(r"[^\w.\- ]|^[.\s]+", re.ASCII)


def safe_name(name: str) -> str:
    """The last part of a name without anything that a file system or a shell could take for more than a name."""
    return UNSAFE.sub("_", name.replace("\\", "/").rpartition("/")[2])[-80:] or "record.csv"


def read_dropped(files: Mapping[str, bytes], specimen: Specimen | None) -> tuple[Record, str]:
    """The record of one or several files, and its name; specimen.toml and columns.toml may be among them.

    `specimen` is taken where the files bring none. Raises UsageError without a record among them, DataError as
    `read_record` does and for a file that is far larger than it looks.
    """
    named = {safe_name(name): content for name, content in files.items()}
    if len(named) < len(files):
        raise UsageError("two of the files have the same name; rename one of them")
    runs = [name for name in named if name.lower() not in COMPANIONS]
    if not runs:
        raise UsageError("no record among the files; drop a file of measurements, specimen.toml beside it")
    given = next((name for name in named if name.lower() == COMPANIONS[0]), None)
    with TemporaryDirectory(prefix="pam-ident-") as place:
        for name, content in named.items():
            Path(place, name.lower() if name.lower() in COMPANIONS else name).write_bytes(content)
        path = Path(place, runs[0]) if len(runs) == 1 else Path(place)
        try:
            for name in runs:
                check_unpacked(Path(place, name), MOST_UNPACKED)
            record = read_record(path, None if given else specimen)
        except PamError as error:
            raise type(error)(here(str(error), place)) from None
    known_as = runs[0] if len(runs) == 1 else "the files"
    notes = tuple(replace(note, text=here(note.text, place)) for note in record.notes)
    columns = {key: here(header, place) for key, header in record.columns.items()}
    return replace(record, source=known_as, notes=notes, columns=columns), known_as


def here(text: str, place: str) -> str:
    """A text without the folder of this machine in which the files lay for a moment."""
    return text.replace(f"{place}/", "").replace(place, "the files")
