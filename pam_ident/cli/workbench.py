"""pam-ident workbench."""

from typing import Annotated

import typer

from ..schema.versions import schema
from . import options, text


def workbench(
    record: Annotated[
        str | None, typer.Argument(metavar="RECORD", help="Record to begin with.", show_default=False)
    ] = None,
    law: options.Law = "auto",
    effect: options.Effects = None,
    effect_file: options.EffectFiles = None,
    free_geometry: options.FreeGeometry = False,
    specimen: options.SpecimenFile = None,
    port: Annotated[int, typer.Option("--port", metavar="PORT", help="0 takes any that is free.")] = 5006,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Open no browser; the address is printed.")] = False,
    json: options.JsonFile = None,
    where: options.Where = None,
) -> None:
    """Try effects on a record by hand, on a page in the browser.

    Needs the extra `workbench`. Ends with Ctrl-C.
    """
    setup = options.Asked(effect, effect_file, free_geometry, specimen, where=where).setup(law)
    from ..core import UsageError
    from ..tasks.law_choice import begin

    setup, choice = begin(None if record is None else setup.read(record), setup)

    try:
        from ..workbench import Workbench, serve
        from ..workbench.history import History
    except ImportError:
        raise UsageError("the workbench needs Panel; pip install 'pam-ident[workbench]'") from None

    def ready(address: str) -> None:
        options.give_json(json, lambda: {"schema": schema("workbench"), "address": address})
        text.say(f"workbench: {address} (Ctrl-C ends it)", *text.chosen(choice))

    def make(history: History) -> Workbench:
        return Workbench(record, setup.law, setup.effects, setup.effect_files, specimen, free_geometry, history, where)

    serve(make, port, not no_browser, ready)
