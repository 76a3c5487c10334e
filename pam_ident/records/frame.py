"""A record from a table of pandas."""

from dataclasses import replace
from typing import TYPE_CHECKING

from ..core import DataError, Specimen
from .columns import join_runs, read_columns
from .load import build_loaded, left_out, note_clock
from .notes import Notes
from .record import Record
from .sources import Finder, find_sources
from .table import table_in_memory

if TYPE_CHECKING:
    import pandas as pd


def record_from_frame(frame: "pd.DataFrame", specimen: Specimen, name: str = "", find: Finder = find_sources) -> Record:
    """A record from a table whose columns are found by name and unit, as those of a file are (`Pressure [bar]`).

    Args:
        frame: a row a sample. Errors count rows from 0, as `frame.iloc` does.
        specimen: the muscle.
        name: of the record; by default the specimen's.
        find: what finds the columns; by default those of a record.

    Raises:
        DataError: for columns that are missing or of unknown unit, cells that are no numbers, time that runs backwards
            and values beyond reason.

    Example:
        >>> import pandas as pd
        >>> from pam_ident.core import Specimen
        >>> from pam_ident.records import record_from_frame
        >>> table = pd.DataFrame({"Pressure [bar]": [2.0, 2.0], "length_mm": [200, 180], "Force (kN)": [0.45, 0.21]})
        >>> record = record_from_frame(table, Specimen("muscle 7", initial_length_mm=200.0))
        >>> print(record.inputs.pressure, "MPa,", record.inputs.contraction, "of the length,", record.force, "N")
        [0.2 0.2] MPa, [0.  0.1] of the length, [450. 210.] N
    """
    place = f"table {name!r}" if name else "the table"
    if frame.empty:
        raise DataError(f"{place}: has no rows; expected one row a sample")
    table = table_in_memory(place, place, frame.reset_index(drop=True), 0)
    sources = find(table)
    notes = Notes()
    values = join_runs(read_columns(table, sources, specimen.initial_length_mm, notes), place)
    where = {key: source.header for key, source in sources.items()}
    passed, clock = left_out(table, sources)
    note_clock(notes, values, specimen, passed, clock)
    found = build_loaded(name or specimen.name, name or "table", "", specimen, values, where, notes)
    return replace(found, passed=passed)
