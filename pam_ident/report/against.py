"""The page that sets two records beside each other."""

import math
from collections.abc import Mapping
from typing import Any

from .. import plot
from ..diagnosis.against import Against, ParameterDifference
from ..diagnosis.nouns import Diagnosis
from ..diagnosis.sentence import told
from ..effects import in_words
from ..live import available
from .easel import Easel, Part, Picture, live
from .opening import BESIDE, HERO
from .render import MOST_POINTS, page
from .tables import PageTable
from .words import VERDICTS, known_to, likely, newtons, unit, with_error

SAMPLES = 2 * MOST_POINTS
"""Of each record, in figures to zoom into."""


def render_against(found: Against, provenance: Mapping[str, object]) -> str:
    """One HTML file as text; `provenance` as in a Story."""
    records = [("ab", "A against B", parts(found, SAMPLES if available() else 0))]
    return page(" against ".join(found.names), records, provenance)


def parts(found: Against, samples: int = 0) -> tuple[Part, ...]:
    """What differs in a sentence, then the effects, the errors and what they follow, and the parameters; what can be
    zoomed into has so many `samples` a record, if any."""
    records = zip("AB", found.names, (found.a, found.b), strict=True)
    both = [_pictures(which, name, one, samples) for which, name, one in records]
    traces, bars = zip(*both, strict=True)
    _one_scale(traces)
    return (
        Part("ab-answer", "What differs", (found.sentence,), tables=(records_table(found),)),
        Part("ab-effects", "Effects", tables=(effects_table(found),)),
        Part("ab-errors", "The errors over the records", pictures=traces),
        Part("ab-follows", "What the error follows", pictures=bars),
        Part(
            "ab-parameters",
            "Parameters",
            ("One model is fitted to each record: the law with what was named in either.",),
            tables=(parameters_table(found),),
        ),
    )


def _pictures(which: str, name: str, one: Diagnosis, samples: int) -> tuple[Picture, Picture]:
    """The error of the law over a record, with what is missing, and what it follows."""
    after = one.best if one.selected else None
    easel = Easel(f"ab{which.lower()}", MOST_POINTS, live(one.base, after, samples))
    left = " before (above), with what is missing drawn through it, and after (below)." if after else "."
    trace = easel.hang(
        plot.signature.draw(one.base, after, easel.points, HERO),
        f"{which}: error of the law over the record{' before and after' if after else ''}",
        f"{which}, {name}: the law's error{left}",
        live=easel.live and easel.live.trace,
    )
    bar = easel.hang(
        plot.follows.draw(one.follows, BESIDE),
        f"What the law's error in {which} follows, as one bar. {told(one.follows)}",
        f"{which}, {name}: what the law's error follows. {told(one.follows)}",
    )
    return trace, bar


def _one_scale(traces: tuple[Picture, ...]) -> None:
    """The same scale of the error for both records."""
    axes = [one.figure.axes[0] for one in traces]
    end = max(one.get_ylim()[1] for one in axes)
    for one in axes:
        one.set_ylim(-end, end)
    panels: list[Any] = [one.live.children[0] for one in traces if one.live is not None]
    ranges = [one.y_range for one in panels]
    end = max((one.end for one in ranges), default=0.0)
    for one in ranges:
        one.update(start=-end, end=end, reset_start=-end, reset_end=end)


def records_table(found: Against) -> PageTable:
    """The two records with their verdicts and errors."""
    rows = tuple(
        (
            which,
            name,
            str(len(one.base.record)),
            VERDICTS.get(one.verdict, (one.verdict, ""))[0],
            newtons(one.base.rmse),
            newtons(one.best.rmse),
            newtons(one.noise_floor),
        )
        for which, name, one in zip("AB", found.names, (found.a, found.b), strict=True)
    )
    head = ("", "record", "samples", "verdict", "error of the law", "with what was missing", "noise")
    return PageTable("The two records", head, rows, (2, 4, 5, 6))


def effects_table(found: Against) -> PageTable:
    """Every effect that was named in either, with its probability in each."""
    known = (*found.a.best.model.own, *found.b.best.model.own)
    words = {"both": "both", "a": "A alone", "b": "B alone"}
    rows = tuple((in_words(e.effect, known), words[e.where], _chance(e.a), _chance(e.b)) for e in found.effects)
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
