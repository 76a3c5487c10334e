"""The columns of a table in internal units, checked block by block: every refusal names file, row and column."""

from collections.abc import Iterable, Iterator
from itertools import pairwise

import numpy as np

from ..core import DataError
from .quantities import SHAPES, Source
from .table import Table, TableRows, number_of

Array = np.ndarray
MOST_MPA = 10.0
MOST_CONTRACTION = 0.95
MOST_S = 1e20
"""Above any clock's count, that of nanoseconds since 1970 included."""


Values = dict[str, Array]
"""Quantity → array of shape (n,) in internal units."""


def read_columns(table: Table, sources: dict[str, Source], length_mm: float) -> Iterator[Values]:
    """Each run of a table, whole; what a run is, and what is raised, as `read_pieces` says."""
    run: Values = {}
    n = 0
    for begins, values in read_pieces(table, sources, length_mm):
        if begins and run:
            yield {key: column[:n] for key, column in run.items()}
            run, n = {}, 0
        more = len(next(iter(values.values())))
        for key, column in values.items():
            if key not in run or n + more > len(run[key]):
                run[key] = _with_room(run.get(key, column[:0]), n, n + more)
            run[key][n : n + more] = column
        n += more
    if run:
        yield {key: column[:n] for key, column in run.items()}


def read_pieces(table: Table, sources: dict[str, Source], length_mm: float) -> Iterator[tuple[bool, Values]]:
    """The rows of a table piece by piece, and whether a run begins with each: a file whose header comes again, or whose
    clock begins anew with another pressure_set, holds several.

    `length_mm` is the muscle's initial length. Raises DataError for what is no number, for time that runs backwards,
    and for values beyond reason.
    """
    last: dict[str, float] = {}
    begins = True
    for block in table.read([s.position for s in sources.values() if s.position is not None]):
        values = {key: _column(table, block, source, key) for key, source in sources.items()}
        _check_ranges(table, block, sources, values, length_mm)
        cuts = _cuts(table, block, sources, values, last)
        for begin, end in pairwise([0, *cuts, len(block)]):
            begins = begins or begin in cuts
            if end > begin:
                yield begins, {key: column[begin:end] for key, column in values.items()}
                begins = False
        if len(block):
            last = {key: float(values[key][-1]) for key in ("time", "pressure_set") if key in values}
    if begins and not last:
        raise DataError(f"{table.place}: a header but no rows of numbers; expected one row a sample")


def _with_room(column: Array, n: int, needed: int) -> Array:
    """The first n rows of a column with room for `needed` and as many again, which take no memory until they are used;
    to join all blocks at the end would take the memory twice."""
    wider = np.empty(2 * needed)
    wider[:n] = column[:n]
    return wider


def _column(table: Table, block: TableRows, source: Source, key: str) -> Array:
    if source.position is None:
        return np.full(len(block), source.value)
    if key == "branch":
        return _directions(table, block, source)
    cells = block.cells[source.position]
    if cells.dtype.kind in "fiu":
        numbers = np.asarray(cells, dtype=float)
    else:
        numbers = np.array([number_of(cell, table.decimal) for cell in cells])
    finite = np.isfinite(numbers)
    if not finite.all():
        bad = np.flatnonzero(~finite)
        cell = np.asarray(cells)[bad[0]]
        what = "is empty or NaN" if cell is None or cell != cell else f"holds {str(cell)[:40]!r}"
        more = f" (and {len(bad) - 1} more rows)" if len(bad) > 1 else ""
        mark = " with a decimal comma, as elsewhere" if table.decimal == "," else ""
        raise DataError(
            f"{_where(table, block, bad[0], source)}: {what}{more}; expected a number{mark}. Mend or delete the row"
        )
    return numbers if (source.factor, source.offset) == (1.0, 0.0) else numbers * source.factor + source.offset


def _directions(table: Table, block: TableRows, source: Source) -> Array:
    assert source.position is not None
    signs = dict(source.words)
    words = [f"{c:g}" if isinstance(c, float) else str(c).strip().lower() for c in block.cells[source.position]]
    numbers = np.array([signs.get(word, np.nan) for word in words])
    bad = np.flatnonzero(np.isnan(numbers))
    if len(bad):
        raise DataError(
            f"{_where(table, block, bad[0], source)}: holds {words[int(bad[0])][:40]!r}; expected {' or '.join(signs)}"
        )
    return numbers


