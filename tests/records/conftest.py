"""Writes a record to disk for these tests."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from corpus import SPECIMEN


@pytest.fixture
def put(tmp_path):
    """Writes a file (text or bytes) with a specimen beside it, and perhaps a columns.toml; the path."""

    def inner(content, name="record.csv", mapping=None):
        (tmp_path / "specimen.toml").write_text(SPECIMEN, encoding="utf-8")
        if mapping is not None:
            (tmp_path / "columns.toml").write_text(mapping, encoding="utf-8")
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8"))
        return path

    return inner
