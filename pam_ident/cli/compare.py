"""pam-ident compare."""

from typing import TYPE_CHECKING, Annotated

from . import options, text

if TYPE_CHECKING:
    from ..diagnosis.nouns import Comparison

HEADS = {
    "load_N": "by weight",
    "pressure_MPa": "by pressure",
    "contraction": "by contraction",
    "branch": "by branch",
    "speed_mm_s": "by speed",
    "cycle": "by cycle",
    "run": "by run",
    "time_s": "by time",
}


def compare(
    record: options.Record,
    law: options.Law = "auto",
    asked: options.Asked = options.NOTHING,
    out: Annotated[str | None, options.option("--out", "FILE.svg|png", "Save the map of the error, too.")] = None,
) -> None:
    """Show where the fitted law fails."""
    if out is not None:
        from ..core.files import check_target

        check_target(out, (".svg", ".png"))
    setup = asked.setup(law)
    from ..core.files import write_whole
    from ..schema.diagnosis import comparison_json
    from ..schema.prediction import law_choice_json
    from ..tasks.compare import compare_record, failure_picture
    from ..tasks.gate import warnings_of
    from ..tasks.law_choice import settle

    measured = setup.read(record)
    setup, choice = settle(measured, setup)
    comparison = compare_record(measured, setup)
    doubts = warnings_of(comparison.fit)
    options.give_json(asked.json, lambda: comparison_json(record, comparison, doubts) | law_choice_json(choice))
    if out is not None:
        write_whole(out, failure_picture(comparison, "." + out.rpartition(".")[2]))
    text.say(text.title(record, measured), *text.chosen(choice), *text.equation(setup.model), "")
    text.say(*text.banner(doubts), comparison.sentence)
    _print(comparison)
    if out is not None:
        text.say("", f"map of the error: {out}")
    options.stop_if_invalid(record, comparison.fit.problems)


def _print(comparison: "Comparison") -> None:
    unit = "N" if comparison.fit.lengths is None else "mm"
    for key, bins in comparison.by.items():
        rows = [(b.label, str(b.n), text.mean(b), text.number(b.rms, 3), text.percent(b.share)) for b in bins]
        head = (HEADS.get(key, f"by {key}"), "samples", f"mean [{unit}]", f"rms [{unit}]", "share")
        text.say("", *text.table(head, rows))
