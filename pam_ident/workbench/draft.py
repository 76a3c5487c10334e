"""Files that came through the browser, as a record, or before they are one: columns with what each may be, for a person
to correct."""

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from ..core import DataError, PamError, Specimen, UsageError
from ..core.units import split_header
from ..records import Record, read_record
from ..records.files import check_unpacked, read_tables
from ..records.guess import Guess, column_of, guess_columns, units_of
from ..records.mapping import Mapping as Told
from ..records.mapping import read_mapping
from ..records.run_constants import read_runs
from ..records.table import Table, number_of

ROWS, SHOWN = 2000, 4
"""Rows that a guess looks at, and those that are shown."""
LAYOUTS = ({}, {"header_row": 0}, {"decimal": ","}, {"header_row": 0, "decimal": ","})
"""Ways of reading a text table, the first that works is taken."""
COMPANIONS = ("specimen.toml", "columns.toml")
MOST_UNPACKED = 1 << 30
"""Bytes that a file may have behind its compression."""
UNSAFE = re.compile(r"[^\w.\- ]|^[.\s]+", re.ASCII)
NEEDED = {"pressure": "the pressure", "force": "the force", "displacement": "the displacement"}


@dataclass(frozen=True)
class DraftColumn:
    """A column of a file: its first cells, its range, and what it is: internal = unit · (factor · cell + offset)."""

    name: str
    first: tuple[str, ...]
    low: float
    high: float
    guess: Guess
    factor: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class Draft:
    """Dropped files with their columns. `problem` is why they are no record yet, empty where they are one; `ours` that
    the columns can be changed here, and are not those of a columns.toml that says more."""

    files: Mapping[str, bytes]
    columns: tuple[DraftColumn, ...]
    layout: Mapping[str, object]
    problem: str = ""
    ours: bool = True

    @classmethod
    def of(cls, files: Mapping[str, bytes]) -> "Draft":
        """Look into the first of the files. Raises UsageError without one, DataError where it holds no table."""
        named = {safe_name(name): content for name, content in files.items()}
        runs = [name for name in named if name.lower() not in COMPANIONS]
        told = next((content for name, content in named.items() if name.lower() == COMPANIONS[1]), None)
        if not runs:
            return cls(files, (), {}, ours=False)  # `read` says what is missing
        with TemporaryDirectory(prefix="pam-ident-") as place:
            path = Path(place, runs[0])
            path.write_bytes(named[runs[0]])
            try:
                check_unpacked(path, MOST_UNPACKED)
                mapping = _told(Path(place, COMPANIONS[1]), told)
                table, layout = _table(path, mapping)
                columns = _columns(table, mapping)
            except PamError as error:
                raise type(error)(here(str(error), place)) from None
        more = mapping is not None and (mapping.for_all or mapping.runs.constants)
        return cls(files, columns, layout, ours=not more)

    @property
    def missing(self) -> tuple[str, ...]:
        """What no column holds, in words."""
        held = {column.guess.quantity for column in self.columns}
        held |= {"displacement"} if held & {"contraction", "length"} else set()
        return tuple(words for name, words in NEEDED.items() if name not in held)

    @property
    def has_specimen(self) -> bool:
        """Whether a specimen.toml is among the files."""
        return any(safe_name(name).lower() == COMPANIONS[0] for name in self.files)

    @property
    def toml(self) -> str:
        """The columns.toml that says what each column is."""
        lines = ["[columns]", *(_entry(self.columns, k) for k, c in enumerate(self.columns) if c.guess.quantity)]
        if self.layout:
            lines += ["", "[file]", *(f"{key} = {json.dumps(value)}" for key, value in self.layout.items())]
        return "\n".join(lines) + "\n"

    def read(self, specimen: Specimen | None, by_hand: bool = True) -> tuple[Record, str]:
        """The record and its name: by the columns as they stand here, or by the files alone. Raises DataError,
        UsageError."""
        files = dict(self.files)
        if by_hand and self.ours:
            if self.missing:
                raise DataError(f"no column is said to be {' or '.join(self.missing)}; choose it in the table")
            files = {name: content for name, content in files.items() if safe_name(name).lower() != COMPANIONS[1]}
            files[COMPANIONS[1]] = self.toml.encode()
        return read_dropped(files, specimen)

    def told(self, k: int, quantity: str, unit: str, factor: float, offset: float) -> "Draft":
        """With column k said to be something, in a unit that it can have."""
        units = units_of(quantity)
        guess = Guess(quantity, unit if unit in units else (units[0] if units else ""), True)
        columns = list(self.columns)
        columns[k] = replace(columns[k], guess=guess, factor=factor, offset=offset)
        return replace(self, columns=tuple(columns))


def _told(path: Path, content: bytes | None) -> Told | None:
    if content is None:
        return None
    path.write_bytes(content)
    return read_mapping(path)


