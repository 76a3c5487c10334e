"""pam-ident rig."""

from typing import Annotated

import typer

from . import text


def rig(
    folder: Annotated[str, typer.Argument(metavar="FOLDER", help="Folder to write into.", show_default=False)],
    n: Annotated[int, typer.Option("--n", metavar="N", help="Number of cases.")] = 60,
    seed: Annotated[int, typer.Option("--seed", metavar="SEED", help="Same seed, same set.")] = 1,
    only: Annotated[
        str | None, typer.Option("--only", metavar="KIND", help="Cases of one kind only.", show_default=False)
    ] = None,
) -> None:
    """Write simulated records with hidden physics.

    Their answers are sealed in truth.json, to examine a diagnosis with.
    """
    from ..workflow.write_challenge import write_challenge

    count = write_challenge(folder, n, seed, only, lambda line: typer.echo(line, err=True))
    text.say(f"{count} cases in {folder}, answers in truth.json")
