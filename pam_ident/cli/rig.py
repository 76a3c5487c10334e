"""pam-ident rig."""

from typing import Annotated

import typer

from ..schema.versions import schema
from . import options, text


def rig(
    folder: Annotated[str, typer.Argument(metavar="FOLDER", help="Folder to write into.", show_default=False)],
    n: Annotated[int, typer.Option("--n", metavar="N", help="Number of cases.")] = 60,
    seed: Annotated[int, typer.Option("--seed", metavar="SEED", help="Same seed, same set.")] = 1,
    only: Annotated[str | None, options.option("--only", "KIND", "Cases of one kind only.")] = None,
    protocol: Annotated[
        str | None,
        options.option(
            "--protocol", "FILE.toml", "One record of this protocol instead, such as `diagnose --protocol` writes."
        ),
    ] = None,
    law: Annotated[str | None, options.option("--law", "LAW", "With --protocol: the muscle's law.")] = None,
    effect: Annotated[
        list[str] | None, options.option("--effect", "NAME[:FORM]", "With --protocol: effect to hide; repeatable.")
    ] = None,
    size: Annotated[
        float | None,
        options.option(
            "--size",
            "R",
            "With --protocol: what each effect leaves in the standard protocol, in multiples of the noise (3).",
        ),
    ] = None,
    repeat: Annotated[
        int | None,
        options.option(
            "--repeat", "N", "With --protocol: the run N times over, each of the rested muscle, with fresh noise (1)."
        ),
    ] = None,
    json: options.JsonFile = None,
) -> None:
    """Write simulated records with hidden physics.

    Their answers are sealed in truth.json, to examine a diagnosis with. With --protocol one record is written, with the
    effects that --effect names; the same seed is the same muscle whatever the protocol.
    """
    from ..core import UsageError

    if protocol is None:
        given = [
            name
            for name, value in (("--law", law), ("--effect", effect), ("--size", size), ("--repeat", repeat))
            if value
        ]
        if given:
            raise UsageError(f"{', '.join(given)} without --protocol FILE.toml; add it, or leave {given[0]} out")
        from ..validation.challenge import write_challenge

        count = write_challenge(folder, n, seed, only)
        options.give_json(json, lambda: {"schema": schema("rig"), "folder": folder, "cases": count})
        text.say(f"{count} cases in {folder}, answers in truth.json")
        return
    if only is not None or law is None:
        raise UsageError("--protocol makes one record of one muscle: give its --law, and no --only")
    from ..tasks.rig import run_protocol

    times = 1 if repeat is None else repeat
    truth = run_protocol(folder, protocol, law, effect or (), seed, 3.0 if size is None else size, times)
    options.give_json(json, lambda: {"schema": schema("rig"), "folder": folder, "cases": 1})
    text.say(f"{folder}/record.csv: {truth['n']} samples, answers in truth.json")
