"""The rows of a record that are looked at, and the steady inputs they are judged by."""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..core import Inputs
from ..model import Model
from ..records import Record, thinned
from .schedule import mean_of_each
from .track import TrackError

ROWS = 5_000
"""Rows of a long record that are looked at: of 58 with 5,000 to 8,000 rows one was answered wrongly by so many."""
NO_NOISE = 3.0
"""Standard deviations by which a model leaves more of a record with steady inputs than with measured ones, from which
what was taken off was no noise."""


def looked_at(record: Record) -> Record:
    """About ROWS rows of a record of more than twice as many, any other as it is: less would be uneven steps."""
    return thinned(record, ROWS) if len(record) > 2 * ROWS else record


def steadied(record: Record, model: Model, values: Mapping[str, float]) -> tuple[Record, TrackError | None]:
    """The rows that are looked at, with their steady inputs, and how far the track of what is driven may be off.

    The noise of pressure and length, which a model turns into force, would follow what is measured. But what is taken
    off is no noise where a model with `values` that fit the record then leaves more.
    """
    fewer = looked_at(record)
    measured, steady = (fewer.force - model.force(one, values) for one in (fewer.inputs, fewer.steady))
    chance = 2.0 * math.sqrt(float(measured @ measured) / len(fewer)) * float(np.linalg.norm(steady - measured))
    if steady @ steady - measured @ measured > NO_NOISE * chance:
        fewer = replace(fewer, steady=fewer.inputs)
    return replace(fewer, inputs=fewer.steady), TrackError.of(fewer, record)


def without_sensor(record: Record) -> Inputs:
    """A record's inputs, a held pressure as the mean of its level.

    Readings of it that could not be smoothed are off, and the force by as much times its slope: columns that held them,
    and not this, would follow the sensor's noise (errors in variables: Fuller 1987, Measurement Error Models).
    """
    inputs = record.inputs
    if inputs.time is None or inputs.pressure_rate is not None:
        return inputs
    return replace(inputs, pressure=mean_of_each(record.level, inputs.pressure))
