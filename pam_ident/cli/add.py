"""pam-ident add."""

import math
from dataclasses import replace
from typing import Annotated

from . import options, text


def add(
    record: options.Record,
    effect: Annotated[
        list[str],
        options.option(
            "--effect", "NAME", "Effect to add, NAME or NAME:FORM; repeatable.", autocompletion=options.effect_names
        ),
    ],
    law: options.Law = "auto",
    effect_file: options.EffectFiles = None,
    free_geometry: options.FreeGeometry = False,
    specimen: options.SpecimenFile = None,
    json: options.JsonFile = None,
    where: options.Where = None,
    heldout: options.Heldout = None,
) -> None:
    """Add effects: the error before and after.

    Both are shown on held-out data, too.
    """
    setup = options.Asked(effect, effect_file, free_geometry, specimen, where=where).setup(law)
    setup = replace(setup, heldout=options.held_out(heldout))
    from ..schema.diagnosis import addition_json
    from ..schema.prediction import law_choice_json
    from ..tasks.add import add_effects
    from ..tasks.law_choice import settle

    measured = setup.read(record)
    setup, choice = settle(measured, setup)
    found = add_effects(measured, setup)
    options.give_json(json, lambda: addition_json(record, found) | law_choice_json(choice))
    before, after = found.before, found.after
    names = " + ".join(effect.title for effect in after.model.own)
    text.say(text.title(record, measured), *text.chosen(choice), *text.equation(after.model), "")
    text.say(*text.banner(found.warnings))
    held = f"on held-out data from {text.newtons(found.heldout_before)} to {text.newtons(found.heldout_after)}, "
    text.say(
        f"With {names} the error goes from {text.newtons(before.rmse)} to {text.newtons(after.rmse)}, "
        f"{held * math.isfinite(found.heldout_before)}the largest error from "
        f"{text.newtons(before.max_error)} to {text.newtons(after.max_error)}; {len(before.model.params)} free "
        f"parameters become {len(after.model.params)}.",
        "",
    )
    text.say(*text.parameters(after))
    for term in after.model.terms:
        richer = [f"{term.effect.name}:{form.name}" for form in term.effect.forms if form is not term.form]
        if richer:
            text.say(f"  other forms: {', '.join(richer)}")
    options.stop_if_invalid(record, after.problems)
