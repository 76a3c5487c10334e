"""The made-up results of the figures' tests, and IPython's display formatter."""

import runpy
from pathlib import Path

import pytest

from pam_ident.notebook import register

_made = runpy.run_path(str(Path(__file__).parents[1] / "plot" / "conftest.py"))
record, table, diagnosis, ladder, make_record, make_diagnosis = (
    _made[name] for name in ("record", "table", "diagnosis", "ladder", "make_record", "make_diagnosis")
)


@pytest.fixture
def shown():
    """What IPython would send to a notebook for an object, by its kind of text."""
    formatters = pytest.importorskip("IPython.core.formatters")
    display = formatters.DisplayFormatter()
    register(display)
    return lambda result: display.format(result)[0]
