"""How sure it is that an effect belongs to the answer."""

import math
from collections.abc import Collection, Sequence

from .search import TEMPER
from .selection import Selection

LAPSE, PAIR, THREE, DOUBTFUL, LOCKED = 0.006, 0.015, 0.3, 0.15, 0.12
"""Chance that the search was misled as a whole, by what it ended with: one name, two, three, names beside something
unknown or that leave what passes for slow noise but may be more, any in a locked muscle, of which nobody measures how
far the braid slides, or under weights, where length and pressure are one line each. Shares of such statements that were
false, of the rig's sets and other hands': 4 of 1,157, 3 of 370, 20 of 58, 17 of 161, 10 of 100."""
MISSED = 0.001
"""Chance that an effect is there of which nothing shows beside the answer: 30 of 30,807."""


def probabilities(
    selection: Selection,
    groups: Sequence[Sequence[str]],
    answer: Collection[str] | None = None,
    lapse: float = LAPSE,
) -> dict[str, float]:
    """Chance, by candidate, that it belongs to the answer, or that one does which the record cannot tell from it.

    Sets that were fitted are weighed by exp(−criterion / 2·TEMPER), and the weights of those that hold the candidate,
    or a member of its `groups`, are summed. Where the likeliest of them holds a name that the `answer` has not, because
    it is too small to matter or held-out data are predicted better without, no set with that name counts. With
    chance LAPSE, or that of its kind of answer, `lapse` at least, the answer is wrong all the same; with chance MISSED
    an effect is there whatever was fitted. These and TEMPER come from simulated records: docs/diagnosis.md.
    """
    fitted = list(selection.cache.values())
    while answer is not None:
        more = min(fitted, key=lambda v: v.criterion).candidates.difference(answer, *groups)
        if not more:
            break
        fitted = [v for v in fitted if v.names.isdisjoint(more)]
    least = min(v.criterion for v in fitted)
    sets = [(v.names, math.exp(-(v.criterion - least) / (2.0 * TEMPER))) for v in fitted]
    total = sum(weight for _, weight in sets)
    chance, names = {}, len(answer or ())
    locked = selection.record.inputs.locked or selection.record.carried
    kinds = {PAIR: names == 2, THREE: names > 2, LOCKED: locked}
    lapse = max([lapse, *(misled for misled, holds in kinds.items() if holds)])
    rivals = (e for e in selection.rivals if any(e.name in group for group in groups))
    for candidate in (*selection.candidates, *rivals):
        alike = {candidate.name}.union(*(group for group in groups if candidate.name in group))
        share = sum(weight for names, weight in sets if names & alike) / total
        chance[candidate.name] = (1.0 - lapse) * share + MISSED * (1.0 - share)
    return chance
