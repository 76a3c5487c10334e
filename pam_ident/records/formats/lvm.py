"""LabVIEW measurement files (.lvm, versions 1 and 2): text with heads of its own; each segment is a run of the test.

The format is National Instruments' "Specification for the LabVIEW Measurement File".
"""

from pathlib import Path

import numpy as np

from ...core import DataError
from ..heading import with_unit
from ..mapping import Mapping
from ..quantities import quantity_of
from ..table import Table, number_of, table_in_memory
from ..text_table import read_text
from .base import Format

END = "***End_of_Header***"
Entries = dict[str, list[str]]


def read_tables(path: Path, mapping: Mapping | None = None) -> list[Table]:
    """The segments of a file. The column X_Value is the time where X_Dimension says so, and is counted from X0 in steps
    of Delta_X where it is left empty; units are those of Y_Unit_Label. Text without the format's first line is read as
    a plain table. Raises DataError.
    """
    lines = path.read_text(encoding="latin-1").replace("\r\n", "\n").split("\n")
    if not lines[0].startswith("LabVIEW Measurement"):
        return read_text(path, mapping)
    ends = [k for k, line in enumerate(lines) if line.strip().startswith(END)]
    if len(ends) < 2:
        raise DataError(f"{path}: {len(ends)} lines {END}; expected one after the file's head and one for each segment")
    separator = "," if any(line.startswith("Separator,") for line in lines[: ends[0]]) else "\t"
    file = _entries(lines[: ends[0]], separator)
    tables, last = [], ends[0]
    for end, following in zip(ends[1:], [*ends[2:], len(lines)], strict=True):
        head = file | _entries(lines[last + 1 : end], separator)
        last = next((k for k in range(end + 1, following) if lines[k].startswith("Channels")), following) - 1
        tables.append(_segment(str(path), head, lines[end + 1 : last + 1], end + 2, separator))
    return tables


def _entries(lines: list[str], separator: str) -> Entries:
    """The entries of a head: a word, then a value for each channel."""
    rows = [[cell.strip() for cell in line.split(separator)] for line in lines]
    return {row[0]: row[1:] for row in rows if row[0]}


def _segment(place: str, head: Entries, lines: list[str], row: int, separator: str) -> Table:
    """A segment: the line of names, which is row `row` of the file, then samples, perhaps with a comment at the end."""
    import pandas as pd

    while lines and not lines[-1].strip():
        lines = lines[:-1]
    names = [name.strip() for name in lines[0].split(separator)] if lines else []
    if len(lines) < 2 or names[0] != "X_Value":
        raise DataError(f"{place}, row {row}: no samples after a segment's head; expected X_Value, channels and rows")
    names = [name for name in names if name not in ("", "Comment")]
    cells = [line.split(separator) for line in lines[1:]]
    for number, cut in enumerate(cells, row + 1):
        if not len(names) <= len(cut) <= len(names) + 1:
            raise DataError(
                f"{place}, row {number}: {len(cut)} cells; expected {len(names)} and perhaps a comment. Fix the row"
            )
    told = number_of("".join(head.get("Samples", [])[:1]))
    if np.isfinite(told) and told != len(cells):
        raise DataError(f"{place}, row {row}: {len(cells)} rows, but the head says {told:g} samples; copy it again")
    columns: dict[str, object] = {}
    units = iter(head.get("Y_Unit_Label", []))
    for k, name in enumerate(names):
        if name == "X_Value":
            if "X_Value" not in columns:
                columns[name] = _x_values(head, [cut[k] for cut in cells])
            continue
        unit = next(units, "")
        header = with_unit(name, unit, f"{place}, row {row}, channel {name!r}")
        if header in columns:
            raise DataError(f"{place}, row {row}: two columns are called {header!r}; keep one")
        columns[header] = [cut[k].strip() for cut in cells]
    if (head.get("X_Dimension") or ["Time"])[0] == "Time" and "time" not in map(quantity_of, columns):
        columns = {"time [s]" if name == "X_Value" else name: column for name, column in columns.items()}
    frame = pd.DataFrame(columns, dtype=object)
    decimal = (head.get("Decimal_Separator") or ["."])[0] or "."
    return table_in_memory(place, f"{place}, row {row}", frame, row + 1, decimal=decimal)


def _x_values(head: Entries, cells: list[str]) -> object:
    """The cells of X, or its values from start and step where the cells are empty."""
    if any(cell.strip() for cell in cells):
        return [cell.strip() for cell in cells]
    start, step = (number_of("".join(head.get(key, [])[:1]).replace(",", ".")) for key in ("X0", "Delta_X"))
    return start + step * np.arange(len(cells))


FORMAT = Format((".lvm",), read_tables)
