"""pam-ident report."""

from typing import Annotated

from . import options, text


def report(
    record: options.Record,
    law: options.Law,
    out: Annotated[str, options.option("--out", "FILE", "The file to write.")],
    format: Annotated[str | None, options.option("--format", "html|md|pdf", "Default: what FILE ends in.")] = None,
    asked: options.Asked = options.NOTHING,
) -> None:
    """Write all of it into one file: HTML that needs no network, Markdown with figures beside it, or PDF."""
    from ..schema.diagnosis import diagnosis_json
    from ..tasks.gate import GraveDoubt, warnings_of
    from ..tasks.report import report_record

    setup = asked.setup(law)
    try:
        story = report_record(record, setup, out, format)
    except GraveDoubt as stop:
        options.give_stopped(asked.json, record, law, stop)
        raise
    diagnosis = story.sections[0].diagnosis
    doubts = warnings_of(diagnosis.base)
    options.give_json(asked.json, lambda: diagnosis_json(record, diagnosis, doubts))
    text.say(*text.banner(doubts), story.sections[0].diagnosis.sentence, f"report: {out}")
