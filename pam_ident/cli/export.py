"""pam-ident export."""

from typing import Annotated

import typer

from ..export import targets
from ..schema.versions import schema
from . import options, text


def export(
    source: Annotated[
        str,
        typer.Argument(
            metavar="FIT.json|RECORD",
            help="What `fit --json`, `add --json` or `ladder --json` wrote, or a record that is fitted now.",
            show_default=False,
        ),
    ],
    to: Annotated[str, options.option("--to", "KIND", f"{', '.join(targets.names())} or json.")],
    out: Annotated[
        str,
        options.option(
            "--out", "FILE", "The file to write, such as muscle.h for c; its name names the function in it."
        ),
    ],
    law: Annotated[
        str | None,
        options.option("--law", "LAW", "Force law to fit to a record, by name.", autocompletion=options.law_names),
    ] = None,
    branch: options.Branch = "together",
    asked: options.Asked = options.NOTHING,
) -> None:
    """Write a fitted model as C, FMU, MATLAB, Python, MuJoCo, JSON."""
    from ..core import UsageError
    from ..tasks.export import check_export, export_fit, export_record

    check_export(to, out)
    if law is not None or not source.lower().endswith(".json"):
        found = export_record(source, to, out, asked.setup(law or "auto"), branch)
    elif asked.effect or asked.free_geometry or asked.where is not None or branch != "together":
        raise UsageError(
            "--effect, --branch, --where and --free-geometry are for a record that is fitted now; add --law LAW"
        )
    else:
        found = export_fit(source, to, out, tuple(asked.effect_file or ()), asked.specimen)
    files = [str(path) for path in found.paths]
    options.give_json(
        asked.json,
        lambda: {
            "schema": schema("export"),
            "files": files,
            "notes": list(found.notes),
            "problems": list(found.problems),
        },
    )
    text.say(*(f"wrote {path}" for path in files), *found.notes)
    options.stop_if_invalid(source, found.problems)
