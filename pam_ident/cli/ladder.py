"""pam-ident ladder."""

from typing import TYPE_CHECKING

from . import options, text

if TYPE_CHECKING:
    from ..diagnosis.nouns import Ladder


def ladder(
    record: options.Record,
    law: options.Law = "auto",
    asked: options.Asked = options.NOTHING,
) -> None:
    """Diagnose and add down to the noise floor."""
    setup = asked.setup(law)
    from ..core import PamError
    from ..schema.diagnosis import ladder_json
    from ..schema.prediction import law_choice_json
    from ..tasks.gate import warnings_of
    from ..tasks.ladder import climb_ladder
    from ..tasks.law_choice import settle

    choice = None
    try:
        measured = setup.read(record)
        setup, choice = settle(measured, setup)
        found = climb_ladder(measured, setup)
    except PamError as stop:
        options.give_stopped(asked.json, record, setup.law, stop, choice)
        raise
    doubts = warnings_of(found.rungs[0].fit)
    options.give_json(asked.json, lambda: ladder_json(record, found, doubts) | law_choice_json(choice))
    text.say(text.title(record, measured), *text.chosen(choice), *text.equation(setup.model), "", *text.banner(doubts))
    text.say(found.last.sentence, "", *rungs(found))
    text.say("", "the last rung's parameters:", *text.parameters(found.rungs[-1].fit))


def rungs(found: "Ladder") -> list[str]:
    """The falling error, a line a rung, and where it stops."""
    rows = [
        (
            str(k),
            " + ".join([rung.fit.model.law.name, *rung.effects]),
            str(len(rung.fit.model.params)),
            text.number(rung.fit.rmse, 3),
            text.number(rung.heldout_rmse, 3),
        )
        for k, rung in enumerate(found.rungs)
    ]
    lines = text.table(("rung", "model", "free parameters", "rmse [N]", "held out [N]"), rows, left=(0, 1))
    return [*lines, f"  noise floor {text.newtons(found.noise_floor)}; {found.verdict}"]
