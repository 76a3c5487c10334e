"""What a report is given, and where that came from."""

import platform
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from importlib.metadata import version

from .. import __version__
from ..diagnosis.nouns import Comparison, Diagnosis, Ladder
from ..fitting import Fit, IsobarTable
from ..records import Record


@dataclass(frozen=True)
class Section:
    """All about one record. `comparison` holds the law as given, `comparison_after` the completed model.

    `loop_measured` and `loop_model` map a pressure in MPa to the energy of its loop in J, positive where the
    loop dissipates; the model's is that of the completed model.
    """

    record: Record
    comparison: Comparison
    diagnosis: Diagnosis
    comparison_after: Comparison | None = None
    ladder: Ladder | None = None
    isobar_tables: tuple[IsobarTable, ...] = ()
    loop_measured: Mapping[float, float] = field(default_factory=dict)
    loop_model: Mapping[float, float] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()

    @property
    def before(self) -> Fit:
        """The law as given."""
        return self.comparison.fit

    @property
    def after(self) -> Fit | None:
        """The completed model, None where nothing was added."""
        if self.comparison_after is not None:
            return self.comparison_after.fit
        return self.diagnosis.best if self.diagnosis.selected else None

    @property
    def noise_floor(self) -> float:
        """In N, of the most complete model that was asked."""
        return (self.ladder or self.diagnosis).noise_floor


@dataclass(frozen=True)
class Story:
    """A report: a title, a section a record, and where it all came from.

    `provenance` maps a word to text, or to a further mapping (versions); its `command` makes the report again.
    """

    title: str
    sections: tuple[Section, ...]
    provenance: Mapping[str, object] = field(default_factory=dict)


def provenance(records: Mapping[str, Record], command: str) -> dict[str, object]:
    """Files with their hashes, versions, the UTC date, and the command that makes it again."""
    found: dict[str, object] = {"date (UTC)": datetime.now(UTC).strftime("%Y-%m-%d %H:%M")}
    for path, record in records.items():
        found[f"SHA-256 of {path}"] = record.sha256
    found["versions"] = {"pam-ident": __version__, "python": platform.python_version()} | {
        name: version(name) for name in ("numpy", "scipy", "pandas")
    }
    found["command"] = command
    return found
