"""What a logger makes of a table: spikes, gaps, jitter, coarse steps, a load cell at its end.

Every fault takes the table (n, 7) in the order of record.COLUMNS and returns a new one of that shape. A cell that is
NaN is written empty, and a row whose time is NaN is not written.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from .muscle import Array

TIME, PRESSURE, LENGTH, FORCE = 0, 3, 4, 5
Fault = Callable[[Array, np.random.Generator], Array]


def _some(n: int, share: float, rng: np.random.Generator) -> NDArray[np.intp]:
    return rng.choice(n, max(int(share * n), 1), replace=False)


def _spikes(table: Array, rng: np.random.Generator) -> Array:
    """Two samples in a thousand of the force are off by 50 to 500 N."""
    out, rows = table.copy(), _some(len(table), 0.002, rng)
    out[rows, FORCE] += rng.choice([-1.0, 1.0], len(rows)) * rng.uniform(50.0, 500.0, len(rows))
    return out


def _empty_cells(table: Array, rng: np.random.Generator) -> Array:
    """One in a hundred cells of pressure, length or force is empty."""
    out = table.copy()
    for column in (PRESSURE, LENGTH, FORCE):
        out[_some(len(out), 0.01, rng), column] = np.nan
    return out


def _lost_rows(table: Array, rng: np.random.Generator) -> Array:
    """One row in twenty was never written."""
    out = table.copy()
    out[_some(len(out), 0.05, rng), TIME] = np.nan
    return out


def _jitter(table: Array, rng: np.random.Generator) -> Array:
    """The clock is read up to a fifth of a step too late."""
    out = table.copy()
    steps = np.diff(out[:, TIME], append=out[-1, TIME] + 0.01)
    out[:, TIME] = np.round(out[:, TIME] + 0.2 * rng.uniform(0.0, 1.0, len(out)) * np.clip(steps, 0.0, 0.2), 5)
    return out


def _coarse(table: Array, rng: np.random.Generator) -> Array:
    """A logger of 12 bits: 1 N, 0.05 mm, 0.5 kPa."""
    out = table.copy()
    for column, step in ((PRESSURE, 0.0005), (LENGTH, 0.05), (FORCE, 1.0)):
        out[:, column] = np.round(out[:, column] / step) * step
    return out


def _clipped(table: Array, rng: np.random.Generator) -> Array:
    """The load cell ends at 85 to 95 % of the largest force."""
    out = table.copy()
    out[:, FORCE] = np.minimum(out[:, FORCE], np.round(rng.uniform(0.85, 0.95) * out[:, FORCE].max(), 3))
    return out


FAULTS: dict[str, Fault] = {
    "spikes": _spikes,
    "empty_cells": _empty_cells,
    "lost_rows": _lost_rows,
    "jitter": _jitter,
    "coarse": _coarse,
    "clipped": _clipped,
}
