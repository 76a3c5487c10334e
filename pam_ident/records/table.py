"""A table as a file holds it, before its columns are known: what every loader hands on."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import pandas as pd


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
    """A cell as a number, NaN where it is none; a point is no decimal mark where the mark is a comma."""
    if isinstance(cell, str):
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
