"""Whether the values of a table can be a muscle's: every refusal names file, row and column."""

from collections.abc import Iterator

import numpy as np

from ..core import Array, DataError
from .quantities import SHAPES, Source
from .table import Table, TableRows

MOST_CONTRACTION = 0.95
AT_REST = 0.1
"""Share of the initial length by which a longest length may miss it: a muscle is about as long when it rests."""
MOST = {
    "time": (1e13, "s", "seconds"),
    "pressure": (10.0, "MPa", "a gauge pressure below 10 MPa"),
    "pressure_set": (10.0, "MPa", "a gauge pressure below 10 MPa"),
    "force": (1e7, "N", "a force below 1e7 N"),
    "temperature": (1e3, "°C", "a temperature below 1000 °C"),
    "cycle": (1e9, "", "the number of a cycle"),
}
"""Quantity → the largest magnitude that is read in its internal unit, the unit, what was expected: beyond lies no
muscle, and soon no number."""
MOST_EMPTY = 0.5
"""Share of a column's cells that may be empty."""
SET_APART, NO_PRESSURE_MPA = 5.0, 0.02
"""Ratio of commanded and measured pressure that no regulator leaves; pressures that are not asked."""

Values = dict[str, Array]
"""Quantity → array of shape (n,) in internal units."""


def place_of(table: Table, block: TableRows, index: int, source: Source) -> str:
    """File, row and column of a cell."""
    return f"{table.place}, row {block.rows[int(index)]}, column {source.header!r}"


def contraction_of(values: Values, length_mm: float) -> Array:
    """Contraction ratio, shape (n,), from whichever of the three the values hold."""
    if "contraction" in values:
        return values["contraction"]
    if "displacement" in values:
        return values["displacement"] / length_mm
    return 1.0 - values["length"] / length_mm


def check_ranges(table: Table, block: TableRows, sources: dict[str, Source], values: Values, length_mm: float) -> None:
    """Refuse values (n,) in internal units that no muscle has, and a commanded pressure that is none of the measured
    one's size: it names the isobars. Raises DataError."""
    for key, row, wrong in beyond_reason(values, length_mm):
        raise DataError(f"{place_of(table, block, row, sources[key])}: {wrong}")
    if "pressure_set" not in values:
        return
    there = (values["pressure_set"] > NO_PRESSURE_MPA) & (values["pressure"] > NO_PRESSURE_MPA)
    ratio = float(np.median(values["pressure_set"][there] / values["pressure"][there])) if there.any() else 1.0
    if not 1.0 / SET_APART < ratio < SET_APART:
        raise DataError(
            f"{table.place}, column {sources['pressure_set'].header!r}: {ratio:.3g} times the pressure measured "
            f"({sources['pressure'].header!r}); expected about as much. Check the units of both columns"
        )


def beyond_reason(values: Values, length_mm: float) -> Iterator[tuple[str, int, str]]:
    """The first value of each quantity (n,) in internal units that no muscle has: the quantity, its row from 0, and
    what is wrong."""
    contraction = contraction_of(values, length_mm)
    wild = np.flatnonzero(~(np.abs(contraction) < MOST_CONTRACTION))
    if len(wild):
        check = "Check its unit, and initial_length_mm of the specimen"
        if "displacement" in values and abs(float(np.nanmax(contraction)) - 1.0) < AT_REST:
            check = "It looks like the muscle's length: call the column length_mm"
        wrong = (
            f"contraction ratio {contraction[wild[0]]:.3g}; expected within -{MOST_CONTRACTION} to {MOST_CONTRACTION}. "
            f"{check}"
        )
        yield next(k for k in SHAPES if k in values), int(wild[0]), wrong
    for key, (most, unit, meant) in MOST.items():
        if key not in values or not len(values[key]) or -most <= values[key].min() <= values[key].max() <= most:
            continue
        high = np.flatnonzero(~(np.abs(values[key]) <= most))
        if len(high):
            yield key, int(high[0]), f"{values[key][high[0]]:g} {unit}; expected {meant}. Check its unit, and the cell"


def check_empty(
    table: Table, sources: dict[str, Source], gone: dict[str, int], first: dict[str, int], seen: int
) -> None:
    """Refuse a column with `gone` empty cells, from row `first` on, in most of the `seen` rows. Raises DataError."""
    for key, n in gone.items():
        if n > MOST_EMPTY * seen:
            what = "holds nothing in any row" if n == seen else f"is empty in {n} of {seen} rows"
            raise DataError(
                f"{table.place}, row {first[key]}, column {sources[key].header!r}: {what}; expected numbers, since a "
                "row with an empty cell is left out. Fill the column, or take it out"
            )
