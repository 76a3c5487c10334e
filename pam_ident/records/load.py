"""Read a record, one file or several, and its specimen. Every refusal names file, row and column."""

import hashlib
import os
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..core import DataError, Specimen
from .clipped import clipped_rows, slack_rows
from .columns import join_runs, read_columns
from .files import Files, find_files, read_tables
from .guess import is_log, likely_clock
from .isobars import between, between_lengths
from .mapping import Mapping, read_mapping
from .notes import Notes
from .package import read_metadata
from .quantities import SHAPES, Source
from .ranges import Values, contraction_of
from .record import Record, build_record
from .run_constants import on_length
from .sources import Finder, find_sources, passed_over
from .specimen_file import read_kind, read_specimen
from .table import Table, table_in_memory

if TYPE_CHECKING:
    import pandas as pd


def between_isobars(record: Record) -> np.ndarray:
    """Mask (n,) of the samples between the isobars of a record, none where it is another kind of test or its isobars
    were told."""
    told = "pressure_set" in record.columns
    return np.zeros(len(record), bool) if told else _if_kind_without(record, "isobaric", between)


def between_held_lengths(record: Record) -> np.ndarray:
    """Mask (n,) of the samples in which a locked muscle is moved to its next length, none in another kind of test."""
    other = record.kind != "isometric"
    return np.zeros(len(record), bool) if other else _if_kind_without(record, "isometric", between_lengths)


