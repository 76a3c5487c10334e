"""pam-ident diagnose."""

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated

import typer

from . import options, text

if TYPE_CHECKING:
    from ..diagnosis.nouns import Diagnosis, Experiment

SHOWN, LEAST = 5, 0.01
"""Candidates that have a row of their own: so many, and all of such a probability."""
TAKEN_UP = (
    "The law was chosen because it predicts best. What its parameters take up is not seen as an effect: to ask what "
    "the ideal braid lacks, say --law chou_hannaford."
)

ANOTHER_LAW = (
    "What follows pressure and contraction alike on both branches may be what this law lacks: leave --law out, and all "
    "laws are compared."
)


def diagnose(
    record: Annotated[
        list[str],
        typer.Argument(
            metavar="RECORD",
            help="Records of a test rig, as for the other commands; one or several.",
            show_default=False,
        ),
    ],
    law: options.Law = "auto",
    asked: options.Asked = options.NOTHING,
    without: options.Without = None,
    only: options.Only = None,
    also: options.Also = None,
    prior: Annotated[
        str | None, options.option("--prior", "FILE.toml", "Prior odds of effects, lines such as `creep = 10`.")
    ] = None,
    protocol: Annotated[
        str | None,
        options.option(
            "--protocol", "FILE.toml", "Write the next experiment's protocol, for `rig --protocol`; one record only."
        ),
    ] = None,
    heldout: options.Heldout = None,
) -> None:
    """Say which effect is missing, or that none is.

    Several records get an answer each.
    """
    if protocol is not None:
        check_protocol(protocol, record)
    tried = options.tried(without, only, also)
    setup = replace(asked.setup(law), prior=prior, heldout=options.held_out(heldout), **tried)
    from ..core.files import write_json, write_json_lines
    from ..schema.diagnosis import diagnosis_json, stopped_json
    from ..schema.prediction import law_choice_json
    from ..tasks.diagnose import diagnose_records, fit_command
    from ..tasks.gate import warnings_of

    answers, code = [], 0
    for path, found, choice in diagnose_records(record, setup):
        if isinstance(found, Exception):
            text.warn(" ".join(str(found).split()))
            code = max(code, found.exit_code)
            taken, n = law if choice is None else choice.law, getattr(found, "n", 0)
            answers.append(stopped_json(path, taken, n, options.reasons(found)) | law_choice_json(choice))
            continue
        doubts = warnings_of(found.base)
        command = fit_command(found, path, setup)
        answers.append(diagnosis_json(path, found, doubts, command) | law_choice_json(choice))
        text.say(*([""] if len(answers) > 1 else []), text.title(path, found.base.record), *text.chosen(choice))
        text.say(*text.banner(doubts), *describe(found), *([f"fit it: {command}"] if found.selected else []))
        if found.selected and found.best.problems:
            text.say(f"that fit is not valid: {'; '.join(found.best.problems)}")
        if choice is not None and choice.law != "chou_hannaford" and found.verdict == "adequate":
            text.say(TAKEN_UP)
        if choice is None and found.verdict == "unknown_effect" and found.follows and found.follows[0].what == "map":
            text.say(ANOTHER_LAW)
        if protocol is not None:
            text.say(write_protocol(protocol, found.next_experiment))
    if asked.json is not None and len(record) == 1:
        for answer in answers:
            write_json(asked.json, answer)
    elif asked.json is not None:
        write_json_lines(asked.json, answers)
    if code:
        raise typer.Exit(code)


def check_protocol(path: str, records: list[str]) -> None:
    """Raises UsageError before anything is computed: for several records, or a protocol file that cannot be written."""
    from ..core import UsageError
    from ..core.files import check_target

    if len(records) > 1:
        raise UsageError(f"--protocol {path}: one file for {len(records)} records; give one record")
    check_target(path, (".toml",))


def write_protocol(path: str, experiment: "Experiment | None") -> str:
    """Write the next experiment's protocol where it has one; a line that says so, or why not."""
    if experiment is None or experiment.protocol is None:
        return "no protocol written: " + (
            "nothing is open here" if experiment is None else "no run of strokes decides it"
        )
    from ..core.files import write_whole

    write_whole(path, experiment.protocol.toml(experiment.text))
    return f"protocol: {path}"


def describe(found: "Diagnosis") -> list[str]:
    """A diagnosis in words, and a table of the candidates where something is missing."""
    from ..effects import in_words
    from ..schema.diagnosis import STATUS
    from ..tasks.diagnose import candidates, told

    held = f"on held-out data {text.newtons(found.heldout_rmse)}"
    held += f" → {text.newtons(found.heldout_rmse_after)}" if found.selected else ""
    held = "no data could be held out" if math.isnan(found.heldout_rmse) else held
    beside = " beside what is named" if found.verdict == "unknown_effect" and found.selected else ""
    lines = [found.sentence, f"verdict: {text.verdict(found.verdict)}{beside}; {held}"]
    lines += [*found.best.at_bounds, told(found.follows)]
    tried = candidates(found)
    shown = [s for k, s in enumerate(tried) if k < SHOWN or s.probability >= LEAST]
    rows = [
        (
            s.label or s.effect,
            text.probability(s.probability),
            text.number(s.rmse_after, 3),
            text.number(s.heldout_rmse_after, 3),
        )
        for s in shown
    ]
    kind = found.base.record.block_kind
    lines += text.table(("candidate", "probability", "alone leaves [N]", f"held out, each {kind} [N]"), rows)
    alike = ", or of one that this record cannot tell from it" if found.groups else ""
    lines += [f"each probability is of the effect by itself{alike}; they need not add up to 100 %"] * bool(rows)
    others = [in_words(s.effect, found.best.model.own) for s in tried if s not in shown]
    lines += [f"less likely still: {', '.join(others)}"] if others else []
    for status, words in STATUS.items():
        names = [in_words(s.effect, found.best.model.own) for s in found.ranking if s.status == status]
        if names and status != "candidate":
            lines.append(f"{words}: {', '.join(names)}")
    if found.next_experiment is not None:
        lines.append(f"next experiment: {found.next_experiment.text}")
    return lines
