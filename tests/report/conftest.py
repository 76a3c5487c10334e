"""The made-up record and diagnosis of the figures' tests serve the report's too."""

import runpy
from pathlib import Path

_figures = runpy.run_path(str(Path(__file__).parents[1] / "plot" / "conftest.py"))
record, table, diagnosis, ladder, make_record, make_diagnosis = (
    _figures[name] for name in ("record", "table", "diagnosis", "ladder", "make_record", "make_diagnosis")
)
