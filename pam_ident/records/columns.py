"""The columns of a table in internal units, checked block by block: every refusal names file, row and column."""

import json
from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from ..core import Array, DataError
from ..core.units import ATMOSPHERE_MPA
from .faulty import frozen_rows, impossible_rows, spike_rows
from .notes import Notes
from .quantities import BRANCHES, QUANTITIES, SHAPES, Source
from .ranges import Values, check_empty, check_ranges, place_of
from .table import Clock, Table, TableRows, numbers_in, without_unit

SHUFFLED = 0.1
"""Share of the rows before which time runs backwards from which they are in no order, rather than of several runs."""
SENSORS = {"time", "pressure", "pressure_set", *SHAPES, "force", "temperature", "cycle", "torque", "angle"}
"""Quantities whose empty cells cost a row; branch and slack must be said in each."""
FAULTS = {"frozen_sensor": frozen_rows, "impossible_value": impossible_rows, "spike": spike_rows}
"""Code of a note → what finds the rows, by quantity, that are left out for it."""


def read_columns(
    table: Table, sources: dict[str, Source], length_mm: float, notes: Notes | None = None
) -> Iterator[Values]:
    """Each run of a table, whole; what a run is, what is noted, and what is raised, as `read_pieces` says."""
    run: Values = {}
    n = 0
    for begins, values in read_pieces(table, sources, length_mm, notes or Notes()):
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


def read_pieces(
    table: Table, sources: dict[str, Source], length_mm: float, notes: Notes
) -> Iterator[tuple[bool, Values]]:
    """The rows of a table piece by piece, and whether a run begins with each: a file whose header comes again, or whose
    clock begins anew with another pressure_set, holds several.

    `length_mm` is the muscle's initial length. Rows with an empty cell of a sensor, with a sensor that hangs, or with a
    spike of the force are left out and counted in `notes`, where all else stands that was assumed. Raises DataError for
    what is no number, for a column that is empty in most rows, for time that runs backwards, and for values beyond
    reason.
    """
    last: dict[str, float] = {}
    begins, seen, now = True, 0, -np.inf
    clock, gone = Clock(), dict.fromkeys(sources, 0)
    first: dict[str, int] = {}
    _note_table(table, sources, notes)
    for block in table.read([s.position for s in sources.values() if s.position is not None]):
        seen += len(block)
        values, empty = {}, {}
        for key, source in sources.items():
            values[key], empty[key] = _column(table, block, source, key, clock, notes)
        for key, rows in empty.items():
            gone[key] += int(rows.sum())
            if rows.any():
                first.setdefault(key, block.rows[int(rows.argmax())])
        block, values = _without(table, block, sources, values, empty, "empty_cells", notes)
        _by_lever(table, block, sources, values)
        check_ranges(table, block, sources, values, length_mm)
        for code, faults in FAULTS.items():
            block, values = _without(table, block, sources, values, faults(values), code, notes)
        cuts = _cuts(table, block, sources, values, last)
        if len(block):
            last = {key: float(values[key][-1]) for key in ("time", "pressure_set") if key in values}
        for begin, end in pairwise([0, *cuts, len(block)]):
            begins = begins or begin in cuts
            if end > begin:
                piece = {key: column[begin:end] for key, column in values.items()}
                if "time" in piece:
                    piece["time"] = spread(piece["time"], -np.inf if begins else now)
                    now = float(piece["time"][-1])
                    put = np.flatnonzero(piece["time"] != values["time"][begin:end])
                    if len(put):
                        where = f"{table.place}, row {block.rows[begin + put[0]]}"
                        notes.add("coarse_clock", sources["time"].header, where, len(put))
                yield begins, piece
                begins = False
    check_empty(table, sources, gone, first, seen)
    if begins and not last:
        raise DataError(f"{table.place}: a header but no rows of numbers; expected one row a sample")


def spread(time: Array, before: float) -> Array:
    """Times (n,) of which those that are alike, of a clock coarser than the rows, lie evenly within its tick; none is
    earlier than `before`."""
    first = np.flatnonzero(np.diff(time, prepend=np.nan))
    steps = np.diff(time[first])
    if len(first) == len(time) or not len(steps):
        return time
    alike = np.diff(np.append(first, len(time)))
    share = (np.arange(len(time)) - np.repeat(first, alike)) / np.repeat(alike, alike)
    return np.maximum(time + float(steps.min()) * share, before)


def _by_lever(table: Table, block: TableRows, sources: dict[str, Source], values: Values) -> None:
    """Put force and shape in the place of torque and angle. Raises DataError where the torque tells no force."""
    lever = sources["force"].lever
    if lever is None:
        return
    torque, angle = values.pop("torque"), values.pop("angle")
    dead = np.flatnonzero(lever.dead(angle))
    if len(dead):
        arm = f"{lever.arm(angle)[dead[0]]:.2g} mm"
        raise DataError(
            f"{place_of(table, block, dead[0], sources['angle'])}: the lever's arm is {arm} "
            "there, from which no force can be told. Check [lever] of columns.toml, or leave such rows out"
        )
    values |= lever.converted(torque, angle)


