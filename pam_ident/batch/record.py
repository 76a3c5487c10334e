"""The answer to one record of a batch, the same bits wherever it is worked out, and where it is kept: a dictionary, in
a file of its own as JSON, whole or not there, under the key of what was asked.
"""

import json
import os
import platform
import re
import tomllib
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..core import FitError, PamError, Specimen, UsageError
from ..core.files import write_json_lines
from ..fitting import Fit, fit
from ..records import Record
from ..schema.versions import schema
from ..tasks.fit import checks_of
from ..tasks.gate import admit, computing, warnings_of
from ..tasks.setup import Setup, load
from .request import BatchRequest, Item

if TYPE_CHECKING:
    from ..diagnosis.nouns import Diagnosis

Json = dict[str, Any]
SCHEMA = schema("batch-record")
GRAVE = "grave: "
"""What a warning begins with that would stop a diagnosis."""


class Changed(Exception):
    """A record is no longer the one that was asked about; its answer must not be kept."""


def answer(question: BatchRequest, item: Item) -> Json:
    """Schema pam-ident/batch-record/1: a row for each branch; an error takes the place of what it prevents.

    Raises UsageError where the question cannot be asked at all, Changed, MemoryError.
    """
    setup = question.setup
    found: Json = {
        "schema": SCHEMA,
        "record": item.name,
        "sha256": item.sha256,
        "law": setup.law,
        "effects": setup.model.labels,
        "versions": dict(versions()),
        "specimen": None,
    }
    try:
        record = load(item.path, item.specimen)
        if record.sha256 != item.sha256:
            raise Changed("it changed while the batch ran; run the batch again")
        found["specimen"] = _specimen(record.specimen, item.specimen)
        admit(record)
        diagnosis = None
        if question.diagnose:
            from ..tasks.diagnose import diagnose_record

            diagnosis = diagnose_record(record, setup)
    except Exception as error:
        message = _message(error, item)
        return found | {"rows": [{"branch": branch, "error": message} for branch in question.branches]}
    return found | {"rows": [_row(setup, record, branch, diagnosis, item) for branch in question.branches]}


def _row(setup: Setup, record: Record, branch: str, diagnosis: "Diagnosis | None", item: Item) -> Json:
    row: Json = {"branch": branch, "error": None}
    if diagnosis is not None:
        row |= {"verdict": diagnosis.verdict, "selected": list(diagnosis.selected)}
    try:
        with computing(record):
            one = fit(setup.model, record, record.branch_rows(branch))
            row |= _fitted(one)
        if one.problems:
            raise FitError(f"{item.path}: the fit is not valid. {'; '.join(one.problems)}")
    except Exception as error:
        row["error"] = _message(error, item)
    if diagnosis is not None:
        row["noise_floor_N"] = diagnosis.noise_floor
    return row


def _fitted(one: Fit) -> Json:
    """What a fit says; its verdict stands only where no diagnosis gave one."""
    checks, errors = checks_of(one), one.length_errors
    in_N = checks.repeats if errors is None else None
    return {
        "n": int(one.rows.sum()),
        "rmse_N": one.rmse,
        "rmse_mm": None if errors is None else errors.rmse,
        "noise_floor_N": None if in_N is None else in_N.sigma,
        "lack_of_fit": None if checks.lack is None else ("adequate" if checks.lack.adequate else "inadequate"),
        "warnings": [f"{GRAVE * doubt.grave}{doubt.code}: {doubt.text}" for doubt in warnings_of(one)],
        "parameters": {e.name: [e.value, e.stderr] for e in one.estimates},
    }


def _message(error: Exception, item: Item) -> str:
    """One line that names files by their place in the tree, so that it is the same wherever the tree lies."""
    if isinstance(error, UsageError | MemoryError | Changed):
        raise error
    if isinstance(error, PamError):
        text = str(error)
    elif os.environ.get("PAM_IDENT_DEBUG"):
        raise error
    else:
        text = f"{item.path}: it broke down ({type(error).__name__}: {error}); please report the record"
    return " ".join(text.replace(item.path.removesuffix(item.name), "").split())


def _specimen(specimen: Specimen, path: str) -> Json:
    """What muscles are compared over. The serial number is the last one in the key `serial_number` of [specimen]."""
    given = tomllib.loads(Path(path).read_text(encoding="utf-8"))["specimen"].get("serial_number", "")
    serial = re.findall(r"\d+", str(given))
    return {
        "name": specimen.name,
        "initial_length_mm": specimen.initial_length_mm,
        "diameter_mm": 2.0 * specimen.initial_radius_mm,
        "serial_number": int(serial[-1]) if serial else None,
    }


@lru_cache(maxsize=1)
def versions() -> tuple[tuple[str, str], ...]:
    """The environment that bits hang on."""
    libraries = [(name, version(name)) for name in ("numpy", "scipy", "pandas")]
    return (("python", platform.python_version()), ("machine", platform.machine()), *libraries)


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
