"""The form of an effect that was named without one, before anything is named beside it.

What a form cannot follow of its own effect would be given another's name: friction that is written for motion alone
leaves in every hold what friction that grows with pressure can imitate.
"""

import math
from dataclasses import replace

from ..core import DataError, FitError
from ..core.digits import newtons
from ..core.prose import capital
from ..fitting import Fit, fit
from ..model import Model, Term
from ..records import Record
from .setup import Setup

BETTER = 0.9
"""Error of a model in another form, over that in the simplest, up to which the other form is taken."""


def in_best_forms(record: Record, setup: Setup) -> tuple[Model, str]:
    """The model with each effect that was named without a form in the written form that fits best, by Schwarz's
    criterion, where that leaves clearly less; and what is to be said of it, empty where nothing changed.

    Raises FitError or DataError where the model as it was named cannot be fitted.
    """
    model = setup.model
    if all(":" in label for label in setup.effects):
        return model, ""
    best, said = fit(model, record, detail=False), ""
    for k, term in enumerate(model.terms):
        if term.effect.name not in setup.effects:
            continue
        others = [
            _fitted(_with(best.model, k, term, form), record) for form in term.effect.written if form != term.form
        ]
        found = min([best, *(one for one in others if one is not None)], key=_criterion)
        if found.rmse < BETTER * best.rmse:
            said += (
                f"{capital(term.effect.title)} is taken as {found.model.terms[k].label}, which leaves "
                f"{newtons(found.rmse)} and not {newtons(best.rmse)}. "
            )
            best = found
    return best.model, said


def _with(model: Model, k: int, term: Term, form: object) -> Model:
    return replace(model, terms=(*model.terms[:k], replace(term, form=form), *model.terms[k + 1 :]))


def _fitted(model: Model, record: Record) -> Fit | None:
    try:
        return fit(model, record, detail=False)
    except (FitError, DataError):
        return None


def _criterion(one: Fit) -> float:
    return one.n * math.log(max(one.rmse, 1e-12) ** 2) + len(one.values) * math.log(one.n)
