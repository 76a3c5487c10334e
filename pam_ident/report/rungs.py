"""The ladder's story, a rung at a time: what was added and why, the error before and after, the trace of the effect."""

from collections.abc import Sequence
from dataclasses import replace
from math import isfinite

from .. import plot
from ..diagnosis.nouns import Ladder, Rung
from ..effects import in_words, named
from ..fitting import Fit
from . import tables
from .easel import Easel, Part
from .words import equation, heldout, likely, newtons, percent

SHARE = 4
"""A rung's figure shows this part of the points of the others: there are many rungs."""


def steps(ladder: Ladder, easel: Easel, told: Sequence[Fit] = ()) -> tuple[tuple[str, Part], ...]:
    """A part a rung under a short name; the parameters of fits that are `told` elsewhere are not told again."""
    rows = [table.rows for one in told for table in tables.fitted(one, "")]
    names = plot.ladder.data(ladder).names
    found = [(f"0: {names[0]}", _first(ladder.rungs[0], easel))]
    for k in range(1, len(ladder.rungs)):
        step = _next(k, ladder.rungs[k - 1], ladder.rungs[k], easel)
        found.append((f"{k}: {names[k]}".replace("\n", ", "), step))
    return tuple(
        (name, replace(part, tables=tuple(t for t in part.tables if t.rows not in rows))) for name, part in found
    )


def _first(rung: Rung, easel: Easel) -> Part:
    model = rung.fit.model
    return Part(
        f"{easel.prefix}-rung0",
        f"Step 0: {model.words}",
        tuple(equation(model)),
        tables=tables.fitted(rung.fit, "step 0"),
        facts=(
            ("error", newtons(rung.fit.rmse) + " rms"),
            *[(heldout(rung), newtons(rung.heldout_rmse) + " rms")] * isfinite(rung.heldout_rmse),
            ("largest error", newtons(rung.fit.max_error)),
            ("free parameters", str(len(model.params))),
        ),
    )


def _next(k: int, below: Rung, rung: Rung, easel: Easel) -> Part:
    """Rung k over the one below it. The share of the squared error is the number that convinced, with the
    probability, where the diagnosis is known."""
    before, after, why = below.fit, rung.fit, rung.found
    known = after.model.own
    new = [label for label in after.model.labels if label not in before.model.labels]
    what, words = (", ".join(say(label, known) for label in new) or "nothing" for say in (named, in_words))
    facts = [
        ("error", f"{newtons(before.rmse)} → {newtons(after.rmse)} rms"),
        *[(heldout(rung), f"{newtons(below.heldout_rmse)} → {newtons(rung.heldout_rmse)} rms")]
        * isfinite(rung.heldout_rmse),
        ("explained of the squared error", percent(1.0 - (after.rmse / before.rmse) ** 2)),
        ("free parameters", f"{len(before.model.params)} → {len(after.model.params)}"),
    ]
    if why is not None:
        chances = {candidate.effect: candidate.probability for candidate in why.ranking}
        facts += [
            (f"probability of {in_words(name, known)}", likely(chances[name]))
            for name in dict.fromkeys(label.partition(":")[0] for label in new)
            if name in chances
        ]
    picture = easel.hang(
        plot.signature.draw(before, after, max(easel.points // SHARE, 100)),
        f"Error over the record before and after adding {words}",
        f"Above: the error of step {k - 1}, and through it what {words} changes in the modelled force. "
        f"Below: what step {k} leaves.",
        live=easel.live and easel.live.step(before, after, SHARE),
    )
    return Part(
        f"{easel.prefix}-rung{k}",
        f"Step {k}: + {what}",
        (f"Why it was added: {why.sentence if why is not None else rung.why}",),
        (picture,),
        tables.fitted(after, f"step {k}"),
        tuple(equation(after.model)),
        facts=tuple(facts),
    )
