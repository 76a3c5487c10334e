"""A record as one folder that says all about itself: a Data Package of Frictionless Data, version 1.

The descriptor is plain JSON and written as such; the library `frictionless`, forty packages, judges it in the tests.
"""

import json
import re
import shutil
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pandas as pd

from ..core import UsageError
from ..records import Record
from ..records.package import DESCRIPTOR
from ..records.specimen_file import specimen_toml
from .frames import samples

MEANINGS = {
    "time_s": ("s", "time"),
    "pressure_MPa": ("MPa", "gauge pressure in the muscle"),
    "pressure_set_MPa": ("MPa", "gauge pressure commanded, which names the isobar"),
    "contraction": ("1", "(L0 - L)/L0, positive when the muscle shortens; L0 is the specimen's initial_length_mm"),
    "branch": ("1", "contraction or extension"),
    "cycle": ("1", "number of the cycle"),
    "temperature_C": ("°C", "temperature of the muscle"),
    "force_N": ("N", "measured force, positive in pull"),
}
"""Unit and meaning of the columns that a package may hold."""
SAID = {"pressure_set": "pressure_set_MPa", "branch": "branch", "cycle": "cycle"}
"""Columns that a package holds where the record did, and that are found from the motion where it did not."""


def check_folder(out: str | Path) -> Path:
    """Where a package is to go: a folder that is not there yet, or is empty. Raises UsageError."""
    folder = Path(out)
    if not folder.absolute().parent.is_dir():
        raise UsageError(f"{folder}: there is no folder {folder.parent}; make it, or name another one")
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise UsageError(f"{folder}: is there already and not empty; name a new folder")
    return folder


def write_package(record: Record, out: str | Path) -> tuple[Path, ...]:
    """Write a record with its specimen and metadata into a new folder, whole or not at all; the paths of its files.

    Raises UsageError for a folder that is there and not empty.
    """
    folder = check_folder(out)
    table = _table(record)
    files = {
        "record.csv": table.to_csv(index=False, lineterminator="\n"),
        "specimen.toml": specimen_toml(record.specimen, record.said_kind),
    }
    about = _descriptor(record, list(table))
    files[DESCRIPTOR] = json.dumps(about, indent=2, ensure_ascii=False) + "\n"
    with TemporaryDirectory(dir=folder.absolute().parent, prefix=f".{folder.name}.") as place:
        new = Path(place, "new")
        new.mkdir()
        for name, text in files.items():
            (new / name).write_text(text, encoding="utf-8", newline="\n")
        if folder.exists():
            folder.rmdir()
        shutil.move(new, folder)
    return tuple(folder / name for name in files)


def _table(record: Record) -> pd.DataFrame:
    frame = samples(record)
    left_out = {name for key, name in SAID.items() if key not in record.columns}
    return frame.loc[:, [name for name in frame if name in MEANINGS and name not in left_out]]


def _descriptor(record: Record, columns: list[str]) -> dict[str, Any]:
    fields = [
        {"name": name, "type": "string" if name == "branch" else "number", "unit": unit, "description": meaning}
        for name, (unit, meaning) in ((name, MEANINGS[name]) for name in columns)
    ]
    licence = record.metadata.get("licence", record.metadata.get("license"))
    operator = record.metadata.get("operator")
    found = {
        "profile": "data-package",
        "name": re.sub(r"[^a-z0-9._-]+", "-", record.name.lower()).strip("-.") or "record",
        "title": record.name,
        "licenses": licence and [{"name": re.sub(r"[^\w.-]+", "-", str(licence)), "title": str(licence)}],
        "contributors": operator and [{"title": str(operator), "role": "contributor"}],
        "sources": [{"title": record.source or "from memory", "sha256": record.sha256}],
        "notes": [note.text for note in record.notes],
        "metadata": dict(record.metadata),
        "resources": [
            {
                "profile": "tabular-data-resource",
                "name": "record",
                "path": "record.csv",
                "format": "csv",
                "mediatype": "text/csv",
                "encoding": "utf-8",
                "schema": {"fields": fields},
            },
            {"name": "specimen", "path": "specimen.toml", "format": "toml", "mediatype": "application/toml"},
        ],
    }
    return {key: value for key, value in found.items() if value}
