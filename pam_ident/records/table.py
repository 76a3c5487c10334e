"""A table as a file holds it, before its columns are known: what every loader hands on; and its cells as numbers, with
what loggers write beside plain numbers (clock times, per cent, nothing).
"""

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime, time, timedelta
from typing import TYPE_CHECKING

import numpy as np

from ..core import Array
from ..core.units import TO_INTERNAL

if TYPE_CHECKING:
    import pandas as pd

EMPTY = {"", "-", "--", "---", "na", "n/a", "nan", "nat", "none", "null", "<na>", "#n/a"}
"""Words for a reading that is missing, in lower case."""
DAY = 86400.0
A_DAY_STEP = 1e-4
"""Step of a clock in no unit, below which it counts days: 9 s of them, or else 10,000 rows in a second."""
_CLOCK = re.compile(r"(?:(\d{1,3}):)?([0-5]?\d):([0-5]?\d(?:\.\d*)?)(?: ?([AP])M)?", re.IGNORECASE)
_DAY_FIRST = re.compile(r"^(\d\d)\.(\d\d)\.(\d{4})(?=[ T])")
_SLASHED = re.compile(r"^\d{1,2}/\d{1,2}/\d{2,4},?[ T]+")
"""A date that may begin with its day or its month: the time of day beside it tells where a day ends."""
_THOUSANDS = {mark: re.compile(rf"[-+]?\d{{1,3}}([{mark}]\d{{3}})+[^{mark}\d]\d+") for mark in ",."}


@dataclass(frozen=True)
class TableRows:
    """Some rows of a table. `cells` maps a column's position to its cells, `rows` numbers the rows as the file does,
    `starts` are the rows (from 0 in this block) at which the file begins anew, with its header repeated.
    """

    cells: "Mapping[int, pd.Series | np.ndarray]"
    rows: Sequence[int]
    starts: tuple[int, ...] = ()

    def __len__(self) -> int:
        return len(self.rows)


@dataclass(frozen=True)
class Table:
    """A table of a file. `place` names it in errors (the file, and the sheet or group in it), `head` its header there.

    `names` are the headers as written, `headers` those with the units of a row of units. `read` takes the positions of
    the columns that are wanted and gives the rows block by block. `decimal` is the decimal mark of cells that are text;
    `doubtful` maps a column's position to a cell whose point may as well part thousands, where nothing else tells.
    """

    place: str
    head: str
    names: tuple[str, ...]
    headers: tuple[str, ...]
    read: Callable[[Sequence[int]], Iterable[TableRows]]
    decimal: str = "."
    doubtful: Mapping[int, str] = field(default_factory=dict)


def table_in_memory(
    place: str, head: str, frame: "pd.DataFrame", first_row: int, names: Sequence[str] = (), decimal: str = "."
) -> Table:
    """A table whose columns are read already; `frame`'s columns are the headers, its first row is `first_row`."""

    def read(wanted: Sequence[int]) -> Iterator[TableRows]:
        yield TableRows({k: frame.iloc[:, k] for k in wanted}, range(first_row, first_row + len(frame)))

    headers = tuple(map(str, frame.columns))
    return Table(place, head, tuple(names) or headers, headers, read, decimal)


def number_of(cell: object, decimal: str = ".") -> float:
    """A cell as a number, NaN where it is none; before a decimal mark the other one stands between thousands."""
    if isinstance(cell, str):
        other = "," if decimal == "." else "."
        if other in cell and _THOUSANDS[other].fullmatch(cell.strip()):
            cell = cell.replace(other, "")
        if "_" in cell or (decimal != "." and "." in cell):
            return np.nan
        cell = cell.replace(decimal, ".")
    elif isinstance(cell, bool | np.bool_) or not isinstance(cell, int | float | np.number):
        return np.nan
    try:
        return float(cell)
    except (ValueError, OverflowError):
        return np.nan


def count_numbers(cells: Iterable[object], decimal: str = ".") -> int:
    """How many cells are finite numbers."""
    return sum(math.isfinite(number_of(cell, decimal)) for cell in cells)


@dataclass(frozen=True)
class Numbers:
    """Cells (n,) as numbers, NaN where they are none: those `done` are in internal units already, others in the
    column's. `empty` ones hold nothing; the rest of the NaN is no number."""

    values: Array
    done: Array
    empty: Array

    def scaled(self, factor: float, offset: float) -> Array:
        """In internal units; what no number can hold is infinite."""
        if (factor, offset) == (1.0, 0.0):
            return self.values
        with np.errstate(over="ignore", invalid="ignore"):
            return np.where(self.done, self.values, self.values * factor + offset)


