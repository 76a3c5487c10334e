"""Whether rows without a time were logged one after another, so that a clock was passed over."""

from itertools import pairwise

import numpy as np

from ..core import Array
from .guess import by_name, numbers_of, rises
from .ranges import Values
from .table import Table
from .turning import pivots

MANY = 100
"""Rows from which a record may be a log."""
JUMP, FEW = 0.1, 0.05
"""Share of a range that a smooth track does not go in a step, and share of the steps that do, to another isobar."""
BACK, SPAN = 0.25, 0.05
"""Share of a range that a track turns back by, and least range beside the largest value of a track that is driven."""
SEVERAL = 3
"""Ways back that no table has whose rows are sorted; where a clock is seen, or branches are said, see `is_log`."""


def likely_clock(table: Table, passed: tuple[int, ...]) -> str:
    """The header of the column among those `passed` over that looks like a clock: its name says so, or its numbers rise
    throughout, and do not merely count the rows; empty for none."""
    columns = dict(zip(passed, numbers_of(table, passed), strict=True)) if passed else {}
    rising = [k for k, column in columns.items() if rises(column) and not np.all(np.diff(column) == 1.0)]
    named = [k for k in rising if by_name(table.headers[k]) == "time"]
    return table.headers[(named or rising)[0]] if rising else ""


def is_log(values: Values, contraction: Array, clock: str) -> bool:
    """Whether the rows of a record without a time look like a log: its `contraction` (n,) or pressure goes smoothly
    back and forth, several times, or at all beside what looks like a `clock`. Where branches were said, a table of
    loops is meant unless there is a clock."""
    if len(contraction) < MANY or ("branch" in values and not clock):
        return False
    back = max(_ways_back(contraction), _ways_back(values["pressure"]))
    return back >= (1 if clock else SEVERAL)


def _ways_back(track: Array) -> int:
    """How often a smooth track (n,) turns back; what a jump begins anew is no turn."""
    span, steps = float(np.ptp(track)), np.abs(np.diff(track))
    jumps = np.flatnonzero(steps > JUMP * span) + 1
    if not span > SPAN * np.abs(track).max() or len(jumps) > FEW * len(steps):
        return 0
    pieces = [track[begin:end] for begin, end in pairwise([0, *jumps.tolist(), len(track)])]
    return sum(max(len(pivots(piece, BACK * span)) - 2, 0) for piece in pieces)
