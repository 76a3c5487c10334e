"""pam-ident challenge."""

from typing import TYPE_CHECKING, Annotated

import typer

from . import options, text

if TYPE_CHECKING:
    from ..validation.challenge import Challenge
    from ..validation.score import Score


def challenge(
    n: Annotated[int, typer.Option("--n", metavar="N", help="Number of cases.")] = 60,
    seed: Annotated[int, typer.Option("--seed", metavar="SEED", help="Same seed, same set.")] = 1,
    out: Annotated[str | None, options.option("--out", "DIR", "Folder for the set, the answers and pictures.")] = None,
    only: Annotated[str | None, options.option("--only", "KIND", "Cases of one kind only.")] = None,
    holdout: Annotated[
        str | None,
        options.option("--holdout", "effects|forms", "Leave what is hidden out of the catalogue: effects, or forms."),
    ] = None,
    protocols: Annotated[
        str,
        options.option(
            "--protocols",
            "plain|all|KIND",
            "All: other protocols, noises, sensors and logger faults too; or those of a kind that drives the pressure: "
            "isometric, combined, dynamic, isotonic.",
        ),
    ] = "plain",
    answers: Annotated[
        str | None, options.option("--answers", "FILE.jsonl", "Score these answers to the set in --out.")
    ] = None,
    workers: options.Workers = None,
    scheduler: options.Scheduler = None,
    json: options.JsonFile = None,
) -> None:
    """Hide effects in simulated records, and score the diagnosis.

    The hidden effects stay sealed until all answers are there. To take it yourself: `pam-ident rig DIR`, answer, then
    `pam-ident challenge --out DIR --answers FILE.jsonl`.
    """
    from pathlib import Path
    from tempfile import TemporaryDirectory

    from ..core import UsageError
    from ..parallel.executor import Executor
    from ..schema.trials import challenge_json
    from ..validation.challenge import score_answers, sit_challenge

    if answers is not None and out is None:
        raise UsageError("--answers: name the folder of the set that they answer, too, by --out DIR")
    with TemporaryDirectory() as temporary:
        if answers is not None:
            found = score_answers(str(out), answers)
        else:
            executor = Executor.of_cores(workers, scheduler)
            found = sit_challenge(out or Path(temporary, "set"), n, seed, only, executor, holdout, protocols)
        pictures = _draw(found) if out is not None else []
    options.give_json(json, lambda: challenge_json(found))
    text.say(*describe(found))
    if out is not None:
        text.say(f"in {out}: {', '.join(pictures + ([] if answers else ['answers.jsonl', 'the set']))}")


def _draw(found: "Challenge") -> list[str]:
    """Write the pictures into the set's folder; their names. Without probabilities there is none of them."""
    from ..core.files import write_whole
    from ..plot import calibration, confusion, to_svg

    figures = {"confusion.svg": confusion.draw(found.confusion)}
    if found.reliability.n:
        figures["calibration.svg"] = calibration.draw(found.reliability)
    for name, figure in figures.items():
        write_whole(found.folder / name, to_svg(figure))
    return list(figures)


def describe(found: "Challenge") -> list[str]:
    """Scores by kind, what was missed, and what the probabilities are worth."""
    from ..validation.score import KINDS

    rows = [
        (
            KINDS.get(t.kind, t.kind),
            str(t.n),
            text.percent(t.right / t.n),
            text.percent(t.exact / t.n),
            _removed(t.removed_median),
            _removed(t.removed_worst),
        )
        for t in found.tallies
    ]
    lines = text.table(("kind", "cases", "right", "exact", "error removed, median", "worst"), rows)
    lines += [line for line in [_apart(found)] if line]
    missed = [s for s in found.scores if not s.exact]
    if missed:
        lines += ["not right, or not exact:"]
        rows = [
            (s.case, KINDS[s.kind], " + ".join(s.hidden) or "nothing", " + ".join(s.named) or "nothing", _grade(s))
            for s in missed
        ]
        lines += text.table(("case", "kind", "hidden", "named", ""), rows, left=(0, 1, 2, 3, 4))
    worth = found.reliability
    if worth.n:
        lines += [f"{worth.n} probabilities stated, Brier score {worth.brier:.4f}:"]
        rows = [(f"{b.low:g} to {b.high:g}", str(b.n), f"{b.stated:.3f}", f"{b.true / b.n:.3f}") for b in worth.bins]
        lines += text.table(("stated", "number", "mean", "truly hidden"), rows)
    if found.seconds is not None:
        lines += [f"{text.number(found.seconds / len(found.scores), 2)} s a case"]
    return lines


def _apart(found: "Challenge") -> str:
    """False alarms, unknowns and poor protocols in one sentence."""
    words = []
    for t in found.tallies:
        if t.kind == "null":
            words.append(f"false alarms {t.n - t.right} of {t.n}")
        elif t.kind == "unknown":
            words.append(f"unknown recognised {t.right} of {t.n}, with its kind {t.exact}")
        elif t.kind == "held out":
            words.append(f"left out and said to be unknown {t.right} of {t.n}, with no name beside it {t.exact}")
        elif t.kind == "blunt":
            words.append(f"one speed: group named {t.right} of {t.n}, with the test that splits it {t.exact}")
        elif t.kind == "pair" and t.grouped > t.right:
            words.append(f"two effects: {t.grouped} of {t.n} right where a name stands for its group")
    return "; ".join(words)


def _grade(one: "Score") -> str:
    if one.right:
        return "right, not exact"
    return "right by its group" if one.grouped else "missed"


def _removed(share: float | None) -> str:
    return "" if share is None else f"{100 * share:.1f} %"