@dataclass
class Clock:
    """Clock times of a table as seconds since its first one: `hh:mm:ss`, which pass midnight, `mm:ss.0`, ISO times."""

    first: float | datetime | None = None
    last: float = 0.0
    days: int = 0
    midnight: int | None = None
    """Index among the cells read last at which the clock passed midnight."""

    def seconds(self, cell: object, index: int) -> float:
        """A cell as seconds since the first, NaN where it is no clock time."""
        found = _moment(cell)
        if found is None:
            return np.nan
        if self.first is None:
            self.first = found
        try:
            since = found - self.first  # type: ignore[operator]
        except TypeError:  # a date and none, or a time zone and none
            return np.nan
        if isinstance(since, timedelta):
            return since.total_seconds()
        if since + DAY * self.days < self.last - DAY / 2:
            self.days, self.midnight = self.days + 1, index
        self.last = since + DAY * self.days
        return self.last


def without_unit(header: str, clock: Array) -> str:
    """What is said of a column of time (n,) that holds numbers and states no unit: spreadsheets count days."""
    steps = np.diff(clock[np.isfinite(clock)])
    days = len(steps) and 0.0 < np.median(steps) < A_DAY_STEP
    hint = "; these steps are small, as of a spreadsheet's days: Time [day]" if days else ""
    units = ", ".join(TO_INTERNAL["time"])
    return f"column {header!r}: no unit given; expected one of {units} for a time (as suffix or in brackets){hint}"


def numbers_in(cells: "pd.Series | Array", dimension: str, decimal: str, clock: Clock) -> Numbers:
    """The cells (n,) of a column of a dimension as numbers. Raises DataError for nothing: what is wrong is NaN."""
    n = len(cells)
    done = np.zeros(n, bool)
    kind = cells.dtype.kind
    if kind in "fiu":
        values = np.asarray(cells, dtype=float)
        empty = done if np.isfinite(values).all() else np.isnan(values)
        if dimension == "time" and clock.first is not None:
            values = np.full(n, np.nan)
        return Numbers(values, done, empty)
    listed = list(cells)
    values = np.array([number_of(cell, decimal) for cell in listed], dtype=float)
    empty = np.zeros(n, bool)
    clock.midnight = None
    clocked = dimension == "time" and (clock.first is not None or np.isnan(values[:1]).any())
    for k in np.flatnonzero(np.isnan(values)).tolist():
        cell = listed[k]
        if cell is None or cell != cell or str(cell).strip().lower() in EMPTY:
            empty[k] = True
        elif clocked:
            values[k] = clock.seconds(cell.replace(decimal, ".") if isinstance(cell, str) else cell, k)
        elif dimension == "ratio" and isinstance(cell, str) and cell.rstrip().endswith("%"):
            values[k] = number_of(cell.rstrip()[:-1].rstrip(), decimal) / 100.0
        done[k] = np.isfinite(values[k])
    if dimension == "time" and clock.first is not None:
        values[~done] = np.nan  # numbers among clock times: seconds of what?
    return Numbers(values, done, empty)


def _moment(cell: object) -> float | datetime | None:
    """A clock time: seconds of the day or since a start, or date and time."""
    if isinstance(cell, timedelta):
        return cell.total_seconds()
    if isinstance(cell, np.datetime64):
        cell = cell.astype("datetime64[us]").item()
    if isinstance(cell, datetime):
        return cell
    if isinstance(cell, time):
        return 3600.0 * cell.hour + 60.0 * cell.minute + cell.second + 1e-6 * cell.microsecond
    if not isinstance(cell, str) or ":" not in cell:
        return None
    text = cell.strip()
    if found := _CLOCK.fullmatch(_SLASHED.sub("", text)):
        hours, minutes, seconds, half = found.groups()
        if hours is None and "." not in seconds:  # hours and minutes, or minutes and seconds?
            return None
        hour = float(hours or 0) if half is None else float(hours or 0) % 12 + 12 * (half.upper() == "P")
        return 3600.0 * hour + 60.0 * float(minutes) + float(seconds)
    try:
        return datetime.fromisoformat(_DAY_FIRST.sub(r"\3-\2-\1", text))
    except ValueError:
        return None
