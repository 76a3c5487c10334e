"""pam-ident ladder."""

from dataclasses import replace
from typing import TYPE_CHECKING

from . import options, text

if TYPE_CHECKING:
    from ..diagnosis.nouns import Ladder

BESIDE = 5
"""Laws alone that are shown, the best on held-out data."""


def ladder(
    record: options.Record,
    law: options.Law = "auto",
    asked: options.Asked = options.NOTHING,
    without: options.Without = None,
    only: options.Only = None,
    also: options.Also = None,
    heldout: options.Heldout = None,
) -> None:
    """Diagnose and add down to the noise floor."""
    setup = replace(asked.setup(law), heldout=options.held_out(heldout), **options.tried(without, only, also))
    setup.check()
    from ..core import PamError
    from ..parallel.executor import Executor
    from ..schema.diagnosis import ladder_json
    from ..schema.prediction import law_choice_json
    from ..tasks.gate import warnings_of
    from ..tasks.ladder import climb_ladder, why_it_ends
    from ..tasks.law_choice import settle

    choice = None
    try:
        measured = setup.read(record)
        setup, choice = settle(measured, setup, naming=True)
        found = climb_ladder(measured, setup, Executor.of_cores())
    except PamError as stop:
        options.give_stopped(asked.json, record, setup.law, stop, choice)
        raise
    doubts = warnings_of(found.rungs[-1].fit)
    options.give_json(asked.json, lambda: ladder_json(record, found, doubts) | law_choice_json(choice))
    text.say(
        text.title(record, measured),
        *text.chosen(choice),
        *text.equation(found.rungs[0].fit.model),
        "",
        *text.banner(doubts),
    )
    last = found.rungs[-1].fit
    text.say(why_it_ends(found), *last.at_bounds, "", *rungs(found))
    if last.model.params:
        text.say("", "parameters of the last step:", *text.parameters(last))
    options.stop_if_invalid(record, last.problems)


def rungs(found: "Ladder") -> list[str]:
    """The falling error, a line a step, and where it stops."""
    from ..effects import named
    from ..tasks.ladder import steps

    carried = found.rungs[0].fit.record.carried
    names = steps((rung.fit.model for rung in found.rungs), named)
    rows = [
        (
            str(k),
            name.replace("\n", ", "),
            str(len(rung.fit.model.params)),
            text.number(rung.fit.rmse, 3),
            *((text.number(rung.rmse_mm, 3),) if carried else ()),
            *((text.number(rung.refit_rmse, 3),) if found.nested else ()),
            text.number(rung.heldout_rmse, 3),
        )
        for k, (name, rung) in enumerate(zip(names, found.rungs, strict=True))
    ]
    head = ("step", "model", "parameters", "rmse [N]", *(("of the length [mm]",) if carried else ()))
    floor = f"  noise {text.newtons(found.noise_floor)}; verdict: {text.verdict(found.verdict)}"
    if found.nested is None:
        return [*text.table((*head, "held out [N]"), rows, left=(0, 1)), floor]
    rows += [
        ("law alone", name, str(count), "", *(("",) if carried else ()), "", text.number(error, 3))
        for name, (count, error) in list(found.nested.beside.items())[:BESIDE]
    ]
    return [
        *text.table((*head, "held out", "all anew"), rows, left=(0, 1)),
        floor,
        f"  {found.nested.text}",
    ]
