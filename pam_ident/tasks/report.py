"""The whole answer about one record as a file."""

from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

from ..core import UsageError
from ..core.files import check_target, write_whole
from ..diagnosis.nested import HERE
from ..parallel.executor import Executor
from ..records import Record
from ..report import Story, find_browser, render, render_markdown, to_pdf
from ..report.story import provenance
from .law_choice import settle
from .section import build_section
from .setup import Setup

SUFFIXES = {".html": "html", ".htm": "html", ".md": "md", ".markdown": "md", ".pdf": "pdf"}
FORMATS = ("html", "md", "pdf")


def report_record(
    path: str | Record,
    setup: Setup,
    out: str = "report.html",
    kind: str | None = None,
    executor: Executor = HERE,
) -> Story:
    """Write the report of one record to a file and return its story.

    Args:
        path: of the record, or the record itself.
        setup: the law, and effects that are known already.
        out: the file to write. Figures of an md lie beside it in a folder, NAME_figures.
        kind: html, md or pdf; by default what `out` ends in, and html where it has no ending.
        executor: who chooses anew without the held-out rows.

    Raises:
        DataError, FitError: where the record cannot be read or fitted.
        UsageError: where `out` cannot be written or a PDF not be printed; before any work is done.

    Example:
        >>> from pam_ident.records.datasets import dataset_record
        >>> from pam_ident.tasks.report import report_record
        >>> from pam_ident.tasks.setup import Setup
        >>> print(report_record(str(dataset_record("nothing_hidden")), Setup("exponential_law"), "report.html").title)
        nothing_hidden: exponential law
    """
    target, chosen, folder = check_report(out, kind)
    setup.check()
    record = path if isinstance(path, Record) else setup.read(path)
    path = path if isinstance(path, str) else record.source or record.name
    setup, _ = settle(record, setup)
    section = build_section(record, setup, executor)
    more = ("--format", kind) if kind else ()
    source = provenance({path: record}, setup.command("report", path, "--out", out, *more))
    story = Story(f"{record.name}: {setup.law_alone.law.title}", (section,), source)
    if chosen == "md":
        text, figures = render_markdown(story, folder.name)
        _write_with_folder(target, text, folder, figures)
    else:
        page = render(story, live=chosen == "html")
        write_whole(target, page if chosen == "html" else to_pdf(page, target.parent))
    return story


def check_report(out: str, kind: str | None = None) -> tuple[Path, str, Path]:
    """The file to write, its format, and the folder of its figures. Raises UsageError for what cannot be written."""
    target = check_target(out, tuple(SUFFIXES) if kind is None and Path(out).suffix else ())
    chosen = kind or SUFFIXES.get(target.suffix.lower(), "html")
    if chosen not in FORMATS:
        raise UsageError(f"format {kind!r}; expected one of {', '.join(FORMATS)}")
    folder = target.with_name(f"{target.stem}_figures")
    if chosen == "md":
        _check_folder(folder)
    if chosen == "pdf":
        find_browser()
    return target, chosen, folder


def _check_folder(folder: Path) -> None:
    """Only a folder of an earlier report is replaced. Raises UsageError."""
    if not folder.exists():
        return
    if not folder.is_dir() or any(not one.match("figure_*.svg") for one in folder.iterdir()):
        raise UsageError(f"{folder}: is no folder of figures of an earlier report; move it, or name another file")


def _write_with_folder(target: Path, text: str, folder: Path, files: Mapping[str, str]) -> None:
    """Both or neither: `text` as `target`, and `files` in `folder`, which is replaced as a whole."""
    with TemporaryDirectory(dir=folder.parent, prefix=f".{folder.name}.") as place:
        new, old = Path(place, "new"), Path(place, "old")
        new.mkdir()
        for name, content in files.items():
            (new / name).write_text(content, encoding="utf-8")
        replaced = folder.exists()
        if replaced:
            folder.replace(old)
        try:
            new.replace(folder)
            write_whole(target, text)
        except BaseException:
            if folder.exists():
                folder.replace(new)
            if replaced:
                old.replace(folder)
            raise
