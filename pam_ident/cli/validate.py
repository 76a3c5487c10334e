"""pam-ident validate."""

from typing import Annotated

import typer

from . import options, text

FitFile = Annotated[
    str,
    typer.Argument(
        metavar="FIT.json",
        help="What `fit --json`, `add --json` or `ladder --json` wrote; of a ladder the last step.",
        show_default=False,
    ),
]


def validate(
    fit: FitFile,
    record: options.Record,
    effect_file: options.EffectFiles = None,
    specimen: options.SpecimenFile = None,
    json: options.JsonFile = None,
    where: options.Where = None,
) -> None:
    """Test a saved fit on another record, beside simpler models.

    Tells its errors, and how many readings lie in its intervals.
    """
    from ..schema.prediction import validation_json
    from ..tasks.predict import read_fit
    from ..tasks.setup import load
    from ..tasks.validate import SIMPLER, validate_fit

    saved = read_fit(fit, tuple(effect_file or ()))
    measured = load(record, specimen, where)
    found = validate_fit(saved, measured)
    options.give_json(json, lambda: validation_json(fit, record, found))
    text.say(text.title(record, measured), *text.equation(saved.model), "", *text.banner(found.warnings))
    text.say(found.sentence, "")
    rows = [
        (name, text.number(one.rmse, 3), text.number(one.max_error, 3), text.number(one.r2, 5))
        for name, one in [(f"the fit of {fit}", found.trial), *((SIMPLER[k], v) for k, v in found.simpler.items())]
    ]
    unit = "mm" if found.in_mm else "N"
    text.say(*text.table(("model", f"rmse [{unit}]", f"largest error [{unit}]", "R²"), rows))
    if found.in_force is not None:
        text.say(f"the force at the measured length: rmse {text.newtons(found.in_force.rmse)}")
    if found.left_out:
        text.say(f"{found.left_out} samples at the end of the length are left out: the pressure does not move it there")
    if found.outside > 0:
        text.say(
            f"{text.percent(found.outside)} of the readings lie outside the pressures or contractions that were fitted"
        )
