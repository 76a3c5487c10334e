"""pam-ident against."""

from dataclasses import replace
from typing import Annotated

import typer

from . import options, text


def against(
    a: Annotated[str, typer.Argument(metavar="A", help="A record, or the name of a data set.", show_default=False)],
    b: Annotated[str, typer.Argument(metavar="B", help="The record beside it.", show_default=False)],
    law: options.Law = "auto",
    asked: options.Asked = options.NOTHING,
    out: Annotated[str | None, options.option("--out", "FILE.html", "Write a page about both, too.")] = None,
) -> None:
    """Compare two records: new and aged, two muscles, two rigs.

    Tells what differs in force, in parameters with intervals, in the effects that are missing, and in what the law's
    error follows.
    """
    if out is not None:
        from ..core.files import check_target

        check_target(out, (".html",))
    setup = asked.setup(law)
    from ..core import UsageError
    from ..core.files import write_whole
    from ..report.against import effects_table, parameters_table, records_table
    from ..schema.against import against_json
    from ..schema.prediction import law_choice_json
    from ..tasks.against import against_page, against_records
    from ..tasks.gate import warnings_of

    given = {a: setup.read(a), b: setup.read(b)}
    if len(given) < 2:
        raise UsageError(f"{a} against itself; name another record")
    found, choice = against_records(given[a], given[b], setup)
    doubts = [*warnings_of(found.fits[0]), *warnings_of(found.fits[1])]
    options.give_json(asked.json, lambda: against_json(a, b, found, doubts) | law_choice_json(choice))
    if out is not None:
        taken = setup if choice is None else replace(setup, law=choice.law)
        write_whole(out, against_page(found, given, taken.command("against", (a, b), "--out", out)))
    text.say(*(text.title(path, record) for path, record in given.items()), *text.chosen(choice), "")
    text.say(*text.banner(doubts), found.sentence)
    for one in (records_table(found), effects_table(found), parameters_table(found)):
        words = [k for k in range(len(one.head)) if k not in one.numeric]
        if one.rows:
            text.say("", f"{one.caption}:", *text.table(one.head, one.rows, words))
    if out is not None:
        text.say("", f"page: {out}")
    problems = [*found.fits[0].problems, *found.fits[1].problems]
    options.stop_if_invalid(f"{a}, {b}", problems)
