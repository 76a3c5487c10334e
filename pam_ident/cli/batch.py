"""pam-ident batch."""

from typing import TYPE_CHECKING, Annotated

import typer

from . import options, text

if TYPE_CHECKING:
    from ..batch.run import Batch

MOST_ERRORS = 20
"""Bad records that are told on the screen; the table has all."""


def batch(
    folder: Annotated[
        str, typer.Argument(metavar="FOLDER", help="Tree of CSV records, specimen.toml beside or above each.")
    ],
    out: Annotated[str, options.option("--out", "RESULTS", "Folder for the results.")],
    law: options.Law = "auto",
    effect: options.Effects = None,
    effect_file: options.EffectFiles = None,
    free_geometry: options.FreeGeometry = False,
    diagnose: Annotated[bool, typer.Option("--diagnose", help="Name what each record's model lacks, too.")] = False,
    branch: options.Branch = "together",
    assume: options.Assume = None,
    workers: options.Workers = None,
    scheduler: options.Scheduler = None,
    json: options.JsonFile = None,
) -> None:
    """Fit many muscles: a table and a page that compares them.

    Killed at any moment, the same command goes on where it stopped. Needs the extra `cluster`.
    """
    setup = options.Asked(effect, effect_file, free_geometry, assume=assume).setup(law)
    from ..batch.run import run_batch
    from ..parallel.executor import Executor
    from ..schema.prediction import law_choice_json
    from ..schema.trials import batch_json

    executor = Executor.of_cores(workers, scheduler)
    found = run_batch(folder, setup, out, branch=branch, diagnose=diagnose, executor=executor)
    options.give_json(json, lambda: batch_json(found) | law_choice_json(found.law_choice))
    _print(found)
    if len(found.errors) == found.records:
        raise typer.Exit(4)


def _print(found: "Batch") -> None:
    for record, doubt in list(found.grave.items())[:MOST_ERRORS]:
        text.warn(f"{record}: fitted all the same, but {doubt}")
    bad = list(found.errors.values())
    for message in bad[:MOST_ERRORS]:
        text.warn(message)
    if len(bad) > MOST_ERRORS:
        text.warn(f"and {len(bad) - MOST_ERRORS} more; the table has them all")
    kept = f" ({found.kept} from an earlier run)" if found.kept else ""
    verdicts = ", ".join(f"{count} {name.replace('_', ' ')}" for name, count in sorted(found.verdicts.items()))
    text.say(*text.chosen(found.law_choice))
    text.say(
        f"{found.records} record{'' if found.records == 1 else 's'}{kept}, {len(bad)} with an error",
        *([f"verdicts of the fits: {verdicts}"] if verdicts else []),
        f"table: {found.table}",
        f"page: {found.page}",
    )
