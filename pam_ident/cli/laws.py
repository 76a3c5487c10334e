"""pam-ident laws."""

from typing import Annotated

import typer

from . import options, text


def laws(
    name: Annotated[
        str | None,
        typer.Argument(metavar="NAME", help="One law, in full.", autocompletion=options.law_names, show_default=False),
    ] = None,
    json: options.JsonFile = None,
) -> None:
    """List the force laws; `laws NAME` tells all about one."""
    from ..laws import get_law, listed
    from ..schema.catalogue import laws_json

    found = listed() if name is None else (get_law(name),)
    options.give_json(json, lambda: laws_json(found))
    for law in found:
        names = ", ".join(p.name for p in law.params)
        text.say(
            f"{law.name}: {law.title}",
            f"{text.INDENT}{law.formula}",
            f"{text.INDENT}{len(law.params)} parameters{f': {names}' if names else ''}",
            f"{text.INDENT}source: {law.source}",
        )
        if name is not None:
            text.say(*text.meanings(law.params))
            if law.min_levels > 1:
                text.say(f"{text.INDENT}needs {law.min_levels} pressures at least to tell its parameters apart")
