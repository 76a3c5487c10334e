"""pam-ident batch."""

import sys
import time
from typing import TYPE_CHECKING, Annotated

import typer

from . import options, text

if TYPE_CHECKING:
    from ..workflow.batch import Batch, Progress

MOST_ERRORS = 20
"""Bad records that are told on the screen; the table has all."""


def batch(
    folder: Annotated[
        str, typer.Argument(metavar="FOLDER", help="Tree of CSV records, specimen.toml beside or above each.")
    ],
    law: options.Law,
    out: Annotated[str, typer.Option("--out", metavar="RESULTS", help="Folder for the results.", show_default=False)],
    effect: options.Effects = None,
    effect_file: options.EffectFiles = None,
    free_geometry: options.FreeGeometry = False,
    diagnose: Annotated[bool, typer.Option("--diagnose", help="Name what each record's model lacks, too.")] = False,
    branch: Annotated[
        str, typer.Option("--branch", metavar="BRANCH", help="together, separate, contraction or extension.")
    ] = "together",
    workers: Annotated[
        int | None, typer.Option("--workers", metavar="N", help="Records at a time; default: the cores.")
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(
            "--scheduler", metavar="ADDRESS", help="Dask scheduler, tcp://HOST:PORT, instead.", show_default=False
        ),
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", help="Show no progress.")] = False,
) -> None:
    """Fit many muscles: a table and a page that compares them.

    Killed at any moment, the same command goes on where it stopped. Needs the extra `cluster`.
    """
    from ..core import UsageError

    if scheduler is not None and workers is not None:
        raise UsageError("--workers with --scheduler: the cluster has its own workers; give one of the two")
    setup = options.setup(law, effect, effect_file, free_geometry, None)
    from ..workflow.batch import run_batch

    shown = not quiet and sys.stderr.isatty()
    found = run_batch(
        folder,
        setup,
        out,
        branch=branch,
        diagnose=diagnose,
        workers=workers,
        scheduler=scheduler,
        tell=_Clock().show if shown else _hide,
        note=lambda line: typer.echo(line, err=True),
    )
    _print(found)
    if len(found.errors) == found.records:
        raise typer.Exit(4)


def _hide(progress: "Progress") -> None:
    pass


class _Clock:
    """Progress with the time left, on one line that is written over."""

    def __init__(self) -> None:
        self.begin = time.monotonic()

    def show(self, progress: "Progress") -> None:
        """One line on stderr, its end only when all is done."""
        fresh, left = progress.done - progress.kept, progress.of - progress.done
        line = f"{progress.done} of {progress.of} records"
        if fresh and left:
            line += f", {duration(left * (time.monotonic() - self.begin) / fresh)} left"
        typer.echo(f"\r{line:<40}", nl=not left, err=True)


def duration(seconds: float) -> str:
    """A time in the unit in which it is read: s, min or h."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"


def _print(found: "Batch") -> None:
    bad = list(found.errors.values())
    for message in bad[:MOST_ERRORS]:
        typer.echo(message, err=True)
    if len(bad) > MOST_ERRORS:
        typer.echo(f"and {len(bad) - MOST_ERRORS} more; the table has them all", err=True)
    kept = f" ({found.kept} from an earlier run)" if found.kept else ""
    text.say(
        f"{found.records} record{'' if found.records == 1 else 's'}{kept}, {len(bad)} with an error",
        f"table: {found.table}",
        f"page: {found.page}",
    )
