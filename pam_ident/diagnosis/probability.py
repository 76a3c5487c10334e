"""How sure it is that an effect belongs to the answer."""

import math
from collections.abc import Sequence

from .trial import Trial

TEMPER = 4.0
"""Costs are divided by this before they become odds: forms are never exactly right, so evidence counts for less."""
LAPSE = 0.005
"""Chance that the search was misled as a whole: Jeffreys' (0 + ½)/(93 + 1) after 93 near-certain, true statements."""


def probabilities(trial: Trial, groups: Sequence[Sequence[str]]) -> dict[str, float]:
    """Chance, by suspect, that it belongs to the answer, or that one does which the record cannot tell from it.

    Sets that were fitted are weighed by exp(−cost / 2·TEMPER), and the weights of those that hold the suspect, or a
    member of its `groups`, are summed. With chance LAPSE nothing was learned, and each suspect is as likely as another.
    TEMPER and LAPSE were fitted to simulated records: docs/diagnosis.md.
    """
    fitted = trial.weighed()
    least = min(v.cost for v in fitted)
    sets = [(v.names, math.exp(-(v.cost - least) / (2.0 * TEMPER))) for v in fitted]
    total = sum(weight for _, weight in sets)
    chance = {}
    for suspect in trial.suspects:
        alike = {suspect.name}.union(*(group for group in groups if suspect.name in group))
        share = sum(weight for names, weight in sets if names & alike) / total
        chance[suspect.name] = (1.0 - LAPSE) * share + LAPSE / len(trial.suspects)
    return chance
