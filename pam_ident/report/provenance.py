"""Where an answer came from."""

import platform
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib.metadata import version

from .. import __version__
from ..records import Record


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
