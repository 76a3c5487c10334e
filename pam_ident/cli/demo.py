"""pam-ident demo."""

from typing import TYPE_CHECKING, Annotated

import typer

from . import options, text
from .ladder import rungs

if TYPE_CHECKING:
    from ..tasks.demo import DemoPart


def demo(
    out: Annotated[str, typer.Option("--out", "-o", metavar="DIR", help="Folder for the report; it is made.")] = (
        "pam-ident-demo"
    ),
    json: options.JsonFile = None,
) -> None:
    """The whole job on the bundled data, to an HTML report."""
    from ..schema.trials import demo_json
    from ..tasks.demo import demo as run

    found = run(out, _tell)
    options.give_json(json, lambda: demo_json(found))
    text.say(f"report: {found.path}")


def _tell(stage: "DemoPart") -> None:
    from ..tasks.ladder import why_it_ends

    record = stage.section.record
    text.say(f"{stage.data_set}: {stage.about}", f"  {len(record)} samples, {len(record.levels)} pressures")
    text.say(*rungs(stage.ladder), f"  {why_it_ends(stage.ladder)}")
    text.say(*(f"  {one}" for one in stage.ladder.rungs[-1].fit.at_bounds), "")
