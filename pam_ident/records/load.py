"""Read a record (CSV) and its specimen (TOML). Every refusal names file, row and column."""

import hashlib
import tomllib
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ..core import DataError, Sensors, Specimen
from ..core.units import TO_INTERNAL, conversion, split_header
from .record import Record, build_record

QUANTITIES = {
    "time": "time",
    "pressure": "pressure",
    "pressure_set": "pressure",
    "displacement": "length",
    "contraction": "ratio",
    "length": "length",
    "force": "force",
    "temperature": "temperature",
    "cycle": "ratio",
    "branch": "text",
    "slack": "ratio",
}
SHAPES = ("displacement", "contraction", "length")
BRANCHES = {"contraction": 1.0, "extension": -1.0}


def read_record(path: str | Path, specimen: str | Path | Specimen | None = None) -> Record:
    """Load a CSV record and its specimen (given, or `specimen.toml` in the same folder).

    Columns are found by name and unit: pressure and force, one of displacement, contraction or length;
    optional time, pressure_set, cycle, branch, temperature and slack (rows with slack = 1 are left out).
    Raises DataError naming file, row and column.
    """
    path = Path(path)
    if not isinstance(specimen, Specimen):
        specimen = read_specimen(specimen if specimen is not None else path.parent / "specimen.toml", path)
    frame = _read_frame(path)
    where = _find_columns(path, list(frame.columns))
    values = {key: _numbers(path, frame, column, key) for key, column in where.items() if key != "branch"}
    keep = values.pop("slack", np.zeros(len(frame))) == 0.0
    if not keep.any():
        raise DataError(f"{path}: every row is marked as slack; nothing is left to fit")
    length = specimen.initial_length_mm
    if "contraction" in values:
        contraction = values["contraction"]
    elif "displacement" in values:
        contraction = values["displacement"] / length
    else:
        contraction = 1.0 - values["length"] / length
    _check_ranges(path, where, values, contraction)
    direction = _directions(path, frame, where["branch"])[keep] if "branch" in where else None
    optional = {key: values[key][keep] if key in values else None for key in ("time", "cycle", "temperature")}
    return build_record(
        path.stem if path.stem != "record" else specimen.name,
        specimen,
        values["pressure"][keep],
        contraction[keep],
        values["force"][keep],
        level=values["pressure_set"][keep] if "pressure_set" in values else None,
        direction=direction,
        source=str(path),
        sha256=file_sha256(path),
        columns=where,
        masked=int((~keep).sum()),
        **optional,
    )


def read_specimen(path: str | Path, record: Path | None = None) -> Specimen:
    """Read the table [specimen] of a TOML file. Raises DataError for missing keys or values out of range."""
    path = Path(path)
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        beside = f" beside {record}" if record else ""
        raise DataError(
            f"{path}: no specimen file{beside}; write one with a table [specimen] (name, initial_length_mm, "
            "initial_radius_mm, braid_angle_deg) or pass --specimen FILE"
        ) from None
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise DataError(f"{path}: not a readable TOML file ({error})") from None
    table = content.get("specimen")
    if not isinstance(table, dict):
        raise DataError(
            f"{path}: no table [specimen]; expected name, initial_length_mm, initial_radius_mm, braid_angle_deg"
        )
    given: dict[str, Any] = {}
    for item in fields(Specimen):
        if item.name == "name" and item.name in table:
            given["name"] = str(table["name"])
        elif item.name in table and item.name != "sensors":
            given[item.name] = _toml_number(path, "specimen", item.name, table[item.name])
        elif item.name not in ("wall_thickness_mm", "sensors"):
            raise DataError(f"{path}: [specimen] lacks {item.name}; add it")
    try:
        return Specimen(**given, sensors=_read_sensors(path, content.get("sensors")))
    except DataError as error:
        raise DataError(f"{path}: {error}") from None


def _read_sensors(path: Path, table: object) -> Sensors | None:
    """The optional table [sensors]."""
    if table is None:
        return None
    names = [item.name for item in fields(Sensors)]
    if not isinstance(table, dict) or "force_N" not in table or not set(table) <= set(names):
        raise DataError(f"{path}: [sensors] needs force_N and may hold {', '.join(names[1:])}, standard deviations")
    return Sensors(**{name: _toml_number(path, "sensors", name, value) for name, value in table.items()})


