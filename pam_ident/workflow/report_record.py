"""The whole answer about one record as one HTML file."""

from ..report import Story, render
from .provenance import provenance
from .section import build_section
from .setup import Setup


def report_record(path: str, setup: Setup, out: str = "report.html") -> tuple[str, Story]:
    """The page as text, and the story it tells; `out` is the file named in the command that makes it again.

    Raises DataError, FitError or UsageError.
    """
    model = setup.model
    record = setup.read(path)
    section = build_section(model, record, setup.extra)
    source = provenance({path: record}, setup.command("report", path, "--out", out))
    story = Story(f"{record.name}: {setup.law} against the measurement", (section,), source)
    return render(story), story
