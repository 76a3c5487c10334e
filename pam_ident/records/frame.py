"""A record from a table of pandas."""

from typing import TYPE_CHECKING

from ..core import DataError, Specimen
from .columns import join_runs, read_columns
from .load import build_loaded
from .quantities import find_sources
from .record import Record
from .table import table_in_memory

if TYPE_CHECKING:
    import pandas as pd


def record_from_frame(frame: "pd.DataFrame", specimen: Specimen, name: str = "") -> Record:
    """A record from a table whose columns are found by name and unit, as those of a file are (`Pressure [bar]`).

    Errors count rows from 0, as `frame.iloc` does. Raises DataError for columns that are missing or of unknown unit,
    for cells that are no numbers, time that runs backwards and values beyond reason.
    """
    place = f"table {name!r}" if name else "the table"
    if frame.empty:
        raise DataError(f"{place}: has no rows; expected one row a sample")
    table = table_in_memory(place, place, frame.reset_index(drop=True), 0)
    sources = find_sources(table)
    values = join_runs(read_columns(table, sources, specimen.initial_length_mm), place)
    where = {key: source.header for key, source in sources.items()}
    return build_loaded(name or specimen.name, name or "table", "", specimen, values, where)
