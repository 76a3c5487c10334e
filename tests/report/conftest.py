"""The made-up record and diagnosis of the figures' tests serve the report's too."""

import runpy
from pathlib import Path

import pytest

_figures = runpy.run_path(str(Path(__file__).parents[1] / "plot" / "conftest.py"))
record, table, diagnosis, ladder, make_record, make_diagnosis = (
    _figures[name] for name in ("record", "table", "diagnosis", "ladder", "make_record", "make_diagnosis")
)


@pytest.fixture
def watched(page, file):
    """A page for a module's `file`: in the end nothing was complained of, and nothing but the file asked for."""
    complaints, asked = [], []
    page.on("console", lambda message: complaints.append(message.text))
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("request", lambda request: asked.append(request.url))
    yield page
    assert complaints == [] and [url for url in asked if not url.startswith("data:")] == [file.as_uri()]