def _note_table(table: Table, sources: dict[str, Source], notes: Notes) -> None:
    """What is known before a row is read."""
    for position, cell in table.doubtful.items():
        for source in sources.values():
            if source.position == position:
                notes.add("decimal_point", source.header, repr(cell))
    if sources["force"].lever is not None:
        notes.add("lever", "force", sources["force"].lever.text)
    if guessed := [f"{key} from {source.header!r}" for key, source in sources.items() if source.guessed]:
        notes.add("guessed_columns", None, ", ".join(guessed))
    for source in sources.values():
        if source.absolute:
            notes.add("absolute_pressure", source.header, f"{ATMOSPHERE_MPA:g} MPa")


def _without(
    table: Table,
    block: TableRows,
    sources: dict[str, Source],
    values: Values,
    bad: dict[str, Array],
    code: str,
    notes: Notes,
) -> tuple[TableRows, Values]:
    """The block less the rows of any of the masks `bad`, each noted."""
    drop = np.zeros(len(block), bool)
    for key, rows in bad.items():
        if fresh := int(np.count_nonzero(rows & ~drop)):
            row = block.rows[int(np.argmax(rows & ~drop))]
            notes.add(code, sources[key].header, f"{table.place}, row {row}", fresh)
        drop |= rows
    if not drop.any():
        return block, values
    keep = ~drop
    left = np.r_[0, np.cumsum(keep)]
    starts = tuple(int(left[start]) for start in block.starts)
    rows = np.asarray(block.rows)[keep].tolist()
    return replace(block, rows=rows, starts=starts), {key: column[keep] for key, column in values.items()}


def _with_room(column: Array, n: int, needed: int) -> Array:
    """The first n rows of a column with room for `needed` and as many again, which take no memory until they are used;
    to join all blocks at the end would take the memory twice."""
    wider = np.empty(2 * needed)
    wider[:n] = column[:n]
    return wider


def _column(
    table: Table, block: TableRows, source: Source, key: str, clock: Clock, notes: Notes
) -> tuple[Array, Array]:
    """A column in internal units, and the mask of its empty cells, both (n,)."""
    empty = np.zeros(len(block), bool)
    if source.position is None:
        return np.full(len(block), source.value), empty
    if key == "branch":
        return _directions(table, block, source), empty
    cells = block.cells[source.position]
    found = numbers_in(cells, QUANTITIES.get(key, key), table.decimal, clock)
    finite = np.isfinite(found.values)
    if key in SENSORS:
        empty = found.empty
    if not finite.all() and len(bad := np.flatnonzero(~finite & ~empty)):
        cell = np.asarray(cells)[bad[0]]
        what = "is empty or NaN" if found.empty[bad[0]] else f"holds {str(cell)[:40]!r}"
        more = f" (and {len(bad) - 1} more rows)" if len(bad) > 1 else ""
        mark = " with a decimal comma, as elsewhere" if table.decimal == "," else ""
        other = ", hh:mm:ss, mm:ss.0, dd.mm.yyyy hh:mm:ss or an ISO time, the same in all rows" if key == "time" else ""
        raise DataError(
            f"{place_of(table, block, bad[0], source)}: {what}{more}; expected a number{mark}{other}. Fix or "
            "delete the row"
        )
    if source.unit_missing and not (found.done | empty).all():
        raise DataError(f"{table.place}, {without_unit(source.header, found.values)}")
    if key == "time" and clock.midnight is not None:
        notes.add("midnight", source.header, f"{table.place}, row {block.rows[clock.midnight]}")
    return found.scaled(source.factor, source.offset), empty


def _directions(table: Table, block: TableRows, source: Source) -> Array:
    assert source.position is not None
    signs = dict(source.words)
    words = [f"{c:g}" if isinstance(c, float) else str(c).strip().lower() for c in block.cells[source.position]]
    numbers = np.array([signs.get(word, np.nan) for word in words])
    bad = np.flatnonzero(np.isnan(numbers))
    if len(bad):
        named = json.dumps(source.header, ensure_ascii=False)
        there = [json.dumps(word[:40], ensure_ascii=False) for word in dict.fromkeys(words) if word not in signs]
        ways = ", ".join(f"{way} = {word}" for way, word in zip(BRANCHES, [*there, '"?"'], strict=False))
        raise DataError(
            f"{place_of(table, block, bad[0], source)}: holds {words[int(bad[0])][:40]!r}; expected "
            f"{' or '.join(signs)}, or which word is which beside the other columns in a columns.toml: "
            f"branch = {{ column = {named}, {ways} }}, or the other way round"
        )
    return numbers


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
            more = f", and so in {len(wrong) - 1} rows more" * (len(wrong) > 1)
            another = (
                "where another run begins, give it a file of its own in one folder, or a header above it; else fix the "
                "clock"
            )
            advice = "sort the rows or fix the clock" if len(wrong) > SHUFFLED * len(block) else another
            raise DataError(
                f"{place_of(table, block, wrong[0], sources['time'])}: time runs backwards ({then:g} s, then {now:g} s"
                f"){more}; {advice}"
            )
    return sorted(cuts)


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
