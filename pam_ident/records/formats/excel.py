"""Excel workbooks (.xlsx): each sheet is a table, or a run of the test."""

from pathlib import Path
from typing import Any

from ...core import DataError
from ..heading import find_heading
from ..mapping import Mapping
from ..quantities import quantity_of
from ..table import Table, table_in_memory
from .base import Format, reading

HEAD_ROWS = 200


def read_tables(path: Path, mapping: Mapping | None = None) -> list[Table]:
    """The sheets that hold anything. Raises DataError where there are none, UsageError without openpyxl."""
    # Opened here: openpyxl leaves the file open where it breaks off.
    with path.open("rb") as file, reading(path, "openpyxl", "Excel workbook", "save it again as .xlsx"):
        import openpyxl

        book = openpyxl.load_workbook(file, read_only=True, data_only=True)
        sheets = {sheet.title: [list(row) for row in sheet.iter_rows(values_only=True)] for sheet in book.worksheets}
        book.close()
    wanted = mapping.layout.get("part") if mapping else None
    if wanted is not None and wanted not in sheets:
        raise DataError(f"{path}: no sheet {wanted!r} ({mapping.path if mapping else ''}) among {', '.join(sheets)}")
    tables = [
        table
        for name, rows in sheets.items()
        if wanted in (None, name) and (table := _table(f"{path}, sheet {name!r}", rows, mapping))
    ]
    if not tables:
        raise DataError(f"{path}: the file is empty: no sheet with a header row and one row a sample; save it again")
    return tables


def _table(place: str, rows: list[list[Any]], mapping: Mapping | None) -> Table | None:
    """The table of a sheet, None where the sheet holds none."""
    import pandas as pd

    while rows and all(cell is None for cell in rows[-1]):
        rows.pop()
    head = [["" if cell is None else str(cell) for cell in row] for row in rows[:HEAD_ROWS]]
    line = mapping.layout.get("header_row", 0) if mapping else 0
    known, enough = (mapping.known, mapping.enough) if mapping else (quantity_of, 2)
    heading = find_heading(head[max(line - 1, 0) :], known, enough)
    shift = max(line - 1, 0)
    first, width = heading.first + shift, max(map(len, rows), default=0)
    if first >= len(rows) and heading.score < enough:
        return None
    if first >= len(rows):
        raise DataError(f"{place}: a header but no rows of numbers; expected one row a sample")
    if heading.header is None:
        names, headers, row = tuple(f"column {k + 1}" for k in range(width)), (), first + 1
    else:
        row = heading.header + shift + 1
        names, headers = heading.names, heading.headers(f"{place}, row {row}")
    frame = pd.DataFrame(rows[first:], columns=pd.Index(headers or names), dtype=object)
    return table_in_memory(place, f"{place}, row {row}", frame, first + 1, names)


FORMAT = Format((".xlsx", ".xlsm"), read_tables)