def _if_kind_without(record: Record, kind: str, find: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> np.ndarray:
    """The mask (n,) that is found by pressure and contraction, if the record without its samples is a test of that
    kind; else none."""
    out = find(record.inputs.pressure, record.inputs.contraction)
    fits = out.any() and record.take(np.flatnonzero(~out)).kind == kind
    return out if fits else np.zeros(len(record), bool)


UNFIT = (
    ("between", "pressure", between_isobars),
    ("between_lengths", "length", between_held_lengths),
    ("clipped", "force", lambda r: clipped_rows(r.inputs, r.force)),
    ("slack", "force", slack_rows),
)
"""What is found in a record in time that tells nothing of a law: the note's code, its quantity, and a mask of the rows.
"""


def read_record(
    path: str | Path,
    specimen: str | Path | Specimen | None = None,
    columns: str | Path | None = None,
    find: Finder = find_sources,
) -> Record:
    """Load a record and its specimen.

    Args:
        path: a file (CSV and other text, .xlsx, .mat, .tdms, .lvm, .parquet; the text ones gzipped too), or several
            that are runs of one test: a folder, also a Data Package, or a pattern such as `runs/*.csv`. Columns are
            found by name and unit: pressure and force, one of displacement, contraction or length; optional time,
            pressure_set, cycle, branch, temperature and slack (rows with slack = 1 are left out).
        specimen: the muscle, or its file; by default `specimen.toml` in the same folder.
        columns: a file that says which column is what; by default `columns.toml` in the same folder, if there is one.
        find: what finds the columns where no such file does; by default those of a record.

    Raises:
        DataError: naming file, row and column.
        UsageError: where a format needs a package that is not installed.

    Example:
        >>> from pam_ident.records import read_record
        >>> from pam_ident.records.datasets import dataset_record
        >>> record = read_record(dataset_record("dmsp20_300"))
        >>> print(f"{record.name}: {len(record)} samples, up to {record.force.max():.0f} N")
        DMSP-20-300: 60 samples, up to 1654 N
    """
    files = find_files(path)
    muscle = specimen_of(files, specimen)
    where: dict[str, list[str]] = {}
    runs: list[Values] = []
    run_names: list[str] = []
    notes = Notes()
    passed: tuple[str, ...] = ()
    clock = ""
    for table, sources, length_mm in tables_of(files, columns, muscle, notes, find):
        for values in read_columns(table, sources, length_mm, notes):
            for group, number in (("run", len(runs)), ("muscle", length_mm)):
                values[group] = np.full(len(values["force"]), number)
            runs.append(on_length(values, length_mm, muscle.initial_length_mm))
            run_names.append(table.place)
        if not where:
            passed, clock = left_out(table, sources)
        for name, header in headers(sources).items():
            where.setdefault(name, []).append(header)
    values = join_runs(runs, str(path))
    del runs
    names = record_name(files, muscle), files.given, files_sha256(files)
    note_clock(notes, values, muscle, passed, clock)
    found = build_loaded(*names, muscle, values, _in_one(where), notes, said_kind(files, specimen, columns))
    return replace(found, metadata=read_metadata(files.folder), passed=passed, runs=_called(run_names, files.folder))


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
    passed, clock = left_out(table, sources)
    note_clock(notes, values, specimen, passed, clock)
    found = build_loaded(name or specimen.name, name or "table", "", specimen, values, headers(sources), notes)
    return replace(found, passed=passed)


def left_out(table: Table, sources: dict[str, Source]) -> tuple[tuple[str, ...], str]:
    """The headers of the columns of a table that are passed over, and the one that looks like a clock where none is
    read, empty for none."""
    at = passed_over(table, sources)
    return tuple(table.headers[k] for k in at), "" if "time" in sources else likely_clock(table, at)


def _called(places: list[str], folder: Path) -> tuple[str, ...]:
    """What runs are called that were read from `places`: those, in a folder, and a number where one holds several."""
    short = [place.removeprefix(f"{folder}{os.sep}") for place in places]
    many = {name for name in short if short.count(name) > 1}
    return tuple(f"{name}, run {short[: k + 1].count(name)}" if name in many else name for k, name in enumerate(short))


def note_clock(notes: Notes, values: Values, specimen: Specimen, passed: tuple[str, ...], clock: str) -> None:
    """Note where the rows of a record without a time look like a log."""
    if "time" not in values and is_log(values, contraction_of(values, specimen.initial_length_mm), clock):
        notes.add("no_clock", clock or None, ", ".join(map(repr, passed))[:200])


def specimen_of(files: Files, given: str | Path | Specimen | None) -> Specimen:
    """The specimen given, or of the file given, or of `specimen.toml` beside the record. Raises DataError."""
    if isinstance(given, Specimen):
        return given
    return read_specimen(given if given is not None else _beside(files), Path(files.given))


def said_kind(files: Files, given: str | Path | Specimen | None, columns: str | Path | None) -> str:
    """The kind of test that columns.toml or the specimen's file says, empty where neither does. Raises DataError."""
    mapping = read_mapping(columns) if columns is not None else files.mapping
    if mapping is not None and mapping.kind:
        return mapping.kind
    return "" if isinstance(given, Specimen) else read_kind(given if given is not None else _beside(files))


def _beside(files: Files) -> Path:
    return files.folder / "specimen.toml"


def tables_of(
    files: Files, columns: str | Path | None, specimen: Specimen, notes: Notes, find: Finder = find_sources
) -> Iterator[tuple[Table, dict[str, Source], float]]:
    """The tables of a record's files with their columns, as `columns` or `columns.toml` says, and the initial length in
    mm of each run's muscle. Raises DataError."""
    mapping = read_mapping(columns) if columns is not None else files.mapping
    names, lengths = [file.name for file in files.paths], []
    if mapping is not None:
        mapping.runs.check(files.folder, names, set(mapping.for_all))
        for quantity, told in mapping.for_all.items():
            alike = [name for name in names if quantity not in mapping.runs.sources(name, has_force=False)]
            if len(alike) > 1:
                key, _, value = told.partition(" = ")
                notes.add("one_for_all_runs", key, value, len(alike))
    for file in files.paths:
        length_mm = specimen.initial_length_mm
        if mapping is not None:
            length_mm = mapping.runs.initial_length_mm(file.name, files.folder, specimen)
        lengths += [length_mm] if length_mm != specimen.initial_length_mm else []
        for table, sources in _chosen(read_tables(file, mapping), mapping, file.name, find, notes):
            yield table, sources, length_mm
    if lengths:
        span = f"{min(lengths):g} to {max(lengths):g} mm, the specimen's {specimen.initial_length_mm:g}"
        notes.add("run_lengths", "initial_length_mm", span, len(lengths))


def headers(sources: dict[str, Source]) -> dict[str, str]:
    """What was read as what: header by quantity."""
    return {key: source.header for key, source in sources.items()}


def _in_one(where: dict[str, list[str]]) -> dict[str, str]:
    """The header of each quantity; where runs differ the first and the last."""
    told = {name: list(dict.fromkeys(headers)) for name, headers in where.items()}
    return {name: " … ".join((one[0], one[-1])) if len(one) > 1 else one[0] for name, one in told.items()}


def record_name(files: Files, specimen: Specimen) -> str:
    """The file's name, or the specimen's where the file has none that says anything."""
    return specimen.name if files.name in ("", "record") else files.name


def nothing_left(given: str) -> DataError:
    """The error of a record whose rows are all slack."""
    return DataError(f"{given}: every row is marked as slack; nothing is left to fit")


def build_loaded(
    name: str,
    given: str,
    sha256: str,
    specimen: Specimen,
    values: Values,
    where: dict[str, str],
    notes: Notes,
    said_kind: str = "",
) -> Record:
    """A record from values in internal units, less its slack and its clipped rows; `given` is its source, `where` maps
    quantities to columns. Raises DataError where nothing is left."""
    slack = values.pop("slack", None)
    masked = 0
    if slack is not None:
        keep = slack == 0.0
        if not keep.any():
            raise nothing_left(given)
        values = {key: column[keep] for key, column in values.items()}
        masked = int((~keep).sum())
    found = build_record(
        name,
        specimen,
        values["pressure"],
        contraction_of(values, specimen.initial_length_mm),
        values["force"],
        level=values.get("pressure_set"),
        direction=values.get("branch"),
        source=given,
        sha256=sha256,
        columns=where,
        masked=masked,
        said_kind=said_kind,
        groups={key: values[key] for key in ("run", "muscle", "cycle") if key in values},
        **{key: values.get(key) for key in ("time", "cycle", "temperature")},
    )
    if found.inputs.time is not None:  # the motion goes on meanwhile
        for code, key, rows_of in UNFIT:
            out = rows_of(found)
            if out.any():
                column = next((where[one] for one in (key, *SHAPES, "angle") if one in where), key)
                notes.add(code, column, f"sample {int(out.argmax()) + 1}", int(out.sum()))
                found = found.take(np.flatnonzero(~out))
    return replace(found, notes=notes.told())


def _chosen(
    tables: list[Table], mapping: Mapping | None, run: str, find: Finder, notes: Notes
) -> list[tuple[Table, dict[str, Source]]]:
    """The tables of a file that hold a record, with their columns; where some do by name, those alone. The others are
    noted. Raises what is wrong with the first if none does."""
    by_name, guessed, wrong = [], [], []
    for table in tables:
        try:
            sources = _sources(table, mapping, run, find)
        except DataError as error:
            wrong.append((table, error))
        else:
            told = not any(source.guessed for key, source in sources.items() if key != "time")
            (by_name if told else guessed).append((table, sources))
    if not (by_name or guessed):
        raise wrong[0][1]
    for table, error in wrong:
        notes.add("other_table", table.place, str(error).partition(": ")[2].partition(";")[0])
    for table, _ in guessed if by_name else ():
        notes.add("other_table", table.place, "another table names its columns")
    return by_name or guessed


def _sources(table: Table, mapping: Mapping | None, run: str, find: Finder) -> dict[str, Source]:
    try:
        return mapping.sources(table, run) if mapping else find(table)
    except DataError:
        if mapping is None or find is find_sources:
            raise
        return find(table)  # a columns.toml beside states is of the records there, whose columns they may lack


def file_sha256(path: str | Path) -> str:
    """Hash of a file's bytes, for the provenance of a result."""
    with Path(path).open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def files_sha256(files: Files) -> str:
    """Hash of the file, or of the several files' hashes in order."""
    hashes = [file_sha256(path) for path in files.paths]
    return hashes[0] if len(hashes) == 1 else hashlib.sha256("".join(hashes).encode()).hexdigest()
