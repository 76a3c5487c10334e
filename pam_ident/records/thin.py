"""A long record read thinly: fewer rows of each stroke, and fewer stretches where the strokes themselves are many."""

from dataclasses import replace

import numpy as np

from ..core import Array
from .record import Record

LEAST = 20
"""Rows of a stroke or a hold that are kept at least: a corner, a bump or a decay must still be seen."""
STRETCH = 600
"""Rows of a stretch, about: some cycles, so that what remembers the cycle before does."""


def thinned(record: Record, most: int) -> Record:
    """About `most` of a record's rows; a record of no more rows, or a static table, as it is.

    Rows are taken evenly from each stroke and hold, their ends included. Where that leaves too many, whole cycles are
    taken in stretches, one from anywhere in each equal part of the record, lest they beat with the protocol; a new
    segment begins with each. Every pressure stays, and the record's first cycle, since effects count from there.
    """
    n = len(record)
    if n <= most or record.inputs.time is None:
        return record
    rows = _of_each_run(record, n / most)
    if len(rows) <= 2 * most:
        return record.take(rows)
    chosen, part = _stretches(record, rows, most)
    fewer = record.take(rows[chosen])
    broken = [replace(inputs, segment=part) for inputs in (fewer.inputs, fewer.steady)]
    return replace(fewer, inputs=broken[0], steady=broken[1])


def _of_each_run(record: Record, stride: float) -> Array:
    """Indices of rows `stride` apart, or nearer, in each stroke and hold."""
    inputs = record.inputs
    assert inputs.segment is not None and inputs.moving is not None
    changes = (np.diff(inputs.segment) != 0) | (np.diff(record.stroke) != 0) | np.diff(inputs.moving)
    begins = np.r_[0, np.flatnonzero(changes) + 1]
    lengths = np.diff(np.r_[begins, len(record)])
    counts = np.maximum(np.minimum(lengths, LEAST), np.ceil(lengths / stride).astype(int))
    run = np.repeat(np.arange(len(counts)), counts)
    place = np.arange(len(run)) - np.repeat(np.cumsum(counts) - counts, counts)
    last = np.maximum(counts - 1, 1)
    return begins[run] + np.round(place * ((lengths - 1) / last)[run]).astype(int)


def _stretches(record: Record, rows: Array, most: int) -> tuple[Array, Array]:
    """Which of `rows` to take, as indices, and the number of the segment each then belongs to."""
    block, segment = record.block[rows], record.inputs.segment
    assert segment is not None
    cycle = np.r_[0, np.cumsum(np.diff(block) != 0)]
    begins = np.r_[np.flatnonzero(np.diff(cycle, prepend=-1)), len(rows)]
    random = np.random.default_rng(0)
    taken = np.zeros(len(begins) - 1, bool)
    levels = np.unique(record.level)
    share = most / len(rows)
    for level in levels:
        mine = np.flatnonzero(record.level[rows[begins[:-1]]] == level)
        each = max(1, round(STRETCH / np.mean(np.diff(begins)[mine])))
        parts = max(1, round(share * len(mine) / each))
        for part in np.array_split(mine, parts):
            # The record's first rows always: drift, warming and softening count from them.
            first = int(random.integers(max(len(part) - each, 0) + 1)) if part[0] else 0
            taken[part[first : first + each]] = True
    chosen = np.flatnonzero(taken[cycle])
    breaks = (np.diff(chosen) > 1) | (np.diff(segment[rows[chosen]]) != 0)
    return chosen, np.r_[0, np.cumsum(breaks)]
