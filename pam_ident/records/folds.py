"""Which rows of a record are held out together."""

import numpy as np

from ..core import Array
from .record import Record

FOLDS = 5


def folds(record: Record) -> list[Array]:
    """Masks (n,) of the rows to hold out in turn: each length or isobar of a table; in time every fifth cycle, but of
    many not the first or the last, which a drift would have to be followed to from one side."""
    blocks = np.unique(record.block)
    if record.inputs.time is None:
        return told_by_the_rest(record, in_parts(record.block, len(blocks)))
    return told_by_the_rest(record, in_parts(record.block, among=blocks[1:-1] if len(blocks) > FOLDS + 1 else blocks))


def told_by_the_rest(record: Record, masks: list[Array]) -> list[Array]:
    """Of masks (n,) those without which more than one pressure is left, where there are more: from one alone nobody
    could say how a force grows with it."""
    alone = len(record.levels) < 2
    return [mask for mask in masks if alone or len(np.unique(record.level[~mask])) > 1]


def in_parts(block: Array, most: int = FOLDS, among: Array | None = None) -> list[Array]:
    """Masks (n,) of at most so many parts, each of every so many-th of the blocks that rows (n,) belong to, or of those
    `among` them, (m,)."""
    blocks = np.unique(block if among is None else among)
    return [np.isin(block, blocks[k::most]) for k in range(min(most, len(blocks)))]
