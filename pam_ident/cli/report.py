"""pam-ident report."""

from typing import Annotated

import typer

from . import options, text


def report(
    record: options.Record,
    law: options.Law,
    out: Annotated[str, typer.Option("--out", metavar="FILE", help="The file to write.", show_default=False)],
    format: Annotated[
        str | None,
        typer.Option("--format", metavar="html|md|pdf", help="Default: what FILE ends in.", show_default=False),
    ] = None,
    asked: options.Asked = options.NOTHING,
) -> None:
    """Write all of it into one file: HTML that needs no network, Markdown with figures beside it, or PDF."""
    from ..schema.diagnosis import diagnosis_json
    from ..tasks.report import report_record

    setup = asked.setup(law)
    story = report_record(record, setup, out, format)
    options.give_json(asked.json, lambda: diagnosis_json(record, story.sections[0].diagnosis))
    text.say(story.sections[0].diagnosis.sentence, f"report: {out}")
