"""pam-ident report."""

from typing import Annotated

import typer

from . import options, text


def report(
    record: options.Record,
    law: options.Law,
    out: Annotated[str, typer.Option("--out", metavar="FILE.html", help="The file to write.", show_default=False)],
    effect: options.Effects = None,
    effect_file: options.EffectFiles = None,
    free_geometry: options.FreeGeometry = False,
    specimen: options.SpecimenFile = None,
) -> None:
    """Write all of it into one offline HTML file."""
    from ..workflow.files import check_target, write_whole

    check_target(out, (".html", ".htm"))
    setup = options.setup(law, effect, effect_file, free_geometry, specimen)
    from ..workflow.report_record import report_record

    page, story = report_record(record, setup, out)
    write_whole(out, page)
    text.say(story.sections[0].diagnosis.sentence, f"report: {out}")
