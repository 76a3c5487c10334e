"""Every candidate of a diagnosis beside what was selected."""

import math
from collections.abc import Mapping
from dataclasses import replace

from ..effects import Effect
from ..fitting import Fit, fit
from ..model import Model, Term
from ..records import Record
from .heldout import SHORT, fit_quickly, heldout_nearby, heldout_rmse
from .nouns import Candidate
from .selection import Selection
from .steady import looked_at

ENDED_BADLY = 1.01
"""Error of a law with a candidate, over that of the law alone, from which its fit has failed: an effect of size zero
leaves no more."""


def ranked(
    base: Fit,
    selection: Selection,
    candidates: list[Effect],
    named: list[Term],
    chance: Mapping[str, float],
    after: tuple[float, float],
    errors: bool = True,
) -> tuple[Candidate, ...]:
    """Every candidate with the error that adding it alone leaves, on all rows and held out, by a fit of its own; None
    without `errors`, and where that fit ended above the law's own.

    It has the form that was selected, else the one that the search prefers. Of a long record fewer rows are fitted; a
    name that is all of the answer has the answer's errors, those `after` it in N.
    """
    best = selection.seen.best_of_each(selection.penalty)
    terms = {term.effect.name: term for term in named}
    record = looked_at(base.record)
    most = ENDED_BADLY * fit_quickly(base.model, record, base.values)[1] if errors else 0.0
    found = []
    for effect in candidates:
        if effect.name in selection.excluded:
            status, why = selection.excluded[effect.name]
            found.append(Candidate(effect.name, effect.name, status, 0.0, why=why))
            continue
        regressor = selection.seen.regressors[best[effect.name][1]]
        term = terms.get(effect.name, regressor.term)
        one = Candidate(effect.name, term.label, "candidate", chance.get(effect.name, 0.0))
        if errors:
            near = {f"{effect.name}.{k}": v for k, v in regressor.point.items()} if term == regressor.term else {}
            whole = [t.label for t in named] == [term.label]
            inside, outside = after if whole else _alone(base.model.adding(term), record, base.values | near)
            if whole or inside <= most:
                one = replace(one, rmse_after=inside, heldout_rmse_after=None if math.isnan(outside) else outside)
        found.append(one)
    found.sort(key=lambda s: (s.status != "candidate", -s.probability, s.effect not in terms, s.rmse_after or math.inf))
    return tuple(found)


def _alone(model: Model, record: Record, start: Mapping[str, float]) -> tuple[float, float]:
    """Error in N that a model leaves of all rows, and of those held out; a short record pays for every refit."""
    if len(record) - len(model.params) <= 2:
        return math.nan, math.nan
    if len(record) <= SHORT:
        whole = fit(model, record, detail=False)
        return whole.rmse, heldout_rmse(model, record, whole)
    values, error = fit_quickly(model, record, start)
    return error, heldout_nearby(model, record, values)
