"""Answers of a batch on disk: a file each, whole or not there, under the key of what was asked."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..core import UsageError
from ..core.files import write_json_lines
from .record import SCHEMA

Json = dict[str, Any]


@dataclass(frozen=True)
class Store:
    """A folder of answers, shared out among subfolders; what cannot be read back counts as not there."""

    folder: Path

    def place(self, key: str) -> Path:
        """The file of a key."""
        return self.folder / key[:2] / f"{key}.json"

    def get(self, key: str) -> Json | None:
        """The answer kept under a key, or None. Raises UsageError for one that a later program wrote."""
        try:
            found = json.loads(self.place(key).read_bytes())
        except (FileNotFoundError, ValueError):
            return None
        if not isinstance(found, dict) or "rows" not in found:
            return None
        if found.get("schema") != SCHEMA:
            raise UsageError(f"{self.place(key)}: schema {found.get('schema')!r}; expected {SCHEMA}. Update pam-ident")
        return found

    def put(self, key: str, answer: Json) -> None:
        """Keep an answer. Raises OSError, and nothing is changed then."""
        place = self.place(key)
        place.parent.mkdir(parents=True, exist_ok=True)
        write_json_lines(place, [answer])

    def sweep(self) -> None:
        """Remove halves of files that killed writers left."""
        for stray in self.folder.glob("*/.*"):
            stray.unlink(missing_ok=True)
