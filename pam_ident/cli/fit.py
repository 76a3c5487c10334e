"""pam-ident fit."""

from typing import TYPE_CHECKING, Annotated

import typer

from . import options, text

if TYPE_CHECKING:
    from ..fitting import IsobarTable
    from ..workflow.fit_record import FitAnswer


def fit(
    record: options.Record,
    law: options.Law,
    branch: Annotated[
        str, typer.Option("--branch", metavar="BRANCH", help="together, separate, contraction or extension.")
    ] = "together",
    method: Annotated[
        str,
        typer.Option("--method", metavar="METHOD", help="global, or two-stage: each isobar alone, then over pressure."),
    ] = "global",
    effect: options.Effects = None,
    effect_file: options.EffectFiles = None,
    free_geometry: options.FreeGeometry = False,
    specimen: options.SpecimenFile = None,
    json: options.JsonFile = None,
    figures: Annotated[
        str | None,
        typer.Option(
            "--figures",
            metavar="DIR",
            help="Folder for SVG figures of the isobars, the fit, other laws and the coefficients; it is made.",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Fit a law: parameters with standard errors."""
    options.check_json(json)
    if figures is not None:
        from ..workflow.paper_figures import make_folder

        make_folder(figures)
    setup = options.setup(law, effect, effect_file, free_geometry, specimen)
    from ..workflow.fit_record import check_choice, fit_record

    check_choice(branch, method)
    measured = setup.read(record)
    answer = fit_record(measured, setup, branch, method)
    if json is not None:
        from ..workflow.files import write_json
        from ..workflow.to_json import fit_json

        write_json(json, fit_json(record, law, answer))
    text.say(text.title(record, measured), *text.equation(setup.model))
    _print(answer)
    if figures is not None:
        from ..workflow.paper_figures import paper_figures, write_figures

        text.say("", *(f"figure: {path}" for path in write_figures(figures, paper_figures(answer))))
    if answer.problems:
        typer.echo(f"{record}: the fit is not valid. {'; '.join(answer.problems)}", err=True)
        raise typer.Exit(3)


def _print(answer: "FitAnswer") -> None:
    for branch, one in answer.fits.items():
        name = "both branches together" if branch == "together" else branch
        if answer.isobars is not None:
            name += (
                ", from straight lines through the isobars" if branch in answer.two_stage else ", all isobars at once"
            )
        text.say("", f"{name}: {text.quality(one)}", *text.parameters(one))
    if answer.isobars is not None:
        _print_isobars(answer.isobars)
    for warning in answer.warnings:
        text.say("", f"Warning: {warning}")


def _print_isobars(isobars: "IsobarTable") -> None:
    for branch in dict.fromkeys(row.branch for row in isobars.rows):
        rows = [row for row in isobars.rows if row.branch == branch]
        head = [f"{e.name} [{e.unit}]" if e.unit != "1" else e.name for e in text.in_order(rows[0].estimates)]
        cells = [
            (
                f"{row.pressure_MPa:g}",
                *(f"{text.value_of(e)} {text.error_of(e)}" for e in text.in_order(row.estimates)),
                text.number(row.rmse, 3),
            )
            for row in rows
        ]
        name = "both branches together" if branch == "together" else branch
        text.say("", f"each isobar alone, {name}:")
        text.say(*text.table(("p [MPa]", *head, "rmse [N]"), cells))
        if branch in isobars.correlation:
            pairs = ", ".join(f"{key} {text.number(r, 5)}" for key, r in isobars.correlation[branch].items())
            text.say(f"  correlation with pressure: {pairs}")
