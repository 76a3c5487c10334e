"""An isotonic record as if the length had been driven, so that all that asks what an error of the force follows can
ask it there, too; and a fit to one with its residual of the length.

Held against a force that hardly changes, any law of slope 0 fits to the last digit. So nothing measured of the length
may enter what explains it: the muscle is taken along the lengths ε̂ at which a model carries the weights, where its
force is, to first order, F(ε̂) = F + F_θ(ε̂) − F_θ(ε), F and ε as measured. What the model leaves of it is its error of
the force at the measured length. Where its own error changes between ε and ε̂ the sum is off by that change, and a lag
or a damping seems to be there: so a static effect that is found shifts ε̂ to where it says, and all is asked again.

While the pressure changes and the length stands, a weight sticks, and friction may be anything up to its level. These
rows tell nothing, and nor do those at the mechanical limit, and those at which no length is stable.
"""

from collections.abc import Mapping
from dataclasses import fields, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from ..core import Array, PamError
from ..model import Model
from ..records import Record
from ..records.notes import Notes
from ..records.roughness import position_noise
from .fit import Fit, fit
from .length import at_limit, by_length, equilibrium, weights_of
from .readings import Errors

GONE = 3.0
"""Standard deviations of the noise of the length by which a weight has left its place."""


def driven(model: Model, record: Record, values: Mapping[str, float] | None = None) -> Record:
    """The record itself, or an isotonic one along the lengths that a model predicts, with `values` or fitted to it,
    without the rows that tell nothing.

    Raises FitError or DataError as `fit` does.
    """
    if not by_length(record):
        return record
    values = fit(model, record, detail=False).values if values is None else values
    e, slope = equilibrium(model, record.steady, values, weights_of(record))
    inputs, steady = (replace(one, contraction=e) for one in (record.inputs, record.steady))
    force = record.force + model.force(inputs, values) - model.force(record.inputs, values)
    along = replace(record, inputs=inputs, steady=steady, force=force, measured=record)
    kept = ~at_limit(record) & (slope < 0.0)
    if inputs.moving is not None and inputs.pressure_rate is not None:
        kept &= (inputs.moving | (inputs.pressure_rate == 0.0)) & ~_sticks(record)
    left = int(np.count_nonzero(~kept))
    if left:
        notes = Notes()
        notes.add("weight_stands", "displacement", str(len(record)), left)
        along = replace(along, notes=(*along.notes, *notes.told()))
    return along.take(np.flatnonzero(kept))


def _sticks(record: Record) -> Array:
    """Mask (n,) of the rows from where the pressure turns until the length has left its place there, by more than its
    sensor's noise: so long a weight may stick."""
    inputs = record.inputs
    assert inputs.pressure_rate is not None and inputs.time is not None
    x, found = inputs.displacement_mm, np.zeros(len(inputs), bool)
    noise, sign = position_noise(x, inputs.time), np.sign(inputs.pressure_rate)
    calm = np.median([x, np.r_[x[1:], x[-1]], np.r_[x[0], x[:-1]]], axis=0)  # of three readings one may be far off
    driven = np.flatnonzero(sign != 0.0)
    turns = driven[1:][np.diff(sign[driven]) != 0.0]
    for begin, end in pairwise([*turns, len(x)]):
        away = np.abs(calm[begin:end] - np.median(x[max(begin - 1, 0) : begin + 3])) > GONE * noise
        found[begin : begin + int(np.argmax(away)) if away.any() else end] = True
    return found


def nearer(model: Model, record: Record, values: Mapping[str, float]) -> Record:
    """A carried record along the lengths that the law and the static effects of a model with `values` predict, which
    are nearer to those measured than the law's; any other record, or one of a model without these, as it is.

    Raises FitError or DataError as `driven` does.
    """
    static = tuple(term for term in model.terms if term.effect.static)
    return driven(replace(model, terms=static), record.as_measured, values) if record.carried and static else record


def length_rmse(one: Fit) -> float | None:
    """Error of the length in mm rms that the model of a fit to a carried record leaves when it is fitted to that; None
    for another record, and for a model that says no length, as one that remembers the way."""
    if not one.record.carried:
        return None
    try:
        errors = fit(one.model, one.record.as_measured, start=one.values, detail=False).length_errors
    except PamError:
        return None
    return errors.rmse if errors else None


class InLength(Fit):
    """A fit whose `residual`, `errors` and what is made of them are of the length, in mm; positive where the muscle is
    shorter than predicted."""

    @classmethod
    def of(cls, one: Fit) -> "InLength":
        """Of a fit that has `lengths`."""
        return cls(**{field.name: getattr(one, field.name) for field in fields(one)})

    @cached_property
    def residual(self) -> Array:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Measured minus predicted length of the stroke in mm at every sample, shape (n,)."""
        assert self.lengths is not None
        return self.lengths.residual

    @cached_property
    def errors(self) -> Errors:  # pyright: ignore[reportIncompatibleVariableOverride]
        """What the fitted rows leave, in mm."""
        assert self.length_errors is not None
        return self.length_errors