def _table(path: Path, mapping: Told | None) -> tuple[Table, Mapping[str, object]]:
    """The first table of a file that holds numbers, and how it has to be read."""
    wrong: DataError | None = None
    for layout in (mapping.layout,) if mapping else LAYOUTS:
        how = mapping or (Told("columns.toml", {}, layout, read_runs(path, {})) if layout else None)
        try:
            return read_tables(path, how)[0], layout
        except DataError as error:
            wrong = wrong or error
    assert wrong is not None
    raise wrong


def _columns(table: Table, mapping: Told | None) -> tuple[DraftColumn, ...]:
    block = next(iter(table.read(range(len(table.names)))), None)
    cells = [[] if block is None else list(block.cells[k][:ROWS]) for k in range(len(table.names))]
    numbers = [np.array([number_of(cell, table.decimal) for cell in column]) for column in cells]
    guesses = guess_columns(table.headers, numbers) if mapping is None or not mapping.columns else None
    found = []
    for k, (name, column, values) in enumerate(zip(table.names, cells, numbers, strict=True)):
        later = [] if block is None else block.cells[k][ROWS :: max(len(block.cells[k]) // ROWS, 1)]
        finite = np.array([*values, *(number_of(cell, table.decimal) for cell in later)])
        finite = finite[np.isfinite(finite)]
        low, high = (float(finite.min()), float(finite.max())) if len(finite) else (np.nan, np.nan)
        text = tuple(f"{cell:.6g}" if isinstance(cell, float) else str(cell)[:24] for cell in column[:SHOWN])
        guess = guesses[k] if guesses else Guess()
        one = DraftColumn(name, text, low, high, guess, float(guess.factor))
        found.append(one if guesses else _as_told(one, k, table, mapping))
    return tuple(found)


def _as_told(one: DraftColumn, k: int, table: Table, mapping: Told | None) -> DraftColumn:
    """A column as a columns.toml has it."""
    for key, entry in mapping.columns.items() if mapping else ():
        if entry.get("column") in (k + 1, one.name, table.headers[k]):
            quantity, unit = split_header(key)
            guess = Guess(quantity, unit or "", True)
            return replace(one, guess=guess, factor=entry.get("factor", 1.0), offset=entry.get("offset", 0.0))
    return one


def _entry(columns: tuple[DraftColumn, ...], k: int) -> str:
    """A column's line of a columns.toml; a unit other than the header's is meant, which a factor says."""
    one = columns[k]
    key, where = one.guess.key, column_of([column.name for column in columns], k)
    stated = split_header(one.name)[1]
    if one.factor == 1.0 and one.offset == 0.0 and stated in (None, one.guess.unit):
        return f"{key} = {where}"
    shift = f", offset = {one.offset!r}" if one.offset or stated else ""
    return f"{key} = {{ column = {where}, factor = {one.factor!r}{shift} }}"


def safe_name(name: str) -> str:
    """The last part of a name without anything that a file system or a shell could take for more than a name."""
    return UNSAFE.sub("_", name.replace("\\", "/").rpartition("/")[2])[-80:] or "record.csv"


def read_dropped(files: Mapping[str, bytes], specimen: Specimen | None) -> tuple[Record, str]:
    """The record of one or several files, and its name; specimen.toml and columns.toml may be among them.

    `specimen` is taken where the files bring none. Raises UsageError without a record among them, DataError as
    `read_record` does and for a file that is far larger than it looks.
    """
    named = {safe_name(name): content for name, content in files.items()}
    if len(named) < len(files):
        raise UsageError("two of the files have the same name; rename one of them")
    runs = [name for name in named if name.lower() not in COMPANIONS]
    if not runs:
        raise UsageError("no record among the files; drop a file of measurements, specimen.toml beside it")
    given = next((name for name in named if name.lower() == COMPANIONS[0]), None)
    with TemporaryDirectory(prefix="pam-ident-") as place:
        for name, content in named.items():
            Path(place, name.lower() if name.lower() in COMPANIONS else name).write_bytes(content)
        path = Path(place, runs[0]) if len(runs) == 1 else Path(place)
        try:
            for name in runs:
                check_unpacked(Path(place, name), MOST_UNPACKED)
            record = read_record(path, None if given else specimen)
        except PamError as error:
            raise type(error)(here(str(error), place)) from None
    known_as = runs[0] if len(runs) == 1 else "the files"
    notes = tuple(replace(note, text=here(note.text, place)) for note in record.notes)
    columns = {key: here(header, place) for key, header in record.columns.items()}
    return replace(record, source=known_as, notes=notes, columns=columns), known_as


def here(text: str, place: str) -> str:
    """A text without the folder of this machine in which the files lay for a moment."""
    return text.replace(f"{place}/", "").replace(place, "the files")