def _toml_number(path: Path, table: str, name: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise DataError(f"{path}: [{table}] {name} = {value!r}; expected a number")
    return float(value)


def file_sha256(path: str | Path) -> str:
    """Hash of a file's bytes, for the provenance of a result."""
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


def _read_frame(path: Path) -> pd.DataFrame:
    try:
        frame = pd.read_csv(path, encoding="utf-8-sig", skipinitialspace=True, low_memory=False)
    except FileNotFoundError:
        raise DataError(f"{path}: no such file; give the path of a CSV record") from None
    except pd.errors.EmptyDataError:
        raise DataError(f"{path}: the file is empty; expected a header row and one row a sample") from None
    except (OSError, UnicodeDecodeError, pd.errors.ParserError) as error:
        raise DataError(f"{path}: not a readable CSV file ({str(error).strip()})") from None
    if frame.empty:
        raise DataError(f"{path}: a header but no rows; expected one row a sample")
    return frame


def _find_columns(path: Path, headers: list[str]) -> dict[str, str]:
    found: dict[str, str] = {}
    for header in headers:
        name, _ = split_header(str(header))
        if name in QUANTITIES:
            if name in found:
                raise DataError(f"{path}: columns {found[name]!r} and {header!r} are both {name}; keep one")
            found[name] = str(header)
    for header in map(str, headers):
        first = header.rpartition(".")[0]
        if header.rpartition(".")[2].isdigit() and first in headers:
            raise DataError(f"{path}, row 1: two columns are called {first!r}; keep one")
        name, _, unit = split_header(header)[0].rpartition("_")
        if name in QUANTITIES and name not in found and split_header(header)[0] not in QUANTITIES:
            raise DataError(
                f"{path}, row 1, column {header!r}: unknown unit {unit!r} for {name}; expected one of "
                f"{', '.join(TO_INTERNAL.get(QUANTITIES[name], ()))}, or another name if it is something else"
            )
    for need in ("pressure", "force"):
        if need not in found:
            raise DataError(
                f"{path}, row 1: no {need} column among {', '.join(map(str, headers))}; "
                f"name it {'pressure_MPa' if need == 'pressure' else 'force_N'} (or with another unit)"
            )
    shapes = [key for key in SHAPES if key in found]
    if not shapes:
        raise DataError(
            f"{path}, row 1: no displacement_mm, contraction, contraction_pct or length_mm column "
            f"among {', '.join(map(str, headers))}; name one of them so"
        )
    if len(shapes) > 1:
        raise DataError(f"{path}, row 1: columns {' and '.join(found[k] for k in shapes)} say the same thing; keep one")
    return found


def _numbers(path: Path, frame: pd.DataFrame, column: str, key: str) -> np.ndarray:
    """One column in internal units, shape (n,)."""
    _, unit = split_header(column)
    factor, offset = conversion(QUANTITIES[key], unit, f"{path}, column {column!r}")
    numbers = np.asarray(pd.to_numeric(frame[column], errors="coerce"), dtype=float)
    bad = np.flatnonzero(~np.isfinite(numbers))
    if len(bad):
        row, cell = int(bad[0]), frame[column].iloc[int(bad[0])]
        what = "is empty or NaN" if pd.isna(cell) else f"holds {str(cell)[:40]!r}"
        more = f" (and {len(bad) - 1} more rows)" if len(bad) > 1 else ""
        raise DataError(
            f"{path}, row {row + 2}, column {column!r}: {what}{more}; expected a number. Mend or delete the row"
        )
    return numbers * factor + offset


def _directions(path: Path, frame: pd.DataFrame, column: str) -> np.ndarray:
    words = frame[column].astype(str).str.strip().str.lower()
    numbers = words.map(BRANCHES).to_numpy(float)
    bad = np.flatnonzero(np.isnan(numbers))
    if len(bad):
        raise DataError(
            f"{path}, row {int(bad[0]) + 2}, column {column!r}: holds {words.iloc[int(bad[0])][:40]!r}; "
            "expected contraction or extension"
        )
    return numbers


def _check_ranges(path: Path, where: dict[str, str], values: dict[str, np.ndarray], contraction: np.ndarray) -> None:
    if "time" in values:
        back = np.flatnonzero(np.diff(values["time"]) < 0.0)
        if len(back):
            row = int(back[0]) + 1
            raise DataError(
                f"{path}, row {row + 2}, column {where['time']!r}: time runs backwards "
                f"({values['time'][row - 1]:g} s, then {values['time'][row]:g} s); sort the rows or mend the clock"
            )
    wild = np.flatnonzero(np.abs(contraction) >= 0.95)
    if len(wild):
        key = next(k for k in SHAPES if k in where)
        raise DataError(
            f"{path}, row {int(wild[0]) + 2}, column {where[key]!r}: contraction ratio {contraction[wild[0]]:.3g}; "
            "expected within -0.95 to 0.95. Check the unit of the column and initial_length_mm of the specimen"
        )
    high = np.flatnonzero(np.abs(values["pressure"]) > 10.0)
    if len(high):
        raise DataError(
            f"{path}, row {int(high[0]) + 2}, column {where['pressure']!r}: {values['pressure'][high[0]]:g} MPa; "
            "expected a gauge pressure below 10 MPa. Check the unit of the column"
        )
