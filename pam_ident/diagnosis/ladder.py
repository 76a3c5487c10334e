"""From a law up to the noise floor, one effect a rung."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ..core.digits import newtons, probability
from ..core.progress import part
from ..core.prose import capital
from ..effects import Effect
from ..fitting import Fit, fit
from ..fitting.carried import driven
from ..model import Model, Term
from ..records import Record
from .confirmed import fit_onto
from .diagnose import diagnose
from .heldout import heldout_rmse
from .nouns import Diagnosis, Ladder, Rung

MOST_RUNGS = 8
DEAD = 1e-3
"""Force of an effect beside what is left, both rms, below which it is none."""
LEAST_FALL = 0.01
"""Relative fall of the held-out error below which a rung is not worth an effect."""


def climb(
    model: Model,
    record: Record,
    extra: tuple[Effect, ...] = (),
    without: tuple[str, ...] = (),
    only: tuple[str, ...] = (),
    odds: Mapping[str, float] | None = None,
    also: tuple[str, ...] = (),
    detail: bool = True,
) -> Ladder:
    """Diagnose, add, and diagnose again, until nothing is missing or the error on held-out data stops falling.

    The effects of one diagnosis are added one at a time, first the one that lowers the error most, or in a table the
    error on held-out data.

    Args:
        model: the lowest rung.
        record: what it is held against.
        extra: effects of the user's own, tried beside the catalogue's.
        without, only, odds, also, detail: as in `diagnose`.

    Raises:
        FitError, DataError: as `diagnose`.

    Example:
        >>> from pam_ident.diagnosis import climb
        >>> from pam_ident.model import Model
        >>> from pam_ident.records import read_record
        >>> from pam_ident.records import thinned
        >>> from pam_ident.records.datasets import dataset_record
        >>> record = thinned(read_record(dataset_record("hidden_effect")), 1000)
        >>> for rung in climb(Model.build("exponential_law"), record).rungs:
        ...     print(rung.fit.model.effect_names, f"{rung.fit.rmse:.1f} N")
        [] 5.8 N
        ['pressure_friction'] 2.1 N
    """
    *_, (rungs, found) = climbing(model, record, extra, without, only, odds, also, detail=detail)
    assert found is not None, "the last step is a diagnosis"
    return Ladder(rungs, found.noise_floor, found)


def climbing(
    model: Model, record: Record, *tried: Any, detail: bool = True
) -> Iterator[tuple[tuple[Rung, ...], Diagnosis | None]]:
    """The rungs as `climb` finds them, with what is `tried` by its arguments from `extra` to `also`, and the last
    diagnosis: first the law alone, then after each diagnosis."""
    record = driven(model, record)
    first = fit(model, record)
    rungs = [Rung(first, heldout_rmse(first.model, record, first), "the law alone")]
    yield tuple(rungs), None
    noise, new = math.inf, rungs
    while new:
        with part(f"step {len(rungs)}"):
            last = rungs[-1].fit
            found = diagnose(last.model, record, *tried, detail=detail, noise_N=noise, start=last.values)
        noise = found.noise_floor
        if record.carried and found.base.record is not record:  # it lies nearer to the lengths as measured
            record = found.base.record
            rungs = [_along(rung, record) for rung in rungs]
        terms = [t for t in found.best.model.terms if t.effect.name in found.selected]
        new = _rungs(rungs[-1], terms, model, found) if terms and len(rungs) <= MOST_RUNGS else []
        rungs += new
        yield tuple(rungs), found


def _along(rung: Rung, record: Record) -> Rung:
    """A rung, fitted to another record."""
    one = fit(rung.fit.model, record, start=rung.fit.values)
    return replace(rung, fit=one, heldout_rmse=heldout_rmse(one.model, record, one))


def _rungs(below: Rung, terms: list[Term], lowest: Model, found: Diagnosis) -> list[Rung]:
    """Rungs for the terms, the one of most merit first; none once held-out data gain nothing, or of which the record
    does not determine an effect."""
    rungs: list[Rung] = []
    record = below.fit.record
    left = list(terms)
    while left:
        base = rungs[-1] if rungs else below
        attempts = [(_added(base.fit, t, found.best), t) for t in left]
        best, term = min(attempts, key=lambda pair: _merit(pair[0]))
        left.remove(term)
        best = _alive(best, lowest)
        if best.model == base.fit.model:
            continue
        heldout = heldout_rmse(best.model, record, best)
        rungs.append(Rung(best, heldout, _why(base, best, heldout, found), found))
    while rungs and not (_helps((below, *rungs)[-2], rungs[-1]) and _determined(rungs[-1].fit, below.fit)):
        rungs.pop()
    return rungs


def _determined(one: Fit, below: Fit) -> bool:
    """Whether a fit has converged and the record determines its effects, wherever both held of the rung below.

    The law's own parameters do not count: a large error can hide that the record never determined them.
    """
    loose = {*one.undetermined} - {*below.undetermined, *replace(one.model, terms=()).names}
    return one.converged >= below.converged and not loose


def _alive(one: Fit, lowest: Model) -> Fit:
    """The fit without those effects beyond the lowest rung's whose force has become nothing."""
    kept = [t for t in one.model.terms if t in lowest.terms or one.shares[t.label] > DEAD * one.rmse]
    model = replace(one.model, terms=tuple(kept))
    return one if model == one.model else fit(model, one.record, start=one.values)


def _added(base: Fit, term: Term, found: Fit) -> Fit:
    """The base with a term, from the values that it was `found` with; that fit itself where it holds no more."""
    model = base.model.adding(term)
    return found if model == found.model else fit_onto(base, model, found.values)


def _merit(one: Fit) -> float:
    """The error in N by which a rung is chosen: in a table, where it costs little, that on held-out data."""
    if one.record.inputs.time is None and len(np.unique(one.record.block)) > 1:
        return heldout_rmse(one.model, one.record, one)
    return one.rmse


def _helps(before: Rung, after: Rung) -> bool:
    if math.isnan(after.heldout_rmse):
        return after.fit.rmse < (1.0 - LEAST_FALL) * before.fit.rmse
    return after.heldout_rmse < (1.0 - LEAST_FALL) * before.heldout_rmse


def _why(base: Rung, best: Fit, heldout: float, found: Diagnosis) -> str:
    term = best.model.terms[-1]
    chance = next((s.probability for s in found.ranking if s.effect == term.effect.name), math.nan)
    held = f"held out and refitted {newtons(base.heldout_rmse)} → {newtons(heldout)}, "
    return (
        f"{capital(term.effect.title)} ({term.form.name}): error {newtons(base.fit.rmse)} → {newtons(best.rmse)}, "
        f"{held * math.isfinite(heldout)}probability {probability(chance)}"
    )
