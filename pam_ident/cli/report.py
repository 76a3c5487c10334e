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
    json: options.JsonFile = None,
) -> None:
    """Write all of it into one offline HTML file."""
    from ..workflow.files import check_target, write_whole

    options.check_json(json)
    check_target(out, (".html", ".htm"))
    setup = options.setup(law, effect, effect_file, free_geometry, specimen)
    from ..workflow.report_record import report_record
    from ..workflow.to_json import diagnosis_json

    page, story = report_record(record, setup, out)
    write_whole(out, page)
    options.give_json(json, lambda: diagnosis_json(record, story.sections[0].diagnosis))
    text.say(story.sections[0].diagnosis.sentence, f"report: {out}")
