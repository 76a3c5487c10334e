"""The page that sets two records beside each other."""

import math
from collections.abc import Mapping

from .. import plot
from ..diagnosis.against import Against, ParameterDifference
from ..diagnosis.follows import told
from .easel import Easel, Part
from .opening import BESIDE
from .render import environment
from .tables import PageTable
from .tables import provenance as provenance_table
from .words import VERDICTS, known_to, likely, newtons, titles, unit, with_error


def render_against(found: Against, provenance: Mapping[str, object]) -> str:
    """One HTML file as text; `provenance` as in a Story."""
    names = [one.base.record.name for one in (found.a, found.b)]
    easel = Easel("ab", 0)
    return (
        environment()
        .get_template("report.html.j2")
        .render(
            title=f"{names[0]} against {names[1]}",
            records=[("ab", "A against B", parts(found, easel))],
            provenance=provenance_table(provenance),
            command=provenance.get("command"),
        )
    )


def parts(found: Against, easel: Easel) -> tuple[Part, ...]:
    """What differs in a sentence, then the effects, what the errors follow, and the parameters."""
    bars = tuple(
        easel.hang(
            plot.follows.draw(one.follows, BESIDE),
            f"What the law's error in {which} follows, as one bar. {told(one.follows)}",
            f"{which}, {one.base.record.name}: what the law's error follows. {told(one.follows)}",
        )
        for which, one in (("A", found.a), ("B", found.b))
    )
    return (
        Part("ab-answer", "What differs", (found.sentence,), tables=(records_table(found),)),
        Part("ab-effects", "Effects", tables=(effects_table(found),)),
        Part("ab-follows", "What the error follows", pictures=bars),
        Part(
            "ab-parameters",
            "Parameters",
            ("One model is fitted to each record: the law with what was named in either.",),
            tables=(parameters_table(found),),
        ),
    )


def records_table(found: Against) -> PageTable:
    """The two records with their verdicts and errors."""
    rows = tuple(
        (
            which,
            one.base.record.name,
            str(len(one.base.record)),
            VERDICTS.get(one.verdict, (one.verdict, ""))[0],
            newtons(one.base.rmse),
            newtons(one.best.rmse),
            newtons(one.noise_floor),
        )
        for which, one in (("A", found.a), ("B", found.b))
    )
    head = ("", "record", "samples", "verdict", "error of the law", "with what was missing", "noise")
    return PageTable("The two records", head, rows, (2, 4, 5, 6))


def effects_table(found: Against) -> PageTable:
    """Every effect that was named in either, with its probability in each."""
    known = titles(found.a.best.model) | titles(found.b.best.model)
    words = {"both": "both", "a": "A alone", "b": "B alone"}
    rows = tuple((known.get(e.effect, e.effect), words[e.where], _chance(e.a), _chance(e.b)) for e in found.effects)
    return PageTable("Effects that are missing", ("effect", "named in", "probability in A", "in B"), rows, (2, 3))


def _chance(probability: float | None) -> str:
    return "cannot be seen" if probability is None else likely(probability)


def _apart(one: ParameterDifference) -> tuple[str, str]:
    """The difference and its interval, to the same place."""
    if not math.isfinite(one.low):
        return "–", "not determined"
    told = [known_to(value, (one.high - one.low) / 4.0) for value in (one.difference, one.low, one.high)]
    return told[0], f"{told[1]} to {told[2]}"


def parameters_table(found: Against) -> PageTable:
    """Every parameter in both, with the interval of the difference."""
    rows = tuple(
        (
            one.name,
            unit(one.unit),
            with_error(one.a, one.a_stderr),
            with_error(one.b, one.b_stderr),
            *_apart(one),
            "differs" if one.differs else "could be chance" if math.isfinite(one.p) else "–",
        )
        for one in found.parameters
    )
    head = ("parameter", "unit", "A", "B", "B − A", "95 % interval", "verdict")
    return PageTable("Parameters ± standard error; the verdict is at 1 %, for all parameters together (Holm)",
                     head, rows, (2, 3, 4, 5))  # fmt: skip
