"""pam-ident predict."""

from typing import Annotated

from . import options, text
from .validate import FitFile


def predict(
    fit: FitFile,
    at: Annotated[
        str,
        options.option(
            "--at",
            "FILE",
            "States, a row each, in columns as of a record: pressure; contraction, displacement or length; and where "
            "effects need them branch, time, cycle, temperature.",
        ),
    ],
    out: Annotated[str | None, options.option("--out", "FILE.csv", "Where the table goes; default: stdout.")] = None,
    effect_file: options.EffectFiles = None,
    specimen: options.SpecimenFile = None,
    json: options.JsonFile = None,
) -> None:
    """Force of a saved fit at given states, with 95 % intervals.

    Intervals for the mean and for a new reading, as CSV. Where the states hold a force and no length, the length at
    which the muscle carries it.
    """
    from ..core.files import check_target, write_whole

    if out is not None:
        check_target(out, (".csv",))
    from ..records import read_specimen
    from ..schema.prediction import prediction_json
    from ..tasks.predict import predict_at, read_fit

    saved = read_fit(fit, tuple(effect_file or ()), None if specimen is None else read_specimen(specimen))
    found = predict_at(saved, at)
    frame = found.frame
    options.give_json(json, lambda: prediction_json(fit, saved, frame))
    table = frame.to_csv(index=False, float_format="%.8g", lineterminator="\n")
    if out is None:
        text.say_table(table)
    else:
        write_whole(out, table)
        text.say(f"{len(frame)} rows: {out}")
    for one in found.warnings:
        text.warn(one)
