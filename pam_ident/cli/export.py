"""pam-ident export."""

from typing import Annotated

import typer

from ..schema.versions import schema
from . import options, text


def export(
    source: Annotated[
        str,
        typer.Argument(
            metavar="FIT.json|RECORD",
            help="What `fit --json` or `ladder --json` wrote, or with --law a record that is fitted now.",
            show_default=False,
        ),
    ],
    to: Annotated[
        str, typer.Option("--to", metavar="KIND", help="c, matlab, python, mujoco or json.", show_default=False)
    ],
    out: Annotated[
        str,
        typer.Option(
            "--out",
            metavar="FILE",
            help="The file to write (.h, .m, .py, .xml, .json); its name names the function in it.",
            show_default=False,
        ),
    ],
    law: Annotated[
        str | None,
        typer.Option(
            "--law",
            metavar="LAW",
            help="Force law to fit to a record, by name.",
            show_default=False,
            autocompletion=options.law_names,
        ),
    ] = None,
    branch: Annotated[
        str, typer.Option("--branch", metavar="BRANCH", help="together, separate, contraction or extension.")
    ] = "together",
    effect: options.Effects = None,
    effect_file: options.EffectFiles = None,
    free_geometry: options.FreeGeometry = False,
    specimen: options.SpecimenFile = None,
    json: options.JsonFile = None,
) -> None:
    """Write a fitted model for another program: C, MATLAB, Python, MuJoCo, JSON."""
    options.check_json(json)
    from ..core import UsageError
    from ..tasks.export import check_export, export_fit, export_record

    check_export(to, out)
    if law is not None:
        found = export_record(source, to, out, options.setup(law, effect, effect_file, free_geometry, specimen), branch)
    elif effect or free_geometry or branch != "together":
        raise UsageError("--effect, --branch and --free-geometry are for a record that is fitted now; add --law LAW")
    else:
        found = export_fit(source, to, out, tuple(effect_file or ()), specimen)
    files = [str(path) for path in found.paths]
    options.give_json(
        json,
        lambda: {
            "schema": schema("export"),
            "files": files,
            "notes": list(found.notes),
            "problems": list(found.problems),
        },
    )
    text.say(*(f"wrote {path}" for path in files), *found.notes)
    if found.problems:
        typer.echo(f"{source}: the fit is not valid. {'; '.join(found.problems)}", err=True)
        raise typer.Exit(3)
