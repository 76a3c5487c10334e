"""pam-ident report."""

from dataclasses import replace
from typing import Annotated

from . import options, text


def report(
    record: options.Record,
    out: Annotated[str, options.option("--out", "FILE", "The file to write.")],
    law: options.Law = "auto",
    format: Annotated[str | None, options.option("--format", "html|md|pdf", "Default: what FILE ends in.")] = None,
    asked: options.Asked = options.NOTHING,
    without: options.Without = None,
    only: options.Only = None,
    also: options.Also = None,
    heldout: options.Heldout = None,
) -> None:
    """Write all of it into one file: HTML, Markdown or PDF.

    The HTML needs no network; Markdown has its figures in a folder beside it.
    """
    from ..core import PamError
    from ..parallel.executor import Executor
    from ..report.opening import answer
    from ..schema.diagnosis import diagnosis_json
    from ..schema.prediction import law_choice_json
    from ..tasks.diagnose import fit_command
    from ..tasks.gate import warnings_of
    from ..tasks.law_choice import settle
    from ..tasks.report import check_report, report_record

    setup = replace(asked.setup(law), heldout=options.held_out(heldout), **options.tried(without, only, also))
    check_report(out, format)
    choice = None
    try:
        measured = setup.read(record)
        setup, choice = settle(measured, setup)
        story = report_record(measured, setup, out, format, Executor.of_cores())
    except PamError as stop:
        options.give_stopped(asked.json, record, setup.law, stop, choice)
        raise
    diagnosis = story.sections[0].diagnosis
    doubts = warnings_of(diagnosis.base)
    command = fit_command(diagnosis, record, setup)
    options.give_json(asked.json, lambda: diagnosis_json(record, diagnosis, doubts, command) | law_choice_json(choice))
    text.say(*text.chosen(choice))
    text.say(*text.banner(doubts), answer(story.sections[0]), f"report: {out}")
