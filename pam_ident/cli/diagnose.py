"""pam-ident diagnose."""

from typing import TYPE_CHECKING, Annotated

import typer

from . import options, text

if TYPE_CHECKING:
    from ..diagnosis.nouns import Diagnosis

STATUS = {"absorbed_by_law": "absorbed by the law", "not_excited": "not shown by this record"}


def diagnose(
    record: Annotated[
        list[str],
        typer.Argument(metavar="RECORD...", help="CSV records of a test rig, one or several.", show_default=False),
    ],
    law: options.Law,
    effect: options.Effects = None,
    effect_file: options.EffectFiles = None,
    free_geometry: options.FreeGeometry = False,
    specimen: options.SpecimenFile = None,
    json: options.JsonFile = None,
) -> None:
    """Say which effect is missing, or that none is.

    Several records get an answer each.
    """
    options.check_json(json)
    setup = options.setup(law, effect, effect_file, free_geometry, specimen)
    from ..workflow.diagnose_records import diagnose_records
    from ..workflow.files import write_json, write_json_lines
    from ..workflow.to_json import diagnosis_json

    answers, code = [], 0
    for path, found in diagnose_records(record, setup):
        if isinstance(found, Exception):
            typer.echo(" ".join(str(found).split()), err=True)
            code = max(code, found.exit_code)
            continue
        answers.append(diagnosis_json(path, found))
        text.say(*([""] if len(answers) > 1 else []), text.title(path, found.base.record), *describe(found))
    if json is not None and len(record) == 1:
        for answer in answers:
            write_json(json, answer)
    elif json is not None:
        write_json_lines(json, answers)
    if code:
        raise typer.Exit(code)


def describe(found: "Diagnosis") -> list[str]:
    """A diagnosis in words and a table of the suspects."""
    lines = [
        found.sentence,
        f"verdict {found.verdict}: error {text.newtons(found.base.rmse)} → {text.newtons(found.best.rmse)} "
        f"(held out {text.newtons(found.heldout_rmse)} → {text.newtons(found.heldout_rmse_after)}), "
        f"noise floor {text.newtons(found.noise_floor)}",
    ]
    lines += [f"cannot be told apart here: {', '.join(group)}" for group in found.groups if len(group) > 1]
    rows = [
        (
            s.label or s.effect,
            text.percent(s.probability),
            text.number(s.rmse_after, 3),
            text.number(s.heldout_rmse_after, 3),
        )
        for s in found.ranking
        if s.status == "candidate"
    ]
    lines += text.table(("suspect", "probability", "rmse after [N]", "held out [N]"), rows)
    for status, words in STATUS.items():
        names = [s.effect for s in found.ranking if s.status == status]
        if names:
            lines.append(f"{words}: {', '.join(names)}")
    if found.pattern is not None:
        lines.append(f"left over: {found.pattern.text}")
    if found.next_experiment is not None:
        lines.append(f"next experiment: {found.next_experiment.text}")
    return lines
