"""All that a report says about one record."""

from dataclasses import replace
from itertools import pairwise

from ..core import FitError
from ..diagnosis import climb, compare, diagnose
from ..diagnosis.nouns import Diagnosis, Ladder
from ..effects import Effect
from ..fitting import Fit, IsobarTable, fit_isobars, loop_energies
from ..model import Model
from ..records import Record
from ..report import Section
from .energy import energy_warning, model_loops


def build_section(model: Model, record: Record, extra: tuple[Effect, ...] = ()) -> Section:
    """Diagnosis, ladder, comparisons before and after, isobars and loops of one record.

    Raises FitError or DataError.
    """
    ladder = climb(model, record, extra)
    diagnosis = ladder.last if len(ladder.rungs) == 1 else diagnose(model, record, extra)
    best = completed(diagnosis, ladder)
    loops = model_loops({"together": best or diagnosis.base})
    return Section(
        record,
        compare(diagnosis.base),
        diagnosis,
        compare(best) if best is not None else None,
        ladder,
        _isobars(model, record),
        loop_energies(record, record.force),
        loops,
        _warnings(best or diagnosis.base, loops),
        rung_findings(ladder, diagnosis, extra),
    )


def rung_findings(ladder: Ladder, first: Diagnosis, extra: tuple[Effect, ...] = ()) -> tuple[Diagnosis, ...]:
    """The diagnosis that led to each rung above the first. One diagnosis may name several effects, a rung each; where
    a rung's effect is none of them, the model of the rung below is diagnosed."""
    found: list[Diagnosis] = []
    for below, rung in pairwise(ladder.rungs):
        name = rung.fit.model.terms[-1].effect.name
        latest = found[-1] if found else first
        found.append(latest if name in latest.selected else diagnose(below.fit.model, below.fit.record, extra))
    return tuple(found)


def completed(diagnosis: Diagnosis, ladder: Ladder) -> Fit | None:
    """The model with all that was found missing: the ladder's last rung, or the diagnosis' where that fits better.

    None where nothing was added.
    """
    found = [diagnosis.best] if diagnosis.selected else []
    if len(ladder.rungs) > 1:
        found.append(ladder.rungs[-1].fit)
    return min(found, key=lambda one: one.rmse) if found else None


def _isobars(model: Model, record: Record) -> tuple[IsobarTable, ...]:
    """The law alone, isobar by isobar, where it has parameters and the isobars have samples enough."""
    if not model.law.params:
        return ()
    both = all((record.inputs.direction == sign).any() for sign in (1.0, -1.0))
    try:
        return (fit_isobars(replace(model, terms=()), record, ("contraction", "extension") if both else ("together",)),)
    except FitError:
        return ()


def _warnings(best: Fit, loops: dict[float, float]) -> tuple[str, ...]:
    found = [f"{term.effect.title}: {term.effect.warning}" for term in best.model.terms if term.effect.warning]
    energy = energy_warning(loops)
    return tuple([*found, energy] if energy else found)