def _where(table: Table, block: TableRows, index: int, source: Source) -> str:
    return f"{table.place}, row {block.rows[int(index)]}, column {source.header!r}"


def _cuts(
    table: Table, block: TableRows, sources: dict[str, Source], values: Values, last: dict[str, float]
) -> list[int]:
    """Rows of a block that begin a run. Raises DataError for time that runs backwards within one."""
    cuts = set(block.starts)
    if "time" in values and len(block):
        kept = [key for key in ("time", "pressure_set") if key in values]
        before = {key: np.r_[last.get(key, values[key][0]), values[key][:-1]] for key in kept}
        back = values["time"] < before["time"]
        if "pressure_set" in values:
            cuts |= {int(k) for k in np.flatnonzero(back & (values["pressure_set"] != before["pressure_set"]))}
        wrong = [int(k) for k in np.flatnonzero(back) if int(k) not in cuts]
        if wrong:
            then, now = before["time"][wrong[0]], values["time"][wrong[0]]
            raise DataError(
                f"{_where(table, block, wrong[0], sources['time'])}: time runs backwards "
                f"({then:g} s, then {now:g} s); sort the rows or mend the clock"
            )
    return sorted(cuts)


def contraction_of(values: Values, length_mm: float) -> Array:
    """Contraction ratio, shape (n,), from whichever of the three the values hold."""
    if "contraction" in values:
        return values["contraction"]
    if "displacement" in values:
        return values["displacement"] / length_mm
    return 1.0 - values["length"] / length_mm


def _check_ranges(table: Table, block: TableRows, sources: dict[str, Source], values: Values, length_mm: float) -> None:
    contraction = contraction_of(values, length_mm)
    wild = np.flatnonzero(np.abs(contraction) >= MOST_CONTRACTION)
    if len(wild):
        key = next(k for k in SHAPES if k in values)
        raise DataError(
            f"{_where(table, block, wild[0], sources[key])}: contraction ratio {contraction[wild[0]]:.3g}; "
            f"expected within -{MOST_CONTRACTION} to {MOST_CONTRACTION}. Check the unit of the column and "
            "initial_length_mm of the specimen"
        )
    high = np.flatnonzero(np.abs(values["pressure"]) > MOST_MPA)
    if len(high):
        raise DataError(
            f"{_where(table, block, high[0], sources['pressure'])}: {values['pressure'][high[0]]:g} MPa; "
            f"expected a gauge pressure below {MOST_MPA:g} MPa. Check the unit of the column"
        )
    late = np.flatnonzero(np.abs(values.get("time", np.zeros(0))) > MOST_S)
    if len(late):
        raise DataError(
            f"{_where(table, block, late[0], sources['time'])}: {values['time'][late[0]]:g} s; expected a clock's "
            "count. Mend the row, or check the unit of the column"
        )


def same_quantities(first: Iterable[str], other: Iterable[str], place: str) -> None:
    """Raises DataError where two runs of a test hold other quantities."""
    if odd := set(first) ^ set(other):
        raise DataError(
            f"{place}: {', '.join(sorted(odd))} is in some files of this record and not in others; expected the "
            "same columns in all"
        )


def pause_between(usual_steps: Iterable[float]) -> float:
    """Seconds from one run to the next whose clock began anew: enough to be told from the runs' usual steps."""
    return max(60.0, 10.0 * max(usual_steps, default=0.0))


def join_runs(runs: Iterable[Values], place: str) -> Values:
    """One set of arrays from the runs of a test; a run whose clock began anew is put a pause after the one before.

    Raises DataError where runs hold other quantities.
    """
    found = list(runs)
    if len(found) == 1:
        return found[0]
    for values in found[1:]:
        same_quantities(found[0], values, place)
    if "time" in found[0]:
        pause = pause_between(np.quantile(np.diff(v["time"]), 0.95) for v in found if len(v["time"]) > 1)
        for before, values in pairwise(found):
            if values["time"][0] <= before["time"][-1]:
                values["time"] = values["time"] + (before["time"][-1] + pause - values["time"][0])
    return {key: np.concatenate([values.pop(key) for values in found]) for key in list(found[0])}
